# SPDX-License-Identifier: BSD-3-Clause
"""What a person sees of a running sheet: lines for events and, on a terminal, one line per process below them."""

import os
import shutil
import sys

from covey_tools import procfs
from covey_tools.process import last_log_line

_COLOURS = {"running": "32", "backing off": "33", "stopping": "33", "stopped": "2", "failed": "31"}


class View:
    """Event lines on stdout and in `events_path`; below them a live table where stdout is a terminal."""

    def __init__(self, loop, events_path, names):
        self._loop = loop
        self._start_s = loop.now()
        self._events = open(events_path, "w", encoding="utf-8", buffering=1)  # noqa: closed by close()
        self._live = sys.stdout.isatty() and os.environ.get("TERM") != "dumb"
        self._processes = []
        self._table_lines = 0
        self._cpu = {}  # pid -> (when, CPU seconds)
        self._name_width = max(len(name) for name in ["sheet", *names])

    def watch(self, processes):
        """Show these in the table from now on, refreshed once a second."""
        self._processes = processes
        if self._live:
            self._tick()

    def event(self, who, text):
        line = f"{self._loop.now() - self._start_s:.1f} s  {who:<{self._name_width}}  {text}"
        self._events.write(line + "\n")
        self._write(self._erase() + line + "\n" + self._table())

    def close(self):
        """Leave the last table standing."""
        if self._live:
            self._write(self._erase() + self._table())
        self._live = False
        self._events.close()

    def _tick(self):
        if self._live:
            self._write(self._erase() + self._table())
            self._loop.after(1.0, self._tick)

    @staticmethod
    def _write(text):
        try:
            sys.stdout.write(text)
            sys.stdout.flush()
        except OSError:  # the reader went away; the processes matter more
            sys.stdout = open(os.devnull, "w", encoding="utf-8")

    def _erase(self):
        lines, self._table_lines = self._table_lines, 0
        return f"\033[{lines}F\033[J" if lines else ""

    def _table(self):
        if not self._live or not self._processes:
            return ""
        columns, rows = shutil.get_terminal_size()
        head = f"{'':{self._name_width}}  state            pid   uptime  runs  CPU %     MB  last line of its log"
        lines = [f"\033[2m{head[:columns - 1]}\033[0m"]
        room = max(1, rows - 3)
        lines += [self._row(process, columns - 1) for process in self._processes[:room]]
        if len(self._processes) > room:
            lines.append(f"... and {len(self._processes) - room} more")
        self._table_lines = len(lines)
        return "\n".join(lines) + "\n"

    def _row(self, process, columns):
        state = "failed" if process.failed and process.state == "stopped" else process.state
        pid, uptime, cpu, memory = "", "", "", ""
        if process.pid:
            pid, uptime = str(process.pid), duration(self._loop.now() - process.started_s)
            cpu, memory = self._usage(process.pid)
        # cut before colouring: escape codes take no place
        row = (f"{process.command.id:{self._name_width}}  {state:11}  {pid:>7}  {uptime:>7}  {process.starts:4}  "
               f"{cpu:>5}  {memory:>5}  {last_log_line(process.log_path)}")[:columns]
        start = self._name_width + 2
        return f"{row[:start]}\033[{_COLOURS[state]}m{row[start:start + 11]}\033[0m{row[start + 11:]}"

    def _usage(self, pid):
        entry, now = procfs.usage(pid), self._loop.now()
        if not entry:
            return "", ""
        when, before = self._cpu.get(pid, (now, entry.cpu_s))
        if now - when > 0.5 or pid not in self._cpu:
            self._cpu[pid] = (now, entry.cpu_s)
        cpu = f"{100 * (entry.cpu_s - before) / (now - when):.0f}" if now > when else ""
        return cpu, f"{entry.rss_bytes / 1e6:.0f}"


def duration(seconds):
    """12 s, 3:05, 1:02:03."""
    whole = int(seconds)
    if whole < 60:
        return f"{whole} s"
    hours, minutes = divmod(whole // 60, 60)
    return (f"{hours}:{minutes:02}" if hours else f"{minutes}") + f":{whole % 60:02}"
