# SPDX-License-Identifier: BSD-3-Clause
"""The sheet of a demo: a group of processes per robot, from a template, and a logger of the radio."""

import os
from dataclasses import dataclass

from covey_tools import bus, places
from covey_tools.errors import InputError


@dataclass(frozen=True)
class Kind:
    template: str  # in configs/sheets
    readers: tuple  # of each robot, in the order in which they start
    sources: tuple  # of each robot, when all readers of the team are there
    wait_for: tuple  # readers that say STATUS; () where it is enough that they run


GRAPH = Kind("pose_graph_robot.procman.in", ("logger", "radio_bridge", "dpgo"), ("player",), ())
SENSORS = Kind("sensor_robot.procman.in", ("logger", "radio_bridge", "dpgo", "lmo", "lcd", "mesher", "vio"),
               ("depth", "sensors"), ("radio_bridge", "dpgo", "lmo", "lcd", "mesher", "vio"))

_RADIO_LOGGER = """group "radio" {
    cmd "logger-air" {
        exec = "lcm-logger --quiet --append --lcm-url='udpm://%s:%d?ttl=0&recv_buf_size=4194304' '@OUT@/logs/air.lcm'";
        deputy = "radio";
        auto_respawn = "true";
        stop_signal = 2;
        stop_time_allowed = 3;
    }
}
"""


def write(path, kind, robots, values):
    """Writes the sheet; `values`: what stands for @NAME@ in the template (OUT, CONFIG, RADIO, SPEED and its own)."""
    with open(os.path.join(places.ROOT, "configs", "sheets", kind.template), encoding="utf-8") as file:
        template = file.read()
    parts = ["# Written by bin/demo for one run; try it again with: bin/sheet THIS_FILE start go\n"]
    parts.append(_fill(_RADIO_LOGGER % (bus.RADIO_GROUP, bus.RADIO_PORT), values))
    parts += [_fill(template, {**values, "ROBOT": robot, "PORT": bus.ROBOT_PORT + robot,
                               "SENSOR_PORT": bus.STEREO_PORT + robot, "DEPTH_PORT": bus.DEPTH_PORT + robot})
              for robot in range(robots)]
    parts.append(_script(kind, robots))
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(parts))


def wait_for(kind, robots):
    """Commands whose STATUS the sheet is to wait for."""
    return [f"{process}-{robot}" for process in kind.wait_for for robot in range(robots)]


def _fill(text, values):
    for name, value in values.items():
        if any(each in str(value) for each in "'\"\\\n$`"):
            raise InputError(f"'{value}': a path with quotes, backslashes or dollars cannot stand in a sheet; "
                             "choose another")
        text = text.replace(f"@{name}@", str(value))
    return text


def _script(kind, robots):
    """Readers before writers; streams would heal the other order too, but later."""
    actions = ['start cmd "logger-air"']
    actions += [f'start cmd "{process}-{robot}"' for process in kind.readers for robot in range(robots)]
    actions += [f'wait cmd "{process}-{robot}" status "running"'
                for process in kind.wait_for or kind.readers[-1:] for robot in range(robots)]
    actions += [f'start cmd "{process}-{robot}"' for process in kind.sources for robot in range(robots)]
    return 'script "go" {\n' + "".join(f"    {action};\n" for action in actions) + "}\n"
