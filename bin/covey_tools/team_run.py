# SPDX-License-Identifier: BSD-3-Clause
"""One run of a team: its sheet in a private network, watched until everything is solved, then told to stop."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field

from covey_tools import bus, lcm_log, namespace, places, status
from covey_tools.loop import Loop
from covey_tools.process import last_log_line
from covey_tools.team import Team

REFRESH_S = 1.0
PLAIN_REFRESH_S = 5.0
START_PATIENCE_S = 30.0  # until every process has said STATUS
STOP_PATIENCE_S = 60.0


@dataclass
class Outcome:
    team: Team
    reason: str = ""  # why it ended: "done", "time", "interrupted", or a sentence
    missing: list = field(default_factory=list)  # sentences
    wall_s: float = 0.0  # from the first data to the last round, or the last mesh
    data_s: float = 0.0


class _Events:
    """What the sheet writes of its commands, line by line as it comes: "12.3 s  vio-0  started pid 4711"."""

    def __init__(self, path):
        self._path = path
        self._at = 0

    def read(self):
        """[(command, text)] since the last call."""
        try:
            with open(self._path, "rb") as file:
                file.seek(self._at)
                whole, newline, _ = file.read().rpartition(b"\n")
        except FileNotFoundError:
            return []
        self._at += len(whole) + len(newline)
        fields = [line.split(None, 3) for line in whole.decode("utf-8", "replace").splitlines()]
        return [(name, text) for _, _, name, text in (each for each in fields if len(each) == 4)]


class TeamRun:
    """`logs`: folder for what the processes print; `results`: file for the team's RESULT_CHANNELS; ends after `limit_s`.

    `wait_for`: commands of the sheet that say STATUS before its script goes on.
    """

    def __init__(self, sheet, team, logs, results, limit_s, network_mode, wait_for=()):
        self._sheet = sheet
        self._logs = logs
        self._limit_s = limit_s
        self._mode = network_mode
        self._wait_for = wait_for
        self._events = _Events(os.path.join(logs, "events.txt"))
        self._team = team
        self._outcome = Outcome(self._team)
        self._results = lcm_log.Writer(results)
        self._live = sys.stdout.isatty() and os.environ.get("TERM") != "dumb"
        self._drawn = 0  # lines
        self._shown = 0.0
        self._child = None
        self._loop = Loop()
        self._begun = self._loop.now()

    def run(self):
        network = namespace.hold(self._mode)
        try:
            if network.pid is not None:
                print(f"demo: private network of process {network.pid}; look inside: "
                      f"bin/rates --join {network.pid} --robot 0")
            self._listen(network)
            self._start(network)
            self._loop.run()
        finally:
            self._stop()
            network.release()
            self._results.close()
        return self._outcome

    def _listen(self, network):
        robots = [robot.id for robot in self._team.robots]
        sockets = network.open_sockets(lambda: [bus.open_bus(*bus.robot_bus(robot)) for robot in robots])
        for robot, each in zip(robots, sockets):
            each.setblocking(False)
            self._loop.on_readable(each, self._reader(robot, each, bus.Receiver()))
        for number in (signal.SIGINT, signal.SIGTERM):
            self._loop.on_signal(number, lambda: self._end("interrupted"))
        self._loop.after(REFRESH_S, self._tick)

    def _reader(self, robot, source, receiver):
        def read():
            for packet, sender in bus.drain(source):
                message = receiver.take(packet, sender)
                if message:
                    self._take(robot, message)
        return read

    def _take(self, robot, message):
        if message.channel in self._team.RESULT_CHANNELS:
            self._results.write(message.channel, message.payload, int(time.time() * 1e6))
            self._team.hear(robot, message.channel, message.payload, self._loop.now())
        elif message.channel == status.CHANNEL:
            said = status.decode(message.payload)
            if said:
                self._team.take(said, self._loop.now())
                if self._team.is_done(self._loop.now()):
                    self._end("done")

    def _start(self, network):
        parent = os.getpid()

        def prepare():  # in the child
            network.join()
            namespace.die_with_parent(parent, signal.SIGTERM)

        command = [os.path.join(places.ROOT, "bin", "sheet"), self._sheet, "start", "go", "--namespace", "in-place",
                   "--logs", self._logs]
        command += ["--wait-for", ",".join(self._wait_for)] if self._wait_for else []
        self._child = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, start_new_session=True, preexec_fn=prepare)

    def _tick(self):
        self._loop.after(REFRESH_S, self._tick)
        for name, text in self._events.read():
            self._team.event(name, text, self._loop.now())
        elapsed_s = self._loop.now() - self._begun
        if self._child.poll() is not None:
            self._end(f"bin/sheet ended with {self._child.returncode}; see {self._logs}/events.txt")
        elif elapsed_s > START_PATIENCE_S and self._unheard():
            self._end("a process cannot start: " + "; ".join(self._unheard()))
        elif elapsed_s > self._limit_s:
            self._end("time")
        elif self._live or self._loop.now() - self._shown >= PLAIN_REFRESH_S:
            self._show()

    def _unheard(self):
        """Who has never said STATUS, with the last line of its log."""
        names = [(process, robot.id) for robot in self._team.robots for process in self._team.PROCESSES]
        silent = [f"{process}-{robot}" for process, robot in names if not self._team.said(process, robot).phase]
        return [f"{name}: {last_log_line(os.path.join(self._logs, f'{name}.log'))}" for name in silent]

    def _end(self, reason):
        if self._outcome.reason:
            return
        self._outcome.reason = reason
        self._outcome.missing = self._team.missing()
        self._outcome.wall_s = self._team.settled_s(self._loop.now())
        self._outcome.data_s = self._team.data_s(self._loop.now())
        self._show()
        self._loop.stop()

    def _show(self):
        """The table of the team: redrawn in place on a terminal, else one after the other."""
        self._shown = self._loop.now()
        lines = [f"{self._team.elapsed_s(self._loop.now()):6.1f} s", *self._team.rows()]
        if self._live and self._drawn:
            sys.stdout.write(f"\033[{self._drawn}F\033[J")
        self._drawn = len(lines)
        sys.stdout.write("\n".join(lines) + "\n")
        sys.stdout.flush()

    def _stop(self):
        """The sheet stops its processes one after the other, and kills what does not go."""
        if self._child is None or self._child.poll() is not None:
            return
        self._child.send_signal(signal.SIGINT)
        deadline = time.monotonic() + STOP_PATIENCE_S
        while self._child.poll() is None and time.monotonic() < deadline:
            self._loop.after(0.1, self._loop.stop)  # the robots' last words are still to be written down
            self._loop.run()
        if self._child.poll() is None:
            self._child.kill()
            self._child.wait()
