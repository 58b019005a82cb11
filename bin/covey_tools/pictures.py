# SPDX-License-Identifier: BSD-3-Clause
"""The pictures of a demo: snapshots/*.png by viewer_offscreen, and the plots of the report.

Trajectories are turned for pictures so that up is up: by truth where it is known, else by the plane that the robots' ways
are closest to (a camera's or a vehicle's own axes need not be level). The files in traj/ stay as they are.
"""

import os
import tempfile

import numpy

from covey_tools import evaluation, figures, motion, programs


def draw(facts, out, world, trajectories):
    """Writes the pictures that can be made; returns [(file in snapshots/, caption)] in the order to show them."""
    folder = os.path.join(out, "snapshots")
    T_picture_W = _upright(trajectories)
    odometry = {robot: motion.moved(poses, T_picture_W) for robot, poses in trajectories.vio.items()}
    team = {robot: motion.moved(poses, T_picture_W) for robot, poses in trajectories.team.items() if poses}
    shown = []
    with tempfile.TemporaryDirectory() as work:
        stages = [("before", "Before: each robot's odometry by itself", odometry), ("after", "After: the team's solution", team)]
        panels = []
        for name, title, robots in stages:
            if len(robots) < len(odometry):
                continue  # not every robot has a solution
            scene = _Scene(work, name, robots, trajectories, out, world)
            panels.append((title, robots, scene.closures()))
            scene.render(os.path.join(folder, f"{name}.png"), title)
        figures.trajectories(os.path.join(folder, "plan.png"), panels, trajectories.truth)
        shown.append(("plan.png", "Seen from above. Green lines join the ends of closures that were kept, red ones of those rejected; truth is grey."))
        shown += [(f"{name}_oblique.png", title) for name, title, robots in stages if os.path.exists(os.path.join(folder, f"{name}_oblique.png"))]
    costs = [(each["s"], each["cost"]) for each in facts["team"].get("cost_by_round", [])]
    if costs:
        figures.cost_by_round(os.path.join(folder, "cost.png"), costs, facts["team"].get("cost_centralized"))
        shown.append(("cost.png", "Robust cost at the end of each round, while data kept coming."))
    figures.bytes_by_module(os.path.join(folder, "bytes.png"), facts["communication_bytes"])
    shown.append(("bytes.png", "What the robots sent to each other, by module."))
    return shown


class _Scene:
    """One stage's trajectories as files for the programs."""

    def __init__(self, work, name, robots, trajectories, out, world):
        self._robots = robots
        self._truth = trajectories.truth_files
        self._files = []
        for robot, poses in robots.items():
            self._files.append(os.path.join(work, f"{name}{robot}.tum"))
            motion.write_tum(self._files[-1], poses)
        self._loops = os.path.join(work, f"{name}.loops")
        evaluation.evaluate_graph(os.path.join(out, "graph"), self._files, world.barc2, (), [os.path.join(out, "results.lcm")], self._loops)

    def closures(self):
        """(x0, y0, x1, y1, accepted), rejected ones first."""
        with open(self._loops, encoding="ascii") as file:
            rows = [line.split() for line in file]
        closures = [(float(x0), float(y0), float(x1), float(y1), kind == "accepted") for x0, y0, _, x1, y1, _, kind in rows]
        return sorted(closures, key=lambda closure: closure[4])

    def render(self, path, title):
        arguments = ["--out", path, "--view", "both", "--title", title, "--loops", self._loops]
        for robot, file in zip(self._robots, self._files):
            arguments += ["--trajectory", f"robot {robot}={file},{figures.colour(robot)}"]
        for index, file in enumerate(self._truth):
            arguments += ["--reference", file if index else f"truth={file}"]
        programs.run("viewer_offscreen", arguments)


def _upright(trajectories):
    """T_picture_W."""
    if trajectories.T_truth_W is not None:
        return trajectories.T_truth_W
    positions = numpy.array([pose[1] for poses in trajectories.team.values() for _, pose in poses] or [(0.0, 0.0, 0.0)])
    _, _, axes = numpy.linalg.svd(positions - positions.mean(axis=0), full_matrices=True)
    if numpy.linalg.det(axes) < 0:
        axes[2] = -axes[2]
    return _quaternion(axes), (0.0, 0.0, 0.0)


def _quaternion(rotation):
    """(w, x, y, z) of a rotation matrix: the eigenvector of the largest eigenvalue (Bar-Itzhack, JGCD 2000)."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    k = numpy.array([[a - e - i, b + d, c + g, h - f], [b + d, e - a - i, f + h, c - g], [c + g, f + h, i - a - e, d - b], [h - f, c - g, d - b, a + e + i]])
    x, y, z, w = numpy.linalg.eigh(k)[1][:, 3]
    return float(w), float(x), float(y), float(z)
