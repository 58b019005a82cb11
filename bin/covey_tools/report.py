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

from covey_tools import evaluation, lcm_log, messages, motion, pictures, places
from covey_tools.errors import Failure, InputError
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
        "communication_bytes": _communication(run),
        "realtime_factor": outcome.data_s / outcome.wall_s if outcome.wall_s else None,
        "complete": outcome.reason == "done",
        "missing": outcome.missing,
        "notes": [],
        "restarts": outcome.team.restarts(),
        "wall_seconds": outcome.wall_s,
        "radio": os.path.basename(run.radio),
        "seed": run.seed,
        "barc2": run.world.barc2,
        "commit": _commit(),
    }
    figures = []
    _attempt(facts, "rounds", lambda: _measure_rounds(facts, run))
    _attempt(facts, "radio", lambda: _check_air(facts, run))
    _attempt(facts, "poses at the time", lambda: _measure_online(facts, run))
    trajectories = _attempt(facts, "trajectories", lambda: Trajectories(run))
    if trajectories:
        for part, step in (("lengths", _measure_lengths), ("graph", _measure_graph), ("truth", _measure_truth),
                           ("central solution", _measure_central)):
            _attempt(facts, part, lambda each=step: each(facts, run, trajectories))
        _attempt(facts, "pictures", lambda: figures.extend(pictures.draw(run, facts, trajectories)))
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


class Trajectories:
    """The files in traj/, in W, the frame of the lowest robot's first keyframe, and truth in a frame of its own."""

    def __init__(self, run):
        self.team_files = [run.file("traj", f"robot{robot.id}_team.tum") for robot in run.robots]
        self.vio_files = [run.file("traj", f"robot{robot.id}_vio.tum") for robot in run.robots]
        self.truth_files = [robot.truth for robot in run.robots if robot.truth]
        self.T_truth_W = None  # known once the solution is aligned with truth
        self.team = {robot.id: motion.read_tum(file) if os.path.exists(file) else []
                     for robot, file in zip(run.robots, self.team_files)}
        self.truth = {robot.id: motion.read_tum(robot.truth) for robot in run.robots if robot.truth}
        self.vio = {robot.id: self._place(robot) for robot in run.robots}
        for robot, file in zip(run.robots, self.vio_files):
            motion.write_tum(file, self.vio[robot.id])

    def _place(self, robot):
        """Odometry alone, put where its first keyframe really was or, without truth, is in the solution."""
        odometry = motion.chain(robot.steps)
        if self.truth:
            T_W_truth = motion.inverse(self.truth[min(self.truth)][0][1])
            return motion.moved(odometry, motion.compose(T_W_truth, self.truth[robot.id][0][1]))
        return motion.moved(odometry, self.team[robot.id][0][1] if self.team[robot.id] else motion.IDENTITY)


def _communication(run):
    sent = run.outcome.team.radio_bytes()
    keyframes = sum(robot.keyframes for robot in run.robots)
    return {**{name: sent.get(name, 0) for name in MODULES}, "total": sum(sent.values()),
            "centralized_keypoints": keyframes * KEYPOINTS_BYTES, "centralized_images": keyframes * IMAGES_BYTES}


def _check_air(facts, run):
    """The bridges' word against the radio's log. A process that is killed takes its last second of counts along."""
    said = facts["communication_bytes"]["total"]
    heard = evaluation.evaluate_radio(run.file("logs", "air.lcm"))["total"]["bytes"]
    facts["communication_bytes"]["on_air"] = heard
    if not facts["restarts"] and abs(said - heard) > 0.02 * max(said, heard) + 20_000:
        raise Failure(f"the bridges say they sent {said} bytes, the log of the radio has {heard}")


def _measure_lengths(facts, run, trajectories):
    for robot in facts["robots"]:
        ways = (each.get(robot["id"]) for each in (trajectories.truth, trajectories.team, trajectories.vio))
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


def _measure_graph(facts, run, trajectories):
    score = evaluation.evaluate_graph(run.file("graph"), trajectories.team_files, run.world.barc2,
                                      trajectories.truth_files, [run.file("results.lcm")])
    together = _solved_together(run.file("results.lcm"))
    pairs = []
    for pair in score["pairs"]:
        a, b = pair.pop("a"), pair.pop("b")
        pairs.append({"a": a, "b": b, "met": a == b or (a, b) in together, **pair})
    facts["team"].update({"cost": score["cost"], "loops": pairs, "loops_total": score["loops"]["total"],
                          "loops_accepted": score["loops"]["accepted"]})
    facts["team"].update({name: score[name] for name in ("precision", "recall") if name in score})


def _solved_together(log):
    """Pairs of robots that finished a round together, from what they said of it (TRAJECTORY)."""
    members = {}  # (anchor, round) -> robots
    for event in lcm_log.Log(log):
        message = messages.decode("trajectory_t", event.data) if event.channel == "TRAJECTORY" else None
        if message:
            members.setdefault((message.anchor, message.round), set()).add(message.robot)
    return {(a, b) for robots in members.values() for a in robots for b in robots if a < b}


def _measure_truth(facts, run, trajectories):
    if not trajectories.truth:
        return
    for kind, key, files in (("vio", "ate_vio_m", trajectories.vio_files), ("team", "ate_m", trajectories.team_files)):
        error = evaluation.evaluate_trajectories(files, trajectories.truth_files)
        facts["team"][key] = error["ate_m"]
        for robot, each in zip(facts["robots"], error["robots"]):
            robot[f"ate_{kind}_m"] = each["with_team"]["rmse_m"]
    trajectories.T_truth_W = evaluation.alignment(error)


def _measure_online(facts, run):
    """What each robot believed when it took its keyframes, of those that it took with a pose in W."""
    truths = [robot.truth for robot in run.robots if robot.truth]
    if not truths:
        return
    logs = [run.file("logs", f"robot{robot.id}.lcm") for robot in run.robots]
    error = evaluation.evaluate_online(logs, truths)
    facts["team"]["keyframes_online"] = error["counted"]
    if error["counted"]:
        facts["team"]["ate_online_m"] = error["ate_m"]


def _measure_central(facts, run, trajectories):
    keyframes = [robot.keyframes for robot in run.robots]
    central = evaluation.solve_centrally(run.file("graph"), run.world.barc2, keyframes, run.file("central"))
    facts["team"].update({"cost_centralized": central.cost, "loops_accepted_centralized": central.kept_loops})
    if trajectories.truth:
        error = evaluation.evaluate_trajectories(central.files, trajectories.truth_files)
        facts["team"]["ate_centralized_m"] = error["ate_m"]


def _commit():
    command = ["git", "-C", places.ROOT, "rev-parse", "--short", "HEAD"]
    try:
        return subprocess.run(command, capture_output=True, text=True).stdout.strip() or None
    except OSError:
        return None
