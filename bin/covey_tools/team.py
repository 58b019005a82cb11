# SPDX-License-Identifier: BSD-3-Clause
"""A team of robots seen through the STATUS of their processes: what each has, how far it is, whether it is done."""

from collections import namedtuple
from dataclasses import dataclass, field

# When (s since the data began) a robot said that a round was over; `members` took part, `cost` is the robot's share.
Round = namedtuple("Round", "elapsed_s robot number members cost")


@dataclass
class Said:
    """The last STATUS of a process, and its counters over all its runs: a respawned process counts from 0."""

    start_utime: int = 0
    phase: str = ""
    counters: dict = field(default_factory=dict)
    gauges: dict = field(default_factory=dict)
    restarts: int = 0
    _before: dict = field(default_factory=dict)  # sums of the runs before this one

    def take(self, status):
        if status.start_utime < self.start_utime:
            return  # an old run's last word, late
        if self.start_utime and status.start_utime > self.start_utime:
            self._before = {name: self.total(name) for name in self.names()}
            self.restarts += 1
        self.start_utime = status.start_utime
        self.phase = status.phase
        self.counters = dict(zip(status.counter_names, status.counter_values))
        self.gauges = dict(zip(status.gauge_names, status.gauge_values))

    def gauge(self, name):
        """As a whole number; 0 where it was never said."""
        return int(self.gauges.get(name, 0))

    def total(self, name):
        return self._before.get(name, 0) + self.counters.get(name, 0)

    def names(self):
        return sorted({**self._before, **self.counters})


class Team:
    """`robots`: the Robots (worlds.py) whose graph is to be solved; a team of players, front ends made of a file.

    The watcher of a run (team_run.py) tells it what it hears (take, hear) and what happens to the sheet's processes
    (event), and asks it for `missing`, `rows` and `data_s`.
    """

    PROCESSES = ("dpgo", "radio_bridge", "player")  # of each robot, that say STATUS
    # Channels that the watcher writes down itself: a logger may be killed just when the last word is said.
    RESULT_CHANNELS = ("LOOP_WEIGHTS", "TRAJECTORY")

    def __init__(self, robots):
        self.robots = robots
        self.rounds = []  # of Round, as they were said
        self.common_frame_s = None  # when the first round with everybody in it was over
        self.last_round_s = {}  # robot -> how long its last finished round took
        self._said = {}  # (process, robot) -> Said
        self._start_s = None
        self._round_began_s = {}  # robot -> when

    def take(self, status, now_s):
        said = self._said.setdefault((status.process, status.robot), Said())
        round_before, phase_before = said.gauges.get("round"), said.phase
        said.take(status)
        if status.process == "player":
            self.begin(now_s)
        if status.process != "dpgo" or self._start_s is None:
            return
        if said.phase == "round" != phase_before:
            self._round_began_s[status.robot] = now_s
        if said.gauges.get("round") not in (None, round_before):
            self._note_round(status.robot, said, now_s)

    def hear(self, robot, channel, payload, now_s):
        """One of RESULT_CHANNELS, on the bus of that robot."""

    def event(self, name, text, now_s):
        """What the sheet says of a command of it."""

    def begin(self, now_s):
        """The data begins."""
        if self._start_s is None:
            self._start_s = now_s

    def _note_round(self, robot, said, now_s):
        if robot in self._round_began_s:
            self.last_round_s[robot] = now_s - self._round_began_s.pop(robot)
        members = said.gauge("robots")
        self.rounds.append(Round(self.elapsed_s(now_s), robot, said.gauge("round"), members, said.gauges.get("cost")))
        if self.common_frame_s is None and members == len(self.robots):
            self.common_frame_s = self.elapsed_s(now_s)

    def said(self, process, robot):
        return self._said.get((process, robot), Said())

    def elapsed_s(self, now_s):
        """Since the data began; 0 before."""
        return 0.0 if self._start_s is None else now_s - self._start_s

    def data_s(self, now_s):
        """Seconds of data that have been played."""
        return max(self.said("player", robot.id).gauges.get("played_s", 0.0) for robot in self.robots)

    def settled_s(self, now_s):
        """Since the data began, until nothing changed any more: how long the work took."""
        return self.elapsed_s(now_s)

    def is_done(self, now_s):
        return not self.missing()

    def missing(self):
        """Sentences: what stands between the team and a solution of all it has. Empty: done."""
        sentences = [sentence for robot in self.robots for sentence in self._missing_of(robot)]
        rounds = sorted({self.said("dpgo", robot.id).gauge("round") for robot in self.robots})
        if not sentences and len(rounds) > 1:
            sentences.append(f"the robots' last rounds differ: {', '.join(map(str, rounds))}")
        return sentences

    def _missing_of(self, robot):
        said = self.said("dpgo", robot.id)
        if not said.phase:
            return [f"robot {robot.id}: dpgo has not been heard"]
        wanted = (("solved_keyframes", robot.keyframes, "keyframes solved"),
                  ("solved_loops", robot.loops, "loops solved"),
                  ("robots", len(self.robots), "robots in its last round"))
        sentences = [f"robot {robot.id}: {said.gauge(name)} of {number} {what}"
                     for name, number, what in wanted if said.gauge(name) < number]
        return sentences + ([f"robot {robot.id}: dpgo is {said.phase}"] if said.phase != "idle" else [])

    def costs(self):
        """[(s, cost)] of the rounds that every robot ended: the shares put together, when the last one was said."""
        shares = {}
        for each in self.rounds:
            if each.members == len(self.robots) and each.cost is not None:
                shares.setdefault(each.number, {})[each.robot] = each
        whole = [list(said.values()) for said in shares.values() if len(said) == len(self.robots)]
        return sorted((max(each.elapsed_s for each in said), sum(each.cost for each in said)) for said in whole)

    def radio_bytes(self):
        """Bytes that the bridges say they sent, by module, over all robots and restarts."""
        sums = {}
        for robot in self.robots:
            said = self.said("radio_bridge", robot.id)
            for name in said.names():
                if name.startswith("sent_bytes/"):
                    module = name.removeprefix("sent_bytes/")
                    sums[module] = sums.get(module, 0) + said.total(name)
        return sums

    def restarts(self):
        """"process-robot" -> how often it was started again."""
        return {f"{process}-{robot}": said.restarts
                for (process, robot), said in sorted(self._said.items()) if said.restarts}

    def rows(self):
        """The progress as lines of text, one per robot."""
        lines = ["robot  keyframes        loops       solved   kept  round  team       cost  dpgo"]
        for robot in self.robots:
            said = self.said("dpgo", robot.id)
            has = f"{said.gauge('keyframes'):4}/{robot.keyframes:<4}  {said.gauge('loops'):5}/{robot.loops:<5}"
            solved = f"{said.gauge('solved_keyframes')}+{said.gauge('solved_loops')}"
            last = f"{said.gauge('kept_loops'):5}  {said.gauge('round'):5}  {said.gauge('robots'):4}"
            lines.append(f"{robot.id:5}  {has}  {solved:>11}  {last}  {said.gauges.get('cost', 0.0):9.1f}  "
                         f"{said.phase or '-'}")
        return lines
