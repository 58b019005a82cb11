# SPDX-License-Identifier: BSD-3-Clause
"""report.json: everything that a demo's run came to, as figures.

What a world cannot have is left out: without truth there are no ATEs, without images no meshes. What could not be
measured although it should have been stands in "notes", as sentences; whatever went wrong there, the rest is measured.
"""

import json
import os
import subprocess
import traceback
from dataclasses import dataclass

from covey_tools import contract, evaluation, funnels, meshes, motion, pictures, places
from covey_tools.errors import Failure, InputError
from covey_tools.results import GraphResults, SensorResults
from covey_tools.sensor_team import frames, frames_dropped
from covey_tools.team_run import Outcome
from covey_tools.worlds import World

# What a keyframe would cost if it were sent to a server instead (Kimera-Multi, T-RO 2022, section VI).
KEYPOINTS_BYTES = 48_300
IMAGES_BYTES = 722_000

MODULES = ("place_recognition", "geometric_verification", "dpgo", "control")


@dataclass
class Run:
    """A run that is over: what was asked for and what it left."""

    out: str  # folder
    world: World
    robots: list  # worlds.Robot
    outcome: Outcome
    radio: str
    seed: int
    recording: object = None  # recordings.Recording of a world with sensors

    def file(self, *names):
        return os.path.join(self.out, *names)


def make(run):
    """Measures, writes report.json, traj/ and the pictures; returns the report, and its "figures" for the page."""
    outcome = run.outcome
    facts = {
        "world": run.world.name,
        "seconds": outcome.data_s,
        "robots": [{"id": robot.id, "keyframes": robot.keyframes, "loops": robot.loops} for robot in run.robots],
        "team": {},
        "communication_bytes": {},
        "realtime_factor": outcome.data_s / outcome.wall_s if outcome.wall_s else None,
        "complete": outcome.reason == "done",
        "missing": outcome.missing,
        "notes": [],
        "remarks": [],
        "restarts": outcome.team.restarts(),
        "wall_seconds": outcome.wall_s,
        "speed": run.world.speed,
        "radio": os.path.basename(run.radio),
        "seed": run.seed,
        "barc2": run.world.barc2,
        "commit": _commit(),
    }
    figures = []
    sensors = run.world.has_sensors
    results = _attempt(facts, "trajectories", lambda: (SensorResults if sensors else GraphResults)(run))
    if results:
        for robot in facts["robots"]:
            robot["keyframes"], robot["loops"] = results.counts(robot["id"])
    facts["communication_bytes"] = _communication(facts, run)
    _attempt(facts, "rounds", lambda: _measure_rounds(facts, run))
    _attempt(facts, "radio", lambda: _check_air(facts, run))
    _attempt(facts, "poses at the time", lambda: _measure_online(facts, run))
    if sensors:
        _attempt(facts, "frames", lambda: _measure_frames(facts, run))
        _attempt(facts, "place recognition", lambda: _measure_funnels(facts, run))
    if results:
        for part, step in (("lengths", _measure_lengths), ("graph", _measure_graph), ("truth", _measure_truth),
                           ("central solution", _measure_central)):
            _attempt(facts, part, lambda each=step: each(facts, run, results))
        if sensors:
            _attempt(facts, "mesh", lambda: meshes.measure(facts, run, results))
        _attempt(facts, "pictures", lambda: figures.extend(pictures.draw(run, facts, results)))
    if outcome.reason == "done":
        facts["notes"] += contract.lacks(facts, sensors)
    with open(run.file("report.json"), "w", encoding="utf-8") as file:
        json.dump(facts, file, indent=2)
        file.write("\n")
    return {**facts, "figures": figures}


def _attempt(facts, part, step):
    """The step's result. One part that cannot be measured, or is a mistake of ours, is no reason to lose the others."""
    try:
        return step()
    except (Failure, InputError) as error:
        note = str(error)
    except Exception as error:  # noqa: whatever a damaged file or a mistake in the arithmetic may raise
        place = traceback.extract_tb(error.__traceback__)[-1]
        note = f"{part}: {type(error).__name__}: {error} ({os.path.basename(place.filename)}:{place.lineno})"
    if note not in facts["notes"]:
        facts["notes"].append(note)
    return None


def _communication(facts, run):
    sent = run.outcome.team.radio_bytes()
    keyframes = sum(robot["keyframes"] for robot in facts["robots"])
    return {**{name: sent.get(name, 0) for name in MODULES}, "total": sum(sent.values()),
            "centralized_keypoints": keyframes * KEYPOINTS_BYTES, "centralized_images": keyframes * IMAGES_BYTES}


def _check_air(facts, run):
    """The bridges' word against the radio's log. A process that is killed takes its last second of counts along."""
    said = facts["communication_bytes"]["total"]
    heard = evaluation.evaluate_radio(run.file("logs", "air.lcm"))["total"]["bytes"]
    facts["communication_bytes"]["on_air"] = heard
    if not facts["restarts"] and abs(said - heard) > 0.02 * max(said, heard) + 20_000:
        raise Failure(f"the bridges say they sent {said} bytes, the log of the radio has {heard}")


def _measure_frames(facts, run):
    """Image sets and the time that vio took for each, by its own word; a killed vio takes its last second along."""
    for robot in facts["robots"]:
        vio = run.outcome.team.said("vio", robot["id"])
        robot["frames"] = frames(vio)
        robot["frames_dropped"] = frames_dropped(vio)
        robot["vio_ms_mean"] = vio.gauges.get("frame_ms_mean")
        robot["vio_ms_p99"] = vio.gauges.get("frame_ms_p99")


def _measure_funnels(facts, run):
    """Of each pair of robots what became of the words that they heard from each other, by their loop finders' own word."""
    facts["place_recognition"] = funnels.of_pairs({robot.id: run.outcome.team.said("lcd", robot.id) for robot in run.robots})


def _measure_lengths(facts, run, results):
    for robot in facts["robots"]:
        ways = (each.get(robot["id"]) for each in (results.truth, results.team, results.vio))
        robot["length_m"] = motion.length(next(way for way in ways if way))


def _measure_rounds(facts, run):
    team = run.outcome.team
    updates = [team.said("dpgo", robot.id).gauges.get("updates", 0) for robot in run.robots]
    facts["team"].update({
        "time_to_common_frame_s": team.common_frame_s,
        "rounds": len({number for _, _, number, _, _ in team.rounds}),
        "dgnc_seconds": max(team.last_round_s.values(), default=None),
        "dgnc_iterations": int(sum(updates)),
        "cost_by_round": [{"s": round(elapsed_s, 3), "cost": cost} for elapsed_s, cost in team.costs()],
    })


def _measure_graph(facts, run, results):
    score = evaluation.evaluate_graph(results.graph, results.graph_files["team"], run.world.barc2,
                                      results.graph_files.get("truth", ()), [results.weights],
                                      limits=results.closure_limits)
    pairs = [{"a": pair["a"], "b": pair["b"], "met": pair["a"] == pair["b"] or (pair["a"], pair["b"]) in results.met,
              **pair} for pair in results.pairs(score["pairs"])]
    facts["team"].update({"cost": score["cost"], "loops": pairs, "loops_total": sum(pair["total"] for pair in pairs),
                          "loops_accepted": score["loops"]["accepted"]})
    facts["team"].update({name: score[name] for name in ("precision", "recall") if name in score})


def _measure_truth(facts, run, results):
    if not results.truth:
        return
    for kind, key, files in (("vio", "ate_vio_m", results.vio_files), ("team", "ate_m", results.team_files)):
        error = evaluation.evaluate_trajectories(files, results.truth_files)
        facts["team"][key] = error["ate_m"]
        for robot, each in zip(facts["robots"], error["robots"]):
            robot[f"ate_{kind}_m"] = each["with_team"]["rmse_m"]
        results.alignments[kind] = evaluation.alignment(error)


def _measure_online(facts, run):
    """What each robot believed when it took its keyframes, of those that it took with a pose in W."""
    truths = [robot.truth for robot in run.robots if robot.truth]
    if not truths:
        return
    logs = [run.file("logs", f"robot{robot.id}.lcm") for robot in run.robots]
    error = evaluation.evaluate_online(logs, truths)
    facts["team"]["keyframes_online"] = error["counted"]
    if error["counted"] or run.world.has_sensors:
        facts["team"]["ate_online_m"] = error.get("ate_m")


def _measure_central(facts, run, results):
    folder = run.file("central")
    central = evaluation.solve_centrally(results.graph, run.world.barc2, results.poses_per_file, folder)
    facts["team"].update({"cost_centralized": central.cost, "loops_accepted_centralized": central.kept_loops})
    if results.truth:
        files = results.in_time(central.files, folder)
        facts["team"]["ate_centralized_m"] = evaluation.evaluate_trajectories(files, results.truth_files)["ate_m"]


def _commit():
    command = ["git", "-C", places.ROOT, "rev-parse", "--short", "HEAD"]
    try:
        return subprocess.run(command, capture_output=True, text=True).stdout.strip() or None
    except OSError:
        return None
