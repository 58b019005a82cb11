# SPDX-License-Identifier: BSD-3-Clause
"""report.json: everything that a demo's run came to, as figures.

What a world cannot have is left out: without truth there are no ATEs, without images no meshes. What could not be measured
although it should have been stands in "notes", as sentences.
"""

import json
import os
import subprocess

from covey_tools import evaluation, lcm_log, messages, motion, pictures, places
from covey_tools.errors import Failure, InputError

# What a keyframe would cost if it were sent to a server instead (Kimera-Multi, T-RO 2022, section VI).
KEYPOINTS_BYTES = 48_300
IMAGES_BYTES = 722_000


def make(out, world, robots, outcome, options):
    """Measures, writes report.json, traj/ and the pictures; returns what is in the report."""
    facts = {"world": world.name, "seconds": outcome.data_s, "robots": [], "team": {}, "communication_bytes": _communication(out, robots, outcome),
             "realtime_factor": _ratio(outcome.data_s, outcome.wall_s), "complete": outcome.reason == "done", "missing": outcome.missing,
             "wall_seconds": outcome.wall_s, "restarts": outcome.team.restarts(), "radio": os.path.basename(options.radio),
             "seed": options.seed, "barc2": world.barc2, "commit": _commit(), "notes": []}
    trajectories = _Trajectories(out, robots)
    for step in (_measure_robots, _measure_rounds, _measure_graph, _measure_truth, _measure_central, _draw):
        try:
            step(facts, out, world, robots, outcome, trajectories)
        except (Failure, InputError) as failure:
            facts["notes"].append(str(failure))
    _check_air(facts)
    shown = {name: value for name, value in facts.items() if name != "figures"}
    with open(os.path.join(out, "report.json"), "w", encoding="utf-8") as file:
        json.dump(shown, file, indent=2)
        file.write("\n")
    return facts


class _Trajectories:
    """The files in traj/, in W, the frame of the lowest robot's first keyframe."""

    def __init__(self, out, robots):
        self.team_files = [os.path.join(out, "traj", f"robot{robot.id}_team.tum") for robot in robots]
        self.vio_files = [os.path.join(out, "traj", f"robot{robot.id}_vio.tum") for robot in robots]
        self.team = {robot.id: motion.read_tum(file) if os.path.exists(file) else [] for robot, file in zip(robots, self.team_files)}
        self.truth_files = [robot.truth for robot in robots if robot.truth]
        self.T_truth_W = None  # known once the solution is aligned with truth
        self.truth = {robot.id: motion.read_tum(robot.truth) for robot in robots if robot.truth}
        self.vio = {robot.id: self._place(robot) for robot in robots}
        for robot, file in zip(robots, self.vio_files):
            motion.write_tum(file, self.vio[robot.id])

    def _place(self, robot):
        """Odometry alone, put where the robot's first keyframe really was or, where that is not known, is in the solution."""
        odometry = motion.chain(robot.steps)
        if self.truth:
            T_W_truth = motion.inverse(self.truth[min(self.truth)][0][1])
            return motion.moved(odometry, motion.compose(T_W_truth, self.truth[robot.id][0][1]))
        return motion.moved(odometry, self.team[robot.id][0][1] if self.team[robot.id] else motion.IDENTITY)


def _communication(out, robots, outcome):
    sent = outcome.team.radio_bytes()
    keyframes = sum(robot.keyframes for robot in robots)
    modules = {name: sent.get(name, 0) for name in ("place_recognition", "geometric_verification", "dpgo", "control")}
    communication = {**modules, "total": sum(sent.values()), "centralized_keypoints": keyframes * KEYPOINTS_BYTES,
                     "centralized_images": keyframes * IMAGES_BYTES}
    log = os.path.join(out, "logs", "air.lcm")
    try:
        communication["on_air"] = evaluation.evaluate_radio(log)["total"]["bytes"]
    except (Failure, InputError):
        communication["on_air"] = None
    return communication


def _check_air(facts):
    """The bridges' word against the log of the radio; a process that was killed takes its last second of counts along."""
    said, heard = facts["communication_bytes"]["total"], facts["communication_bytes"]["on_air"]
    if heard is None:
        facts["notes"].append("logs/air.lcm cannot be read: the bridges' byte counts are not checked")
    elif not facts["restarts"] and abs(said - heard) > 0.02 * max(said, heard) + 20_000:
        facts["notes"].append(f"the bridges say they sent {said} bytes, the log of the radio has {heard}")


def _measure_robots(facts, out, world, robots, outcome, trajectories):
    for robot in robots:
        path = trajectories.truth.get(robot.id) or trajectories.team[robot.id] or trajectories.vio[robot.id]
        facts["robots"].append({"id": robot.id, "length_m": motion.length(path), "keyframes": robot.keyframes, "loops": robot.loops})


def _measure_rounds(facts, out, world, robots, outcome, trajectories):
    team = outcome.team
    updates = [team.said("dpgo", robot.id).gauges.get("updates", 0) for robot in robots]
    facts["team"].update({"time_to_common_frame_s": team.common_frame_s, "rounds": len({each[2] for each in team.rounds}),
                          "dgnc_seconds": max(team.last_round_s.values(), default=None), "dgnc_iterations": int(sum(updates)),
                          "cost_by_round": [{"s": round(elapsed_s, 3), "cost": cost} for elapsed_s, cost in team.costs()]})


def _measure_graph(facts, out, world, robots, outcome, trajectories):
    logs = [os.path.join(out, "results.lcm")]
    score = evaluation.evaluate_graph(os.path.join(out, "graph"), trajectories.team_files, world.barc2, trajectories.truth_files, logs)
    met = _met(os.path.join(out, "results.lcm"))
    pairs = [{"a": pair["a"], "b": pair["b"], "met": pair["a"] == pair["b"] or (pair["a"], pair["b"]) in met,
              **{name: value for name, value in pair.items() if name not in "ab"}} for pair in score["pairs"]]
    facts["team"].update({"cost": score["cost"], "loops_total": score["loops"]["total"], "loops_accepted": score["loops"]["accepted"],
                          "loops": pairs})
    facts["team"].update({name: score[name] for name in ("precision", "recall") if name in score})


def _met(log):
    """Pairs of robots that finished a round together, from what they said of it (TRAJECTORY)."""
    members = {}  # (anchor, round) -> robots
    for event in lcm_log.Log(log):
        message = messages.decode("trajectory_t", event.data) if event.channel == "TRAJECTORY" else None
        if message:
            members.setdefault((message.anchor, message.round), set()).add(message.robot)
    return {(a, b) for robots in members.values() for a in robots for b in robots if a < b}


def _measure_truth(facts, out, world, robots, outcome, trajectories):
    if not trajectories.truth:
        return
    for name, files in (("vio", trajectories.vio_files), ("team", trajectories.team_files)):
        error = evaluation.evaluate_trajectories(files, trajectories.truth_files)
        facts["team"]["ate_m" if name == "team" else "ate_vio_m"] = error["ate_m"]
        for robot, each in zip(facts["robots"], error["robots"]):
            robot[f"ate_{name}_m"] = each["with_team"]["rmse_m"]
        if name == "team":
            trajectories.T_truth_W = evaluation.alignment(error)


def _measure_central(facts, out, world, robots, outcome, trajectories):
    central = evaluation.solve_centrally(os.path.join(out, "graph"), world.barc2, [robot.keyframes for robot in robots],
                                         os.path.join(out, "central"))
    facts["team"].update({"cost_centralized": central.cost, "loops_accepted_centralized": central.kept_loops})
    if trajectories.truth:
        facts["team"]["ate_centralized_m"] = evaluation.evaluate_trajectories(central.files, trajectories.truth_files)["ate_m"]


def _draw(facts, out, world, robots, outcome, trajectories):
    facts["figures"] = pictures.draw(facts, out, world, trajectories)


def _ratio(a, b):
    return a / b if b else None


def _commit():
    done = subprocess.run(["git", "-C", places.ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True)
    return done.stdout.strip() or None


def table(facts):
    """The headline figures as a few lines of text."""
    team, bytes_sent = facts["team"], facts["communication_bytes"]
    lines = ["", f"{'robot':>5}  {'keyframes':>9}  {'length':>8}  {'ATE odometry':>12}  {'ATE team':>8}"]
    for robot in facts["robots"]:
        lines.append(f"{robot['id']:5}  {robot['keyframes']:9}  {robot['length_m']:6.0f} m  {metres(robot.get('ate_vio_m')):>12}  "
                     f"{metres(robot.get('ate_team_m')):>8}")
    lines += [""]
    if "ate_m" in team:
        lines.append(f"team ATE          {metres(team['ate_m'])} (odometry alone {metres(team.get('ate_vio_m'))}, "
                     f"central {metres(team.get('ate_centralized_m'))})")
    if "cost" in team:
        central = team.get("cost_centralized")
        against = f" ({100 * (team['cost'] / central - 1):+.2f} % against central, {central:.1f})" if central else ""
        lines.append(f"robust cost       {team['cost']:.1f}{against}")
        truth = f", precision {team['precision']:.3f}, recall {team.get('recall', 0):.3f}" if "precision" in team else ""
        central_loops = team.get("loops_accepted_centralized")
        lines.append(f"closures kept     {team['loops_accepted']} of {team['loops_total']}"
                     + (f" (central {central_loops})" if central_loops is not None else "") + truth)
    lines.append(f"radio             {bytes_sent['total'] / 1e3:,.0f} kB sent by all robots, {bytes_sent['dpgo'] / 1e3:,.0f} kB of it for dpgo")
    common = team.get("time_to_common_frame_s")
    lines.append(f"time              {facts['wall_seconds']:.1f} s for {facts['seconds']:.0f} s of data; one frame after "
                 + (f"{common:.1f} s" if common is not None else "never"))
    if facts["restarts"]:
        lines.append("restarted         " + ", ".join(f"{name} {count}x" for name, count in facts["restarts"].items()))
    return "\n".join(lines + [f"note: {note}" for note in facts["notes"]])


def metres(value):
    return "-" if value is None else f"{value:.3f} m"
