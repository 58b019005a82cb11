# SPDX-License-Identifier: BSD-3-Clause
"""The meshes of a run against the world that the simulator drew.

Before: as each robot measured it, every robot's odometry put where truth has its first keyframe. After: deformed by lmo
to the team's solution, put where the trajectories' joint alignment has it, and nothing of its own. Completeness is the
mean distance to the mesh from what the robots' depth cameras could see.
"""

import os
import tempfile

from covey_tools import evaluation, ply
from covey_tools.errors import Failure


def measure(facts, run, results):
    """report.json's mesh, and mesh/merged.ply: all robots' meshes in W."""
    robots = [robot.id for robot in run.robots]
    after = [_read(run, robot, "team") for robot in robots]
    before = [_read(run, robot, "vio") for robot in robots]
    if all(after):
        ply.write(run.file("mesh", "merged.ply"), ply.merged(after))
    entries = []
    with tempfile.TemporaryDirectory() as work:
        scores = {}
        for stage, meshes, frames in (("before", before, [_odometry(results, robot) for robot in robots]),
                                      ("after", after, [results.alignments.get("team")] * len(robots))):
            placed = [mesh.moved(frame) if mesh and frame else None for mesh, frame in zip(meshes, frames)]
            whole = ply.merged(placed) if all(placed) else None
            truths = [*([robot.truth] for robot in run.robots), [robot.truth for robot in run.robots]]
            scores[stage] = [_score(run, mesh, seen_from, work) for mesh, seen_from in zip((*placed, whole), truths)]
        for robot, old, new in zip((*robots, "merged"), scores["before"], scores["after"]):
            entries.append({"robot": robot, "error_before_m": old.get("error_m"), "error_after_m": new.get("error_m"),
                            "completeness_after_m": new.get("completeness_m"), "labels_before": old.get("labels"),
                            "labels_after": new.get("labels")})
    facts["mesh"] = entries
    several = [robot for robot in robots if sum(owner == robot for owner, _ in results.T_truth_O) > 1]
    facts["remarks"] += [sentence for entry in entries for sentence in _remarks(entry, facts)]
    facts["remarks"] += [f"robot {robot}'s odometry was started again: its mesh before is of the first segment alone, "
                         "and after is of all" for robot in several]
    missing = [f"robot {robot} has no mesh" for robot, mesh in zip(robots, after) if not mesh]
    if missing:
        raise Failure("; ".join(missing))


def _read(run, robot, kind):
    path = run.file("mesh", f"robot{robot}_{kind}.ply")
    return ply.read(path) if os.path.exists(path) else None


def _odometry(results, robot):
    """T_truth_O of the robot's first segment."""
    first = min((segment for owner, segment in results.T_truth_O if owner == robot), default=None)
    return None if first is None else results.T_truth_O[robot, first]


def _score(run, mesh, seen_from, work):
    if not mesh or not len(mesh.corners):
        return {}
    file = os.path.join(work, "mesh.ply")
    ply.write(file, mesh)
    return evaluation.evaluate_mesh(file, run.recording.truth("world.ply"), seen_from, run.world.file)


def _remarks(entry, facts):
    """Why a mesh is not better after than before, where it is not."""
    for name, what, sign in (("error", "mesh error", 1), ("labels", "label accuracy", -1)):
        unit = "_m" if name == "error" else ""
        old, new = entry[f"{name}_before{unit}"], entry[f"{name}_after{unit}"]
        if old is not None and new is not None and sign * (new - old) > 0:
            whose = f"robot {entry['robot']}" if entry["robot"] != "merged" else "the merged mesh"
            ates = [robot for robot in facts["robots"] if robot["id"] == entry["robot"]] or [
                {"ate_vio_m": facts["team"].get("ate_vio_m"), "ate_team_m": facts["team"].get("ate_m")}]
            yield (f"{what} of {whose} is {new:.3f} after optimisation and {old:.3f} before: before, odometry stands "
                   f"where truth has its first keyframe and drifts from there (ATE {_metres(ates[0]['ate_vio_m'])}); "
                   f"after, nothing is known of truth (ATE {_metres(ates[0]['ate_team_m'])})")


def _metres(value):
    return "unknown" if value is None else f"{value:.3f} m"
