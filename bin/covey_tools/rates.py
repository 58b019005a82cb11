# SPDX-License-Identifier: BSD-3-Clause
"""What flows on a bus: per channel the rate, the bandwidth, the size and the age of the newest message."""

from collections import deque
from dataclasses import dataclass, field

WINDOW_S = 5.0  # a live rate is a mean over this


@dataclass
class Channel:
    name: str
    count: int = 0
    total_bytes: int = 0
    last_s: float = 0.0
    recent: deque = field(default_factory=deque)  # (when, bytes) within the window


@dataclass
class Row:
    channel: str
    count: int
    hz: float
    kb_per_s: float
    mean_bytes: float
    age_s: float


class Rates:
    """`window_s` None: means over everything, from the first message of any channel to `now`."""

    def __init__(self, window_s=None):
        self._window_s = window_s
        self._channels = {}
        self._start_s = None

    def start(self, now_s):
        """Rates count from here, rather than from the first message."""
        self._start_s = now_s

    def add(self, name, size_bytes, now_s):
        if self._start_s is None:
            self._start_s = now_s
        channel = self._channels.setdefault(name, Channel(name))
        channel.count += 1
        channel.total_bytes += size_bytes
        channel.last_s = now_s
        if self._window_s:
            channel.recent.append((now_s, size_bytes))

    def rows(self, now_s):
        """Rows in the channels' order of names."""
        return [self._row(channel, now_s) for _, channel in sorted(self._channels.items())]

    def _row(self, channel, now_s):
        count, size = channel.count, channel.total_bytes
        span = now_s - (self._start_s or 0.0)
        if self._window_s:
            while channel.recent and channel.recent[0][0] < now_s - self._window_s:
                channel.recent.popleft()
            count, size = len(channel.recent), sum(each for _, each in channel.recent)
            span = min(self._window_s, span)
        rate = 1.0 / span if span > 0 else 0.0
        return Row(channel.name, channel.count, count * rate, size * rate / 1000, channel.total_bytes / channel.count,
                   now_s - channel.last_s)


def table(rows):
    """The rows as lines of text."""
    width = max([7] + [len(row.channel) for row in rows])
    lines = [f"{'channel':{width}}  {'Hz':>8}  {'kB/s':>9}  {'bytes':>9}  {'age':>8}  {'messages':>9}"]
    for row in rows:
        lines.append(f"{row.channel:{width}}  {row.hz:8.1f}  {row.kb_per_s:9.2f}  {row.mean_bytes:9,.0f}  "
                     f"{age(row.age_s):>8}  {row.count:9,}")
    total = f"{sum(row.hz for row in rows):8.1f}  {sum(row.kb_per_s for row in rows):9.2f}"
    return lines + [f"{'all':{width}}  {total}  {'':9}  {'':8}  {sum(row.count for row in rows):9,}"]


def age(seconds):
    return f"{1000 * seconds:.0f} ms" if seconds < 1 else f"{seconds:.1f} s" if seconds < 100 else f"{seconds:.0f} s"
