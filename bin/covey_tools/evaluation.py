# SPDX-License-Identifier: BSD-3-Clause
"""What a run's results are worth, by the programs that measure: evaluate and pgo."""

import json
import os
from dataclasses import dataclass

from covey_tools import motion, programs


def evaluate_trajectories(estimates, references):
    """evaluate trajectory: one joint alignment of all robots."""
    return _json("evaluate", ["trajectory", "--estimate", *estimates, "--reference", *references])


def evaluate_online(logs, references):
    """evaluate online: the poses that each robot believed at the time; logs of the robots' buses."""
    return _json("evaluate", ["online", "--log", *logs, "--reference", *references])


def evaluate_graph(graph, estimates, barc2, truths=(), logs=(), loops="", limits=()):
    """evaluate graph: robust cost and loop closures; `loops`: a file to list them in, for pictures.

    `limits`: m and degrees within which a closure is true; (): evaluate's.
    """
    arguments = ["graph", "--graph", graph, "--barc2", f"{barc2:g}", "--estimate", *estimates]
    arguments += ["--truth", *truths] if truths else []
    arguments += ["--log", *logs] if logs else []
    arguments += ["--loops", loops] if loops else []
    arguments += ["--true-within-m", f"{limits[0]:g}", "--true-within-deg", f"{limits[1]:g}"] if limits else []
    return _json("evaluate", arguments)


def evaluate_mesh(estimate, reference, seen_from, config):
    """evaluate mesh: distances between the surfaces, and how many labels agree; both in one frame.

    `seen_from`: the robots' true trajectories; the reference counts as far as their depth camera (`config`) could see it.
    """
    return _json("evaluate", ["mesh", "--estimate", estimate, "--reference", reference, "--seen-from", *seen_from,
                              "--config", config])


def evaluate_radio(log):
    """evaluate radio: bytes on the air."""
    return _json("evaluate", ["radio", "--log", log])


@dataclass
class Central:
    cost: float
    kept_loops: int
    files: list  # TUM, one per robot


def solve_centrally(graph, barc2, keyframes, folder):
    """pgo --solver gnc on the whole graph at once; keyframes: how many each robot (or chain) of it has."""
    os.makedirs(folder, exist_ok=True)
    out, tum = os.path.join(folder, "central.json"), os.path.join(folder, "central.tum")
    programs.run("pgo", ["--graph", graph, "--solver", "gnc", "--barc2", f"{barc2:g}", "--json", out, "--tum", tum])
    poses = [pose for _, pose in motion.read_tum(tum)]
    files, first = [], 0
    for robot, count in enumerate(keyframes):
        files.append(os.path.join(folder, f"robot{robot}.tum"))
        motion.write_tum(files[-1], [(index + 1.0, pose) for index, pose in enumerate(poses[first:first + count])])
        first += count
    score = evaluate_graph(graph, files, barc2)
    return Central(score["cost"], score["loops"]["accepted"], files)


def alignment(error):
    """The motion that evaluate found, reference from estimate."""
    w, x, y, z, *t = error["T_reference_estimate"]
    return (w, x, y, z), tuple(t)


def _json(program, arguments):
    return json.loads(programs.run(program, arguments))
