# SPDX-License-Identifier: BSD-3-Clause
"""A team whose robots run every process, from sensor logs: how far it is, and when nothing is left to do.

How many keyframes and loop closures there will be nobody knows before; so the watcher counts them as they are said. The
work is over when the logs have been played, every dpgo has solved all keyframes that were said in one round of the whole
team, lcd has nothing more to verify, lmo has deformed the mesh to that round, and all that has stood still for a while.
"""

from covey_tools import messages
from covey_tools.team import Team

SETTLE_S = 4.0  # without a change before the work is over: dpgo waits 2 s before it opens a round
SOURCES = ("sensors", "depth")  # the sheet's players of the log, of each robot


class SensorTeam(Team):
    """`seconds` of data at `speed`."""

    PROCESSES = ("radio_bridge", "dpgo", "lmo", "lcd", "mesher", "vio")
    RESULT_CHANNELS = ("LOOP_WEIGHTS", "TRAJECTORY", "KEYFRAME", "LOOP")

    def __init__(self, robots, seconds, speed):
        super().__init__(robots)
        self._seconds = seconds
        self._speed = speed
        self._playing = {f"{source}-{robot.id}" for robot in robots for source in SOURCES}
        self._keyframes = {robot.id: set() for robot in robots}  # their names: (segment, id)
        self._loops = {robot.id: set() for robot in robots}  # as heard on the robot's bus
        self._standing = {}  # (process, robot) -> what of it shows progress
        self._changed_s = 0.0

    def take(self, status, now_s):
        super().take(status, now_s)
        said = self.said(status.process, status.robot)
        standing = (said.phase, said.restarts, *(said.gauge(name) for name in ("round", "solved_round", "blocks_pending")),
                    said.total("out/MESH"))
        if self._standing.get((status.process, status.robot)) != standing:
            self._standing[(status.process, status.robot)] = standing
            self._changed_s = now_s

    def hear(self, robot, channel, payload, now_s):
        names = {"KEYFRAME": self._keyframes, "LOOP": self._loops}.get(channel)
        name = _name_of(channel, payload) if names else None
        if name is not None and name not in names[robot]:
            names[robot].add(name)
            self._changed_s = now_s

    def event(self, name, text, now_s):
        if name in self._playing:
            self.begin(now_s)
            if text.startswith("exited"):  # sources are not respawned: they would begin anew
                self._playing.discard(name)
                self._changed_s = now_s

    def keyframes(self, robot):
        return len(self._keyframes[robot])

    def loops(self, robot):
        return len(self._loops[robot])

    def data_s(self, now_s):
        return min(self._seconds, self.elapsed_s(now_s) * self._speed) if self._playing else self._seconds

    def settled_s(self, now_s):
        return self.elapsed_s(self._changed_s) if self.is_done(now_s) else self.elapsed_s(now_s)

    def is_done(self, now_s):
        return now_s - self._changed_s >= SETTLE_S and not self.missing()

    def missing(self):
        sentences = [f"{name} has not played its log to the end" for name in sorted(self._playing)]
        return sentences + super().missing()

    def _missing_of(self, robot):
        silent = [process for process in self.PROCESSES if not self.said(process, robot.id).phase]
        if silent:
            return [f"robot {robot.id}: {process} has not been heard" for process in silent]
        dpgo, lcd, mesher, lmo = (self.said(process, robot.id) for process in ("dpgo", "lcd", "mesher", "lmo"))
        team, keyframes = len(self.robots), self.keyframes(robot.id)
        checks = ((keyframes > 0, "vio has made no keyframe"),
                  (dpgo.gauge("solved_keyframes") >= keyframes,
                   f"{dpgo.gauge('solved_keyframes')} of {keyframes} keyframes solved"),
                  (dpgo.gauge("loops") >= self.loops(robot.id),
                   f"{dpgo.gauge('loops')} of {self.loops(robot.id)} loops taken"),
                  (dpgo.gauge("robots") >= team, f"{dpgo.gauge('robots')} of {team} robots in its last round"),
                  (dpgo.phase == "idle", f"dpgo is {dpgo.phase}"),
                  (lcd.phase == "idle", f"lcd is {lcd.phase}"),
                  (mesher.gauge("waiting_blocks") == 0, f"mesher has {mesher.gauge('waiting_blocks')} blocks to say"),
                  (lmo.gauge("solved_round") == dpgo.gauge("round"),
                   f"lmo has the mesh of round {lmo.gauge('solved_round')}, and the last round is {dpgo.gauge('round')}"),
                  (lmo.phase == "idle", f"lmo is {lmo.phase}"))
        return [f"robot {robot.id}: {sentence}" for good, sentence in checks if not good]

    def rows(self):
        lines = ["robot  frames  lost  keyframes  loops     solved   kept  round  team  vertices  "
                 "vio       lcd       dpgo      lmo"]
        for robot in self.robots:
            vio, lcd, dpgo, lmo = (self.said(process, robot.id) for process in ("vio", "lcd", "dpgo", "lmo"))
            solved = f"{dpgo.gauge('solved_keyframes')}+{dpgo.gauge('solved_loops')}"
            phases = "  ".join(f"{each.phase or '-':8}" for each in (vio, lcd, dpgo, lmo))
            lines.append(f"{robot.id:5}  {frames(vio):6}  {frames_dropped(vio):4}  "
                         f"{self.keyframes(robot.id):9}  {self.loops(robot.id):5}  {solved:>9}  "
                         f"{dpgo.gauge('kept_loops'):5}  {dpgo.gauge('round'):5}  {dpgo.gauge('robots'):4}  "
                         f"{lmo.gauge('vertices'):8}  {phases.rstrip()}")
        return lines


def frames(vio):
    """Image sets that vio knows of: that were handed to it, or lost or refused before."""
    return sum(vio.total(f"{name}/STEREO") for name in ("in", "lost")) + sum(
        vio.total(f"dropped/STEREO/{reason}") for reason in ("queue_full", "undecodable"))


def frames_dropped(vio):
    """Of these, what vio did not use. Single bands of a set that are refused stand among the sets that are lost."""
    bands = {f"dropped/STEREO/{reason}" for reason in ("impossible", "duplicate", "old")}
    return vio.total("lost/STEREO") + sum(vio.total(name) for name in vio.names()
                                          if name.startswith("dropped/STEREO/") and name not in bands)


def _name_of(channel, payload):
    if channel == "KEYFRAME":
        keyframe = messages.decode("keyframe_t", payload)
        return keyframe and (keyframe.segment, keyframe.id)
    loop = messages.decode("loop_t", payload)
    return loop and (loop.robot_a, loop.segment_a, loop.id_a, loop.robot_b, loop.segment_b, loop.id_b, *loop.t_A_B)
