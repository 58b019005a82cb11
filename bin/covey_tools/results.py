# SPDX-License-Identifier: BSD-3-Clause
"""What a run left, as files that the evaluating programs read.

    traj/robot<i>_vio.tum, _team.tum    in W, the frame of the lowest robot's odometry; truth is in a frame of its own
    graph/                              the pose graph that was solved (of sensors: chains.py writes it)

Both kinds of worlds offer the same: trajectories by robot and as files, and the same poses as the graph numbers them.
"""

import os
import re

from covey_tools import motion
from covey_tools.chains import Chains
from covey_tools.session import Session

_CONTACT = re.compile(r"\ba: *(\d+)\b.*\bb: *(\d+)\b.*\bfrom_s: *([\d.]+)")


class _Results:
    def __init__(self, run):
        self._run = run
        self.team_files = [run.file("traj", f"robot{robot.id}_team.tum") for robot in run.robots]
        self.vio_files = [run.file("traj", f"robot{robot.id}_vio.tum") for robot in run.robots]
        self.truth_files = [robot.truth for robot in run.robots if robot.truth]
        self.alignments = {}  # "vio", "team" -> T_truth_W, by which the trajectories are nearest to truth; as far as measured
        self.team = {robot.id: motion.read_tum(file) if os.path.exists(file) else []
                     for robot, file in zip(run.robots, self.team_files)}
        self.truth = {robot.id: motion.read_tum(robot.truth) for robot in run.robots if robot.truth}
        self.session = Session([run.file("results.lcm")])
        self.graph = run.file("graph")  # folder
        self.graph_files = {}  # stage -> files, poses numbered as in the graph
        self.met = set()  # pairs of robots
        self.closure_limits = ()  # m, deg: what counts as a true closure; (): what evaluate takes

    def _write_vio(self):
        for robot, file in zip(self._run.robots, self.vio_files):
            motion.write_tum(file, self.vio[robot.id])


class GraphResults(_Results):
    """Of a world that is a pose graph. Two robots have met when they finished a round together."""

    def __init__(self, run):
        super().__init__(run)
        self.weights = run.file("results.lcm")
        self.vio = {robot.id: self._place(robot) for robot in run.robots}
        self._write_vio()
        self.graph_files = {"team": self.team_files, "vio": self.vio_files}
        if self.truth:
            self.graph_files["truth"] = self.truth_files
        self.poses_per_file = [robot.keyframes for robot in run.robots]
        self.met = {(a, b) for robots in self.session.rounds.values() for a in robots for b in robots if a < b}

    def counts(self, robot):
        """Its keyframes and the closures that it takes part in."""
        return self._run.robots[robot].keyframes, self._run.robots[robot].loops

    def pairs(self, scores):
        """Of each pair of robots, from evaluate's scores by file."""
        return scores

    def in_time(self, files, folder):
        """Files of the graph's numbering as files by utime: here the same, pose k is of second k + 1."""
        return files

    def write_for_graph(self, ways, folder):
        """Files of {robot: trajectory} in the graph's numbering."""
        os.makedirs(folder, exist_ok=True)
        files = {robot: os.path.join(folder, f"robot{robot}.tum") for robot in ways}
        for robot, file in files.items():
            motion.write_tum(file, ways[robot])
        return list(files.values())

    def _place(self, robot):
        """Odometry alone, put where its first keyframe really was or, without truth, is in the solution."""
        odometry = motion.chain(robot.steps)
        if self.truth:
            T_W_truth = motion.inverse(self.truth[min(self.truth)][0][1])
            return motion.moved(odometry, motion.compose(T_W_truth, self.truth[robot.id][0][1]))
        return motion.moved(odometry, self.team[robot.id][0][1] if self.team[robot.id] else motion.IDENTITY)


class SensorResults(_Results):
    """Of a world with sensors. Two robots have met when they were within reach of each other's radio (truth's contacts)."""

    def __init__(self, run):
        super().__init__(run)
        self.session = Session([run.file("results.lcm")]
                               + [run.file("logs", f"robot{robot.id}.lcm") for robot in run.robots])
        self.T_truth_O = {}  # (robot, segment) -> where truth has each segment's odometry frame
        self.vio = {robot.id: self._place(robot.id) for robot in run.robots}
        self._write_vio()
        self.chains = Chains(self.session, self.team, self.graph)
        self.weights = self.chains.weights
        self.graph_files = {stage: self.chains.write(ways, run.file("graph", stage))
                            for stage, ways in (("team", self.team), ("vio", self.vio), ("truth", self.truth))}
        self.poses_per_file = [len(chain.keyframes) for chain in self.chains.chains]
        self.met = _contacts(run.recording.truth("contacts.yaml"), run.world.seconds)
        self.closure_limits = (0.5, 5.0)

    def counts(self, robot):
        ends = [(loop.a[0], loop.b[0]) for loop in self.session.loops]
        return self.session.count(robot), sum(robot in pair for pair in ends)

    def pairs(self, scores):
        return self.chains.pairs(scores, [robot.id for robot in self._run.robots])

    def in_time(self, files, folder):
        ways = self.chains.by_robot(files)
        found = [os.path.join(folder, f"robot{robot.id}_in_time.tum") for robot in self._run.robots]
        for robot, file in zip(self._run.robots, found):
            motion.write_tum(file, ways.get(robot.id, []))
        return found

    def write_for_graph(self, ways, folder):
        return self.chains.write(ways, folder)

    def _place(self, robot):
        """vio's keyframes, each segment put where truth has its first one."""
        way = []
        for segment, keyframes in self.session.segments(robot).items():
            T_truth_K, = motion.at(self.truth[robot], [keyframes[0].utime * 1e-6])
            if T_truth_K is None:
                continue  # truth ends before: nothing to compare with
            T_truth_O = motion.compose(T_truth_K, motion.inverse(keyframes[0].T_O_K))
            self.T_truth_O[robot, segment] = T_truth_O
            T_W_O = motion.compose(self._T_W_truth(), T_truth_O)
            way += [(each.utime * 1e-6, motion.compose(T_W_O, each.T_O_K)) for each in keyframes]
        return sorted(way)

    def _T_W_truth(self):
        """By the lowest robot's first segment, whose odometry frame is W."""
        robot = self._run.robots[0].id
        first = min((segment for owner, segment in self.T_truth_O if owner == robot), default=None)
        return motion.IDENTITY if first is None else motion.inverse(self.T_truth_O[robot, first])


def _contacts(file, seconds):
    """Pairs of robots that a contact plan lets hear each other while they drive; in the end it lets everyone."""
    with open(file, encoding="utf-8") as lines:
        found = [_CONTACT.search(line.split("#")[0]) for line in lines]
    return {tuple(sorted((int(each[1]), int(each[2])))) for each in found if each and float(each[3]) < seconds}
