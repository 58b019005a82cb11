# SPDX-License-Identifier: BSD-3-Clause
"""What /proc says about processes: parents, CPU time, memory."""

import os
from dataclasses import dataclass

_TICKS_PER_S = os.sysconf("SC_CLK_TCK")
_PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")


@dataclass
class Usage:
    parent: int
    state: str  # "Z" for one that has ended and was not collected
    group: int
    cpu_s: float
    rss_bytes: int


def usage(pid):
    """The Usage of a process, or None when there is no such process."""
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as file:
            field = file.read().rpartition(")")[2].split()  # the name before ')' may hold anything
    except OSError:
        return None
    return Usage(int(field[1]), field[0], int(field[2]), (int(field[11]) + int(field[12])) / _TICKS_PER_S,
                 int(field[21]) * _PAGE_BYTES)


def descendants(pid):
    """Process ids of all living children, grandchildren and so on of `pid`, parents before children."""
    children = {}
    for name in filter(str.isdigit, os.listdir("/proc")):
        entry = usage(name)
        if entry and entry.state != "Z":
            children.setdefault(entry.parent, []).append(int(name))
    found, waiting = [], [pid]
    while waiting:
        for child in children.get(waiting.pop(0), []):
            found.append(child)
            waiting.append(child)
    return found
