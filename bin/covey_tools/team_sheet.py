# SPDX-License-Identifier: BSD-3-Clause
"""The sheet of a demo: a group of processes per robot, from a template, and a logger of the radio."""

import os

from covey_tools import bus, places
from covey_tools.errors import InputError

TEMPLATE = os.path.join(places.ROOT, "configs", "sheets", "pose_graph_robot.procman.in")

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

PROCESSES = ("logger", "radio_bridge", "dpgo", "player")  # of each robot, in the order in which they start


def write(path, robots, values):
    """Writes the sheet; `values`: what stands for @NAME@ in the template (OUT, WORLD, RADIO, GRAPH, SPEED)."""
    with open(TEMPLATE, encoding="utf-8") as file:
        template = file.read()
    parts = ["# Written by bin/demo for one run; try it again with: bin/sheet THIS_FILE start go\n"]
    parts.append(_fill(_RADIO_LOGGER % (bus.RADIO_GROUP, bus.RADIO_PORT), values))
    parts += [_fill(template, {**values, "ROBOT": robot, "PORT": bus.ROBOT_PORT + robot}) for robot in range(robots)]
    parts.append(_script(robots))
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(parts))


def _fill(text, values):
    for name, value in values.items():
        if any(each in str(value) for each in "'\"\\\n$`"):
            raise InputError(f"'{value}': a path with quotes, backslashes or dollars cannot stand in a sheet; "
                             "choose another")
        text = text.replace(f"@{name}@", str(value))
    return text


def _script(robots):
    """Readers before writers; streams would heal the other order too, but later."""
    actions = ['start cmd "logger-air"']
    actions += [f'start cmd "{process}-{robot}"' for process in PROCESSES[:-1] for robot in range(robots)]
    actions += [f'wait cmd "dpgo-{robot}" status "running"' for robot in range(robots)]
    actions += [f'start cmd "player-{robot}"' for robot in range(robots)]
    return 'script "go" {\n' + "".join(f"    {action};\n" for action in actions) + "}\n"
