# SPDX-License-Identifier: BSD-3-Clause
"""One thread's event loop: timers, readable sockets and signals. It sleeps until something happens."""

import heapq
import itertools
import selectors
import signal
import socket
import time


class Loop:
    def __init__(self):
        self._selector = selectors.DefaultSelector()
        self._timers = []  # heap of [due, order, callback]; callback None when cancelled
        self._order = itertools.count()
        self._signals = {}
        self._running = False
        # The C handler writes the signal's number here; nothing of ours runs inside a handler.
        self._wakeup, write_end = socket.socketpair()
        self._wakeup.setblocking(False)
        write_end.setblocking(False)
        self._write_end = write_end
        signal.set_wakeup_fd(write_end.fileno(), warn_on_full_buffer=False)
        self.on_readable(self._wakeup, self._take_signals)

    @staticmethod
    def now():
        """Seconds on a clock that only goes forward."""
        return time.monotonic()

    def after(self, seconds, callback):
        """Call back once; the returned timer can be given to cancel()."""
        timer = [self.now() + seconds, next(self._order), callback]
        heapq.heappush(self._timers, timer)
        return timer

    @staticmethod
    def cancel(timer):
        """Forget a timer; None and one that has fired are fine."""
        if timer:
            timer[2] = None

    def on_readable(self, file, callback):
        """Call back whenever `file` can be read."""
        self._selector.register(file, selectors.EVENT_READ, callback)

    def forget(self, file):
        """Stop watching `file`."""
        self._selector.unregister(file)

    def on_signal(self, number, callback):
        """Call back, from the loop, after each signal of that number (several close together may be one)."""
        self._signals[number] = callback
        signal.signal(number, lambda *_: None)

    def stop(self):
        """run() returns after the current callback."""
        self._running = False

    def run(self):
        self._running = True
        while self._running:
            self._fire_timers()
            if not self._running:
                return
            timeout = max(0.0, self._timers[0][0] - self.now()) if self._timers else None
            for key, _ in self._selector.select(timeout):
                if self._running and key.fileobj in self._selector.get_map():
                    key.data()

    def _fire_timers(self):
        now = self.now()
        while self._running and self._timers and (self._timers[0][0] <= now or self._timers[0][2] is None):
            _, _, callback = heapq.heappop(self._timers)
            if callback:
                callback()

    def _take_signals(self):
        try:
            numbers = set(self._wakeup.recv(4096))
        except BlockingIOError:
            return
        for number in sorted(numbers):
            if number in self._signals:
                self._signals[number]()
