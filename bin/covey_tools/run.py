# SPDX-License-Identifier: BSD-3-Clause
"""Runs a sheet: its script, its processes, until there is nothing left to do or somebody says stop.

The sheet ends when its script is through and no process is left, when the --until-exit command ends, after --duration,
at Ctrl-C, SIGTERM or SIGHUP, or when a process that was waited for cannot come any more. Ending means: every process is
told to stop, the last started first, so that a logger started first hears the others out; each has its
stop_time_allowed; whatever is alive after that, however far it is removed, is killed.
"""

import os
import signal
import time
from dataclasses import dataclass, field

from covey_tools import procfs
from covey_tools.grammar import SheetError
from covey_tools.process import Process
from covey_tools.ready import Ready

STOP_GAP_S = 0.2  # between two stop signals at the end, unless the first of the two is gone before


@dataclass
class Plan:
    """What of a sheet is to be run."""

    actions: list  # of the script, flat; [] starts everything
    commands: list  # that it starts, in the file's order


@dataclass
class Limits:
    until_exit: str = ""  # command id
    duration_s: float = 0.0  # 0: none
    ready_timeout_s: float = 60.0


@dataclass
class Outcome:
    exit_code: int = 0
    errors: list = field(default_factory=list)  # sentences


def make_plan(sheet, script_name):
    """The Plan for a script ("" for everything); refuses a script that waits for what it never starts."""
    if not script_name:
        return Plan([], list(sheet.commands))
    actions = sheet.flatten(script_name)
    started = set()
    for action in actions:
        ids = {command.id for command in sheet.select(action.target, action.name)} if action.target else set()
        if action.kind in ("start", "restart"):
            started |= ids
        elif action.status == "running" and not ids <= started:
            raise SheetError(action.place, f'script "{script_name}" waits here for "{min(ids - started)}" to run, '
                             "which it has not started; expected a start before it")
    return Plan(actions, [command for command in sheet.commands if command.id in started])


class Run:
    """`make_launches(network)` -> {command id: Launch} for every command of the plan. Call run() once."""

    def __init__(self, loop, sheet, plan, make_launches, network, view, log_path, targets, limits):
        self._loop, self._sheet, self._plan, self._view, self._limits = loop, sheet, plan, view, limits
        self._network, self._make_launches = network, make_launches
        launches = make_launches(network)
        self._processes = {command.id: Process(loop, command, launches[command.id], log_path(command), network,
                                               self._report, self._on_change) for command in plan.commands}
        self._ready = Ready(loop, network, targets, self._on_heard)
        self._at = 0  # the next action
        self._until = None  # () -> bool that the script waits for
        self._timer = None
        self._through = False  # the script is
        self._ending = False
        self._job_ended = False  # the --until-exit command
        self._stop_queue = []
        self._current = None  # was told to stop last
        self._gap_s = STOP_GAP_S
        self._outcome = Outcome()

    def run(self):
        """The Outcome, when no process is left."""
        self._loop.on_signal(signal.SIGCHLD, self._collect)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            self._loop.on_signal(number, self._interrupted(signal.Signals(number).name))
        self._view.watch(list(self._processes.values()))
        self._loop.after(0, self._begin)
        self._loop.run()
        self._kill_orphans()
        self._ready.close()
        return self._outcome

    def _begin(self):
        if self._limits.duration_s:
            self._loop.after(self._limits.duration_s, lambda: self.end(f"{self._limits.duration_s:g} s are over"))
        if self._ready.targets:
            self._loop.after(self._limits.ready_timeout_s, self._ready_timeout)
        if not self._plan.actions:
            for process in self._processes.values():
                process.start()
        self._advance()

    # The script

    def _advance(self):
        """Take actions until one has to wait."""
        while not self._ending and not self._through:
            if self._until:
                if not self._until():
                    return
                self._until = None
            if self._at == len(self._plan.actions):
                self._through = True
            else:
                self._at += 1
                self._act(self._plan.actions[self._at - 1])
        self._end_if_done()

    def _act(self, action):
        self._view.event("sheet", str(action))
        if action.kind == "wait_ms":
            due = self._loop.now() + action.delay_ms / 1000
            self._until = lambda: self._loop.now() >= due
            self._loop.after(action.delay_ms / 1000, self._advance)
            return
        processes = [self._processes[command.id] for command in self._sheet.select(action.target, action.name)
                     if command.id in self._processes]
        if action.kind != "wait":
            for process in processes if action.kind != "stop" else reversed(processes):
                getattr(process, action.kind)()
        if action.status == "running":
            self._until = lambda: all(self._is_up(process) for process in processes)
        elif action.status == "stopped":
            self._until = lambda: all(process.state == "stopped" for process in processes)

    def _is_up(self, process):
        """procman's "running" is also true of one that ran and ended; and here of one only when it has been heard."""
        return process.starts > 0 and process.state != "stopping" and self._ready.is_ready(process.command.id)

    # What happens

    def _on_change(self, process):
        is_job = process.command.id == self._limits.until_exit
        if is_job and process.exit_code is not None and not process.pid and not self._ending:
            code = process.exit_code if process.exit_code >= 0 else 128 - process.exit_code
            self._outcome.exit_code = code
            self._job_ended = True
            self.end(f"{process.command.id} ended with {code}")
        elif process.state == "stopped" and not self._ready.is_ready(process.command.id) and not self._ending:
            self._outcome.errors.append(f"{process.command.id} ended before it published STATUS; "
                                        f"its log is {process.log_path}")
            self.end("a process that was waited for is gone")
        self._loop.after(0, self._advance)

    def _on_heard(self, target):
        self._view.event(target.command_id or target.label, "publishes STATUS")
        if not self._ready.missing:
            self._view.event("sheet", f"ready: {len(self._ready.targets)} of {len(self._ready.targets)} publish STATUS")
        self._loop.after(0, self._advance)

    def _ready_timeout(self):
        if self._ready.missing and not self._ending:
            for target in self._ready.missing:
                self._outcome.errors.append(f"no STATUS from {target} in {self._limits.ready_timeout_s:g} s")
            self.end("not ready in time")

    def _interrupted(self, name):
        def interrupted():
            if self._ending:
                self._view.event("sheet", f"{name} again: killing what is left")
                self._stop_queue = []
                for process in self._processes.values():
                    process.kill()
            self.end(name)
        return interrupted

    def _report(self, process, text):
        self._view.event(process.command.id, text)

    def _collect(self):
        """Collect every child that ended: commands, and orphans that became ours."""
        while True:
            try:
                pid, status = os.waitpid(-1, os.WNOHANG)
            except ChildProcessError:
                break
            if pid == 0:
                break
            if pid == self._network.pid:
                self._replace_holder()
            for process in self._processes.values():
                if process.pid == pid:
                    process.on_exit(os.waitstatus_to_exitcode(status))
        for process in self._processes.values():
            process.on_orphan_exit()

    def _replace_holder(self):
        self._network.hold_again()
        self._view.event("sheet",
                         f"the private network's holder was killed; process {self._network.pid} takes its place")
        launches = self._make_launches(self._network)  # the way in has another name now
        for process in self._processes.values():
            process.launch = launches[process.command.id]

    # The end

    def end(self, reason):
        """Stop everything, the last started first."""
        if self._ending:
            return
        self._ending = True
        self._view.event("sheet", f"ending: {reason}")
        alive = [process for process in self._processes.values() if process.state != "stopped"]
        if self._limits.until_exit and not self._job_ended:
            self._outcome.errors.append(f"{self._limits.until_exit} had not ended yet")
        if self._outcome.errors or (not self._limits.until_exit and self._any_failed()):
            self._outcome.exit_code = self._outcome.exit_code or 1
        self._stop_queue = sorted(alive, key=lambda process: process.started_s, reverse=True)
        self._gap_s = min([STOP_GAP_S] + [process.command.stop_time_allowed_s / (2 * len(alive)) for process in alive])
        self._stop_next()

    def _stop_next(self):
        self._loop.cancel(self._timer)
        while self._stop_queue:
            process = self._stop_queue.pop(0)
            process.stop()
            if process.state != "stopped" and self._stop_queue:
                self._timer = self._loop.after(self._gap_s, self._stop_next)
                self._current = process
                return
        self._current = None
        self._end_if_done()

    def _end_if_done(self):
        if self._ending and self._stop_queue and self._current and self._current.state == "stopped":
            self._stop_next()
            return
        if any(process.state != "stopped" for process in self._processes.values()):
            return
        if self._ending:
            self._loop.stop()
        elif self._through and not self._ready.missing:
            self.end("every process has ended")

    def _any_failed(self):
        return any(process.failed and process.state == "stopped" for process in self._processes.values())

    def _kill_orphans(self):
        """Nobody of ours outlives the sheet, not even what daemonised itself: adopt_orphans() made it ours."""
        deadline = time.monotonic() + 2.0
        told = False
        while time.monotonic() < deadline:
            orphans = [pid for pid in procfs.descendants(os.getpid()) if pid != self._network.pid]
            if not orphans:
                return
            if not told:
                self._view.event("sheet", f"killing {len(orphans)} left-over processes")
                told = True
            for pid in orphans:
                try:
                    os.kill(pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass
            time.sleep(0.01)  # bounded by the deadline; SIGCHLD has no reader any more
