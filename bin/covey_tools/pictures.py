# SPDX-License-Identifier: BSD-3-Clause
"""The pictures of a demo: snapshots/*.png, 3D by viewer_offscreen and plots by matplotlib.

Trajectories are turned for pictures so that up is up: by truth where it is known, else by the plane that the robots'
ways are closest to (a camera's or a vehicle's own axes need not be level). The files in traj/ stay as they are.
"""

import math
import os
import tempfile

import numpy

from covey_tools import evaluation, figures, motion, ply, programs, sensor_view

SIZE = "1600x1200"  # of the viewer's pictures
_PLAN = "Seen from above. Lines join the two ends of loop closures: green kept, red rejected."
_TITLES = {"before": "Before: each robot's odometry by itself", "after": "After: the team's solution"}
_MESHES = (("rgb", "mesh_colour", "One mesh of all robots, in colour"),
           ("label", "mesh_labels", "One mesh of all robots, by label"),
           ("height", "mesh_height", "One mesh of all robots, by height"))
_ERRORS = "Distance from truth at each keyframe, after one alignment of all robots: odometry alone (thin) and the team's solution."


def draw(run, facts, results):
    """Writes the pictures that can be made; returns [(file in snapshots/, caption)] in the order to show them."""
    T_picture_W = _upright(results)
    stages = {"before": results.vio, "after": results.team}
    shown = []
    with tempfile.TemporaryDirectory() as work:
        scenes = [_Scene(run, results, work, name, {robot: motion.moved(way, T_picture_W) for robot, way in ways.items()})
                  for name, ways in stages.items() if all(ways.values())]  # a stage that some robot lacks is no picture
        figures.plan(run.file("snapshots", "plan.png"), [scene.panel() for scene in scenes], results.truth)
        if os.path.exists(run.file("mesh", "merged.ply")):
            shown += _draw_meshes(run, work, T_picture_W, scenes[-1] if scenes else None)
        shown.append(("plan.png", _PLAN))
        for scene in scenes:
            scene.render()
            shown.append((f"{scene.name}_oblique.png", _TITLES[scene.name]))
    if run.recording and len(results.alignments) == 2:
        figures.errors(run.file("snapshots", "errors.png"), _errors(results, "vio"), _errors(results, "team"))
        shown.append(("errors.png", _ERRORS))
    if run.recording:
        sensor_view.draw(run.file("snapshots", "cameras.png"), run.recording.log(0), run.world.seconds / 2,
                         run.recording.truth("labels.json"))
        shown.append(("cameras.png", "What robot 0 saw halfway."))
    costs = [(each["s"], each["cost"]) for each in facts["team"].get("cost_by_round", [])]
    if costs:
        figures.cost_by_round(run.file("snapshots", "cost.png"), costs, facts["team"].get("cost_centralized"))
        shown.append(("cost.png", "Robust cost at the end of each round, while data kept coming."))
    figures.bytes_by_module(run.file("snapshots", "bytes.png"), facts["communication_bytes"])
    shown.append(("bytes.png", "What the robots sent to each other, by module."))
    return shown


def _errors(results, stage):
    """{robot: [(s since its first keyframe, m)]}"""
    found = {}
    for robot, way in getattr(results, stage).items():
        placed = motion.moved(way, results.alignments[stage])
        truths = motion.at(results.truth[robot], [stamp for stamp, _ in placed])
        found[robot] = [(stamp - placed[0][0], math.dist(pose[1], truth[1]))
                        for (stamp, pose), truth in zip(placed, truths) if truth]
    return found


def _draw_meshes(run, work, T_picture_W, scene):
    """The merged mesh in colour, by label and by height, and the simulator's world by label to compare with."""
    upright = os.path.join(work, "merged.ply")
    ply.write(upright, ply.read(run.file("mesh", "merged.ply")).moved(T_picture_W))
    shown = []
    for colour, name, title in _MESHES:
        _draw_mesh(run, upright, colour, name, title, scene)
        shown.append((f"{name}_oblique.png", f"{title}."))
    world = run.recording.truth("world.ply")
    _draw_mesh(run, world, "label", "world_labels", "The simulator's world by label")
    return shown + [("mesh_labels_top.png", "The mesh by label, from above."),
                    ("world_labels_top.png", "Truth: the simulator's world by label, from above.")]


def _draw_mesh(run, file, colour, name, title, scene=None):
    """scene: whose ways are drawn along."""
    programs.run("viewer_offscreen", ["--mesh", file, "--mesh-colour", colour, "--view", "both", "--title", title,
                                      "--labels", run.recording.truth("labels.json"), "--size", SIZE,
                                      "--out", run.file("snapshots", f"{name}.png"), *(scene.ways() if scene else [])])


class _Scene:
    """All robots' ways at one stage, upright, and the loop closures between them."""

    def __init__(self, run, results, work, name, ways):
        self.name = name
        self._run = run
        self._ways = ways
        self._truth_files = results.truth_files
        self._loops = os.path.join(work, f"{name}.loops")
        self._files = {robot: os.path.join(work, f"{name}{robot}.tum") for robot in ways}
        for robot, file in self._files.items():
            motion.write_tum(file, ways[robot])
        numbered = results.write_for_graph(ways, os.path.join(work, name))
        evaluation.evaluate_graph(results.graph, numbered, run.world.barc2, (), [results.weights], self._loops)

    def panel(self):
        with open(self._loops, encoding="ascii") as file:
            rows = [line.split() for line in file]
        closures = [figures.Closure(float(x0), float(y0), float(x1), float(y1), kind == "accepted")
                    for x0, y0, _, x1, y1, _, kind in rows]
        return figures.Panel(_TITLES[self.name], self._ways, closures)

    def ways(self):
        """The viewer's arguments for them."""
        return [word for robot, file in self._files.items()
                for word in ("--trajectory", f"robot {robot}={file},{figures.colour(robot)}")]

    def render(self):
        out = self._run.file("snapshots", f"{self.name}.png")
        arguments = ["--out", out, "--view", "both", "--title", _TITLES[self.name], "--size", SIZE]
        if self.name == "after":  # before, thousands of them would hide the robots' ways
            arguments += ["--loops", self._loops]
        arguments += self.ways()
        for file in self._truth_files:
            arguments += ["--reference", f"truth={file}"]
        programs.run("viewer_offscreen", arguments)


def _upright(results):
    """T_picture_W."""
    if "team" in results.alignments:
        return results.alignments["team"]
    positions = numpy.array([t for way in results.team.values() for _, (_, t) in way] or [(0.0, 0.0, 0.0)])
    _, _, axes = numpy.linalg.svd(positions - positions.mean(axis=0), full_matrices=True)
    if numpy.linalg.det(axes) < 0:
        axes[2] = -axes[2]
    return _quaternion(axes), (0.0, 0.0, 0.0)


def _quaternion(rotation):
    """(w, x, y, z) of a rotation matrix: the eigenvector of the largest eigenvalue (Bar-Itzhack, JGCD 2000)."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    symmetric = [[a - e - i, b + d, c + g, h - f],
                 [b + d, e - a - i, f + h, c - g],
                 [c + g, f + h, i - a - e, d - b],
                 [h - f, c - g, d - b, a + e + i]]
    x, y, z, w = numpy.linalg.eigh(numpy.array(symmetric))[1][:, 3]
    return float(w), float(x), float(y), float(z)
