# SPDX-License-Identifier: BSD-3-Clause
"""A team of robots seen through the STATUS of their processes: what each has, how far it is, whether it is done."""

from dataclasses import dataclass, field


@dataclass
class Said:
    """The last STATUS of a process, and its counters over all its runs: a process that is killed and respawned counts from 0."""

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
            self._before = {name: self.total(name) for name in {**self._before, **self.counters}}
            self.counters = {}
            self.restarts += 1
        self.start_utime = status.start_utime
        self.phase = status.phase
        self.counters = dict(zip(status.counter_names, status.counter_values))
        self.gauges = dict(zip(status.gauge_names, status.gauge_values))

    def total(self, name):
        return self._before.get(name, 0) + self.counters.get(name, 0)

    def names(self):
        return sorted({**self._before, **self.counters})


class Team:
    """`robots`: the Robots (worlds.py) whose graph is to be solved."""

    def __init__(self, robots):
        self.robots = robots
        self.rounds = []  # (s since the start of the data, robot, round, robots in it, its share of the cost), as they were said
        self._said = {}  # (process, robot) -> Said
        self._start_s = None
        self.common_frame_s = None  # when the first round with everybody in it was over
        self._round_began_s = {}  # robot -> when
        self.last_round_s = {}  # robot -> how long its last finished round took

    def take(self, status, now_s):
        said = self._said.setdefault((status.process, status.robot), Said())
        before, phase_before = said.gauges.get("round"), said.phase
        said.take(status)
        if status.process == "dpgo" and said.phase == "round" != phase_before:
            self._round_began_s[status.robot] = now_s
        if status.process == "player" and self._start_s is None:
            self._start_s = now_s
        if status.process == "dpgo" and self._start_s is not None and said.gauges.get("round") not in (None, before):
            self._note_round(status.robot, said.gauges, now_s)

    def _note_round(self, robot, gauges, now_s):
        elapsed_s = now_s - self._start_s
        if robot in self._round_began_s:
            self.last_round_s[robot] = now_s - self._round_began_s.pop(robot)
        self.rounds.append((elapsed_s, robot, int(gauges["round"]), int(gauges.get("robots", 0)), gauges.get("cost")))
        if self.common_frame_s is None and gauges.get("robots") == len(self.robots):
            self.common_frame_s = elapsed_s

    def said(self, process, robot):
        return self._said.get((process, robot), Said())

    def elapsed_s(self, now_s):
        """Since the data began; 0 before."""
        return 0.0 if self._start_s is None else now_s - self._start_s

    def missing(self):
        """Sentences: what stands between the team and a solution of all it has. Empty: done."""
        sentences = []
        rounds = {self.said("dpgo", robot.id).gauges.get("round") for robot in self.robots}
        for robot in self.robots:
            said = self.said("dpgo", robot.id)
            if not said.phase:
                sentences.append(f"robot {robot.id}: dpgo has not been heard")
                continue
            for what, expected in (("keyframes", robot.keyframes), ("loops", robot.loops)):
                solved = int(said.gauges.get(f"solved_{what}", 0))
                if solved < expected:
                    sentences.append(f"robot {robot.id}: {solved} of {expected} {what} solved")
            if int(said.gauges.get("robots", 0)) < len(self.robots):
                sentences.append(f"robot {robot.id}: {int(said.gauges.get('robots', 0))} of {len(self.robots)} robots in its last round")
            if said.phase != "idle":
                sentences.append(f"robot {robot.id}: dpgo is {said.phase}")
        if not sentences and len(rounds) > 1:
            sentences.append(f"the robots' last rounds differ: {', '.join(str(int(each)) for each in sorted(rounds))}")
        return sentences

    def costs(self):
        """[(s, cost)] of the rounds that every robot ended: the shares put together, when the last one was said."""
        shares = {}
        for elapsed_s, robot, number, members, cost in self.rounds:
            if members == len(self.robots) and cost is not None:
                shares.setdefault(number, {})[robot] = (elapsed_s, cost)
        return sorted((max(each[0] for each in said.values()), sum(each[1] for each in said.values()))
                      for said in shares.values() if len(said) == len(self.robots))

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
        return {f"{process}-{robot}": said.restarts for (process, robot), said in sorted(self._said.items()) if said.restarts}

    def rows(self):
        """The progress as lines of text, one per robot."""
        lines = [f"{'robot':>5}  {'keyframes':>9}  {'loops':>11}  {'solved':>11}  {'kept':>5}  {'round':>5}  {'team':>4}  {'cost':>9}  dpgo"]
        for robot in self.robots:
            said = self.said("dpgo", robot.id)
            value = {name: int(said.gauges.get(name, 0)) for name in
                     ("keyframes", "loops", "solved_keyframes", "solved_loops", "kept_loops", "round", "robots")}
            solved = f"{value['solved_keyframes']}+{value['solved_loops']}"
            lines.append(f"{robot.id:5}  {value['keyframes']:4}/{robot.keyframes:<4}  {value['loops']:5}/{robot.loops:<5}  {solved:>11}  "
                         f"{value['kept_loops']:5}  {value['round']:5}  {value['robots']:4}  {said.gauges.get('cost', 0.0):9.1f}  "
                         f"{said.phase or '-'}")
        return lines
