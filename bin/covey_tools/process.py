# SPDX-License-Identifier: BSD-3-Clause
"""One command of a sheet as a process: started, respawned, stopped, with procman's deputy as the model.

    stopped -> running -> (exits by itself) -> stopped, or backing off -> running   with auto_respawn
                       -> (stop) stopping -> stopped                                never respawned

A command runs in a session and process group of its own, so that a terminal's Ctrl-C reaches only the sheet. Stopping
sends stop_signal to the group and to descendants that left it; what is alive after stop_time_allowed gets SIGKILL. A
command counts as stopped when its whole group is gone: a child that outlives its parent would hold the same ports.
"""

import errno
import os
import re
import shlex
import signal
import subprocess

from covey_tools import namespace, procfs

# procman's deputy: 10 ms, doubled at each exit within a second of the start, up to a second, and halved again by each
# second that a run lasted.
MIN_RESPAWN_DELAY_MS = 10
MAX_RESPAWN_DELAY_MS = 1000

_TERMINAL_CODES = re.compile(r"\x1b\[[0-9;]*[A-Za-z]")


class Backoff:
    """How long to wait before the next respawn."""

    def __init__(self):
        self.delay_ms = MIN_RESPAWN_DELAY_MS
        self._last_start_s = None

    def on_start(self, now_s):
        since_ms = float("inf") if self._last_start_s is None else (now_s - self._last_start_s) * 1000
        if since_ms < MAX_RESPAWN_DELAY_MS:
            self.delay_ms = min(MAX_RESPAWN_DELAY_MS, self.delay_ms * 2)
        else:
            halvings = min(int(min(since_ms, 1e6) // MAX_RESPAWN_DELAY_MS), 30)
            self.delay_ms = max(MIN_RESPAWN_DELAY_MS, self.delay_ms >> halvings)
        self._last_start_s = now_s


class Process:
    """`launch` says what to run (launch.py); report(process, text) hears of every event, on_change(process) follows."""

    def __init__(self, loop, command, launch, log_path, network, report, on_change):
        self.command = command
        self.launch = launch
        self.log_path = log_path
        self.state = "stopped"  # | running | backing off | stopping
        self.pid = 0
        self.exit_code = None  # of the last run, as subprocess: negative for a signal
        self.started_s = 0.0
        self.starts = 0
        self.failed = False  # its last run ended by itself, and badly
        self._loop = loop
        self._network = network
        self._report = report
        self._on_change = on_change
        self._backoff = Backoff()
        self._timer = None
        self._group = 0  # whose members may outlive the process
        self._strays = []  # descendants seen when it was told to stop
        self._restart = False
        self._ended = ""  # how the run that is being stopped ended

    def start(self):
        """Run it, unless it runs; while it is stopping, run it again afterwards."""
        if self.state == "stopping":
            self._restart = True
        elif self.state in ("stopped", "backing off"):
            self._spawn()

    def stop(self):
        """Ask it to stop and do not respawn it."""
        self._restart = False
        if self.state == "backing off":
            self._loop.cancel(self._timer)
            self._become("stopped", "not respawned: told to stop")
        elif self.state == "running":
            self._strays = procfs.descendants(self.pid)
            self._signal(self.command.stop_signal)
            self._timer = self._loop.after(self.command.stop_time_allowed_s, self._kill)
            self._become("stopping", f"told to stop by signal {self.command.stop_signal}")

    def restart(self):
        """Stop it if it runs, then start it."""
        if self.state == "running":
            self.stop()
        self._loop.cancel(self._timer if self.state == "backing off" else None)
        self.start()

    def kill(self):
        """SIGKILL, now."""
        if self.state in ("running", "stopping"):
            if self.state == "running":
                self._strays = []
            self._restart = False
            self.state = "stopping"
            self._loop.cancel(self._timer)
            self._insist()

    def on_exit(self, exit_code):
        """The sheet collected this process."""
        self.exit_code = exit_code
        self.pid = 0
        ended = f"exited with {exit_code}" if exit_code >= 0 else f"exited by signal {-exit_code}"
        if self.state == "stopping":
            self._ended = ended
            self.on_orphan_exit()
            return
        self.failed = exit_code != 0
        self._kill_group()
        last_line = last_log_line(self.log_path) if self.failed else ""
        if self.command.auto_respawn:
            self._timer = self._loop.after(self._backoff.delay_ms / 1000, self._spawn)
            self._become("backing off", f"{ended}, respawning in {self._backoff.delay_ms} ms", last_line)
        else:
            self._become("stopped", ended, last_line)

    def on_orphan_exit(self):
        """Some process of the sheet is gone: perhaps the last one of this group that is to stop."""
        if self.state != "stopping" or self.pid or self._group_alive():
            return
        self._loop.cancel(self._timer)
        if self._restart:
            self._restart = False
            self._report(self, f"stopped: {self._ended}, to be started again")
            self._spawn()
        else:
            self._become("stopped", f"stopped: {self._ended}")

    def _spawn(self):
        self._backoff.on_start(self._loop.now())
        self.started_s = self._loop.now()
        self.starts += 1
        self.failed = False
        self._ended = ""
        try:
            self.pid = spawn(self.launch, self.log_path, self._network)
        except OSError as error:
            self.exit_code, self.failed = 127, True
            what = f"could not start {self.launch.arguments[0]}: {error.strerror.lower()}"
            if self.command.auto_respawn:
                self._timer = self._loop.after(self._backoff.delay_ms / 1000, self._spawn)
                self._become("backing off", f"{what}, trying again in {self._backoff.delay_ms} ms")
            else:
                self._become("stopped", what)
            return
        self._group = self.pid
        self._become("running", f"started pid {self.pid}")

    def _become(self, state, text, detail=""):
        self.state = state
        self._report(self, text + (f": {detail}" if detail else ""))
        self._on_change(self)

    def _group_alive(self):
        if _signal_one(os.killpg, self._group, 0):
            return True
        return any(_is_alive(pid) for pid in self._strays)

    def _kill(self):
        self._report(self, f"still there after {self.command.stop_time_allowed_s} s, killing it")
        self._insist()

    def _insist(self):
        """SIGKILL to all that is left, again every second: not every death below a command is reported to the sheet."""
        self._strays += procfs.descendants(self.pid) if self.pid else []
        self._signal(signal.SIGKILL)
        self._timer = self._loop.after(1.0, self._insist)
        self.on_orphan_exit()

    def _kill_group(self):
        _signal_one(os.killpg, self._group, signal.SIGKILL)

    def _signal(self, number):
        _signal_one(os.killpg, self._group, number)
        for pid in self._strays:
            entry = procfs.usage(pid)
            if entry and entry.group != self._group:
                _signal_one(os.kill, pid, number)


def spawn(launch, log_path, network):
    """Start what `launch` says, in `network` unless it is to start outside; returns its process id."""
    parent = os.getpid()

    def prepare():  # in the child, before the program takes over
        for number in range(1, 32):
            if number not in (signal.SIGKILL, signal.SIGSTOP):
                signal.signal(number, signal.SIG_DFL)  # a sheet in the background inherits an ignored SIGINT
        if not launch.outside:
            network.join()
        namespace.die_with_parent(parent)  # after join(), which would make the kernel forget it

    environment = {**os.environ, **launch.environment}
    with open(log_path, "ab", buffering=0) as log:
        log.write(f"--- {shlex.join(launch.arguments)}\n".encode())
        try:
            child = subprocess.Popen(launch.arguments, env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                                     start_new_session=True, preexec_fn=prepare)
        except subprocess.SubprocessError:  # all it says of prepare()
            raise OSError(errno.EPERM, "it could not enter the private network") from None
    child.returncode = 0  # the sheet collects its children itself; subprocess must not
    return child.pid


def last_log_line(path, limit=200):
    """The last line that says something, without terminal codes; "" when there is none."""
    try:
        with open(path, "rb") as file:
            file.seek(max(0, os.fstat(file.fileno()).st_size - 4096))
            lines = _TERMINAL_CODES.sub("", file.read().decode("utf-8", "replace")).splitlines()
    except OSError:
        return ""
    for line in reversed(lines):
        text = "".join(character for character in line if character.isprintable()).strip()
        if text:
            return "" if text.startswith("--- ") else text[:limit]
    return ""


def _is_alive(pid):
    entry = procfs.usage(pid)
    return entry is not None and entry.state != "Z"


def _signal_one(call, target, number):
    """Whether there was somebody to signal."""
    try:
        call(target, number)
        return True
    except (ProcessLookupError, PermissionError):
        return False
