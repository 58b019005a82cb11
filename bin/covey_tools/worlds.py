# SPDX-License-Identifier: BSD-3-Clause
"""The worlds of bin/demo: configs/worlds/<name>.yaml, and where the pose graph of each comes from.

A world is made of sensor data (town, rooms, euroc-v1: recordings.py has them made) or is a pose graph (grid, tunnels).
"""

import csv
import math
import os
from dataclasses import dataclass, field

from covey_tools import places, programs
from covey_tools.errors import InputError

FOLDER = os.path.join(places.ROOT, "configs", "worlds")


@dataclass
class World:
    name: str
    file: str  # the processes' --config
    robots: int
    seconds: float  # of data
    speed: float
    patience_s: float
    barc2: float
    has_sensors: bool = False


@dataclass
class Robot:
    """A robot, and what its file holds: of the pose graph, or its sensor log (then the counts come from the run)."""

    id: int
    file: str
    keyframes: int = 0
    loops: int = 0  # that it takes part in
    own_loops: int = 0  # those with itself
    truth: str = ""  # TUM file, where truth is known
    steps: list = field(default_factory=list)  # odometry in order: [qx, qy, qz, qw, tx, ty, tz]


def names():
    return sorted(os.path.splitext(name)[0] for name in os.listdir(FOLDER) if name.endswith(".yaml"))


def load(name):
    if name not in names():
        raise InputError(f"--world {name}: no such world; expected one of {', '.join(names())}")
    file = os.path.join(FOLDER, f"{name}.yaml")
    demo = read_section(file, "demo")
    config = os.path.normpath(os.path.join(FOLDER, demo["robot"])) if "robot" in demo else file
    return World(name, config, robots=int(demo["robots"]), seconds=float(demo["seconds"]), speed=float(demo["speed"]),
                 patience_s=float(demo["patience_s"]), barc2=_threshold(read_section(config, "dpgo")),
                 has_sensors="robot" in demo)


def _threshold(dpgo):
    """Of a closure's squared residual, as dpgo has it: barc2, or the chi-square quantile of `probability`."""
    if "barc2" in dpgo:
        return float(dpgo["barc2"])
    probability, low, high = float(dpgo.get("probability", 0.99)), 0.0, 1e3
    while high - low > 1e-9:  # 6 degrees of freedom: P(x) = 1 - exp(-x/2) (1 + x/2 + x^2/8)
        x = 0.5 * (low + high)
        reached = 1.0 - math.exp(-x / 2) * (1 + x / 2 + x * x / 8) >= probability
        low, high = (low, x) if reached else (x, high)
    return high


def read_section(file, section):
    """The scalars of one top-level section, as text; the processes read the same file with a real YAML parser."""
    values, inside = {}, False
    with open(file, encoding="utf-8") as lines:
        for line in lines:
            line = line.split("#")[0].rstrip()
            if line and not line[0].isspace():
                inside = line == f"{section}:"
            elif line and inside:
                key, _, value = line.strip().partition(":")
                values[key] = value.strip()
    return values


def check(world, data):
    """InputError where the world needs data that is not there."""
    if world.name == "tunnels" and not os.path.isdir(_recorded(data)):
        raise InputError(f"{os.path.normpath(_recorded(data))}: no such folder; give --data the folder that has "
                         "pose_graphs/tunnels, or take --world grid, which needs no data")
    if world.name.startswith("euroc") and not os.path.isdir(motion_folder(data)):
        raise InputError(f"{os.path.normpath(motion_folder(data))}: no such folder; give --data (or COVEY_DATA) the "
                         "folder that has euroc/motion, or take --world town, which needs no data")


def _recorded(data):
    return os.path.join(data, "pose_graphs", "tunnels")


def motion_folder(data):
    """The real motion and IMU that euroc worlds fly."""
    return os.path.join(data, "euroc", "motion")


def prepare_graph(world, seed, data, folder):
    """Puts the world's pose graph into `folder`, simulated or from `data`; returns its Robots."""
    if world.name == "tunnels":
        _cut(_recorded(data), world, folder)
    else:
        _simulate(world, seed, folder)
    return [_read_robot(folder, robot) for robot in range(world.robots)]


def _cut(source, world, folder):
    """The part of a recorded team that --robots and --seconds ask for, as files of their own."""
    os.makedirs(folder, exist_ok=True)
    for robot in range(world.robots):
        path = os.path.join(source, f"robot{robot}.csv")
        if not os.path.exists(path):
            raise InputError(f"{path} is missing; --robots {world.robots} is more than this team has")
        with open(path, encoding="ascii", newline="") as file, \
                open(os.path.join(folder, f"robot{robot}.csv"), "w", encoding="ascii", newline="") as out:
            reader = csv.DictReader(file)
            writer = csv.DictWriter(out, reader.fieldnames, lineterminator="\n")
            writer.writeheader()
            for row in reader:
                robots = int(row["robot_src"]), int(row["robot_dst"])
                poses = int(row["pose_src"]), int(row["pose_dst"])
                if max(robots) < world.robots and max(poses) < world.seconds:
                    writer.writerow(row)


def _simulate(world, seed, folder):
    programs.run("sim", ["--world", world.name, "--robots", str(world.robots), "--seconds", f"{world.seconds:g}",
                         "--seed", str(seed), "--config", world.file, "--graph", folder])


def _read_robot(folder, robot_id):
    robot = Robot(robot_id, os.path.join(folder, f"robot{robot_id}.csv"))
    truth = os.path.join(folder, f"robot{robot_id}_truth.tum")
    robot.truth = truth if os.path.exists(truth) else ""
    with open(robot.file, encoding="ascii", newline="") as file:
        for row in csv.DictReader(file):
            source_robot, source_pose, target_robot, target_pose = (
                int(row[name]) for name in ("robot_src", "pose_src", "robot_dst", "pose_dst"))
            own = source_robot == target_robot
            if own and target_pose == source_pose + 1:
                robot.steps.append([float(row[name]) for name in ("qx", "qy", "qz", "qw", "tx", "ty", "tz")])
            else:
                robot.loops += 1
                robot.own_loops += own
    robot.keyframes = len(robot.steps) + 1
    return robot
