# SPDX-License-Identifier: BSD-3-Clause
"""Faults of a robot's IMU and cameras, injected into the log of a run that had none.

A fault is a function item -> items, for the items of its stretch: what happens to a message on its way from the sensor to the log. What it
needs to remember (the picture before, dice) is in its closure, so each run makes its own.
"""

import copy
import heapq
import random
from dataclasses import dataclass, field, replace
from typing import Callable

import numpy

from covey_tools import lcm_log, messages
from covey_tools.errors import Failure

_BAND_BYTES = 60_000  # core/base/bands.h
_BAND_SPACING_US = 500
_LATEST_S = 1.0  # nothing is delayed for longer
_GYRO_FULL, _ACCEL_FULL = 17.45, 176.6  # rad/s and m/s^2: the ADIS16448's 1000 deg/s and 18 g
_WRONG_BY_US = (400_000, -400_000, 20_000, -20_000, 10**15, None)  # None: no stamp at all, 0


@dataclass(order=True)
class Item:
    """A message of a sensor, and when it is in the log."""

    at: int  # us
    kind: str = field(compare=False)  # IMU or STEREO
    message: object = field(compare=False)


@dataclass
class Fault:
    name: str
    seconds: float  # how long it lasts; inf: to the end
    words: str
    make: Callable  # seed -> (Item -> [Item])


def inject(log, out, fault, begin_s, seed):
    """The log again, with the fault from begin_s after its first event on."""
    stretch, treat = None, fault.make(seed)
    writer = _Writer(out)
    try:
        for item in _items(log):
            if stretch is None:
                stretch = item.at + begin_s * 1e6, item.at + (begin_s + fault.seconds) * 1e6
            writer.put(treat(item) if stretch[0] <= item.at < stretch[1] else [item], item.at)
        writer.finish()
    except OSError as error:
        raise Failure(f"{out}: {error.strerror.lower()}") from None


def _items(log):
    parts = []
    for event in lcm_log.Log(log):
        if event.channel == "IMU":
            yield Item(event.utime, "IMU", messages.decode("imu_t", event.data))
        elif event.channel == "STEREO":
            band = messages.decode("band_t", event.data)
            parts = [*parts, bytes(band.data)] if band.band else [bytes(band.data)]
            if len(parts) == band.bands:
                yield Item(band.utime, "STEREO", messages.decode("stereo_t", b"".join(parts)))


class _Writer:
    """Puts items into the order of their times, and pictures into bands."""

    def __init__(self, path):
        self._log = lcm_log.Writer(path)
        self._waiting, self._count, self._pictures = [], 0, 0
        self._run = None

    def put(self, items, now):
        for item in items:
            heapq.heappush(self._waiting, (item.at, self._count, item))
            self._count += 1
        self._write_until(now - _LATEST_S * 1e6)

    def finish(self):
        self._write_until(float("inf"))
        self._log.close()

    def _write_until(self, time):
        while self._waiting and self._waiting[0][0] < time:
            item = heapq.heappop(self._waiting)[2]
            if item.kind == "IMU":
                self._log.write("IMU", item.message.encode(), item.at)
            else:
                self._write_bands(item)

    def _write_bands(self, item):
        payload = item.message.encode()
        self._run = item.at if self._run is None else self._run
        bands = range(0, len(payload), _BAND_BYTES)
        for index, start in enumerate(bands):
            band = messages.message_type("band_t")()
            band.utime, band.run, band.number, band.band, band.bands = item.message.utime, self._run, self._pictures, index, len(bands)
            band.total_bytes = len(payload)
            band.data = payload[start:start + _BAND_BYTES]
            band.n = len(band.data)
            self._log.write("STEREO", band.encode(), item.at)
        self._pictures += 1


def _pictures(change):
    """change: Item -> [Item], of STEREO alone."""
    return lambda item: change(item) if item.kind == "STEREO" else [item]


def _samples(change):
    return lambda item: change(item) if item.kind == "IMU" else [item]


def _with(item, **values):
    message = copy.copy(item.message)
    for name, value in values.items():
        setattr(message, name, value)
    return [replace(item, message=message)]


def _lost(item):
    return []


def _some_lost(share):
    def make(seed):
        dice = random.Random(seed)
        return _pictures(lambda item: [] if dice.random() < share else [item])
    return make


def _late(seconds):
    return lambda _: _pictures(lambda item: [replace(item, at=item.at + round(seconds * 1e6))])


def _each(kind, every, change):
    """change: (Item, how many were changed with it) -> [Item], of each so many-th of that kind."""
    def make(_):
        count = 0

        def treat(item):
            nonlocal count
            if item.kind != kind:
                return [item]
            count += 1
            return change(item, count // every) if count % every == 0 else [item]
        return treat
    return make


def _overtaken(kind, every, seconds):
    """Each so many-th comes after its successor."""
    return _each(kind, every, lambda item, _: [replace(item, at=item.at + round(seconds * 1e6))])


def _sides_swapped(item):
    message = item.message
    return _with(item, left=message.right, n_left=message.n_right, right=message.left, n_right=message.n_left)


def _black(item):
    black = bytes(item.message.n_left)
    return _with(item, left=black, right=black)


def _grey(seed):
    """A wall without a mark, close by: a grey value, and the noise of the pixels."""
    dice = numpy.random.RandomState(seed)

    def treat(item):
        def side():
            return dice.normal(110.0, 2.5, item.message.n_left).clip(0.0, 255.0).astype(numpy.uint8).tobytes()
        return _with(item, left=side(), right=side())
    return _pictures(treat)


def _frozen(_):
    first = None

    def treat(item):
        nonlocal first
        first = first or item.message
        return _with(item, left=first.left, right=first.right)
    return _pictures(treat)


def _no_right(item):
    return _with(item, right=b"", n_right=0)


def _no_left(item):
    return _with(item, left=b"", n_left=0)


def _pinned(item):
    return _with(item, gyro=[_GYRO_FULL, -_GYRO_FULL, _GYRO_FULL], accel=[_ACCEL_FULL, _ACCEL_FULL, -_ACCEL_FULL])


def _clipped(gyro, accel):
    def clip(values, limit):
        return [min(limit, max(-limit, value)) for value in values]
    return lambda _: _samples(lambda item: _with(item, gyro=clip(item.message.gyro, gyro), accel=clip(item.message.accel, accel)))


def _stamps_wrong(kind, every):
    def change(item, number):
        by = _WRONG_BY_US[number % len(_WRONG_BY_US)]
        return _with(item, utime=0 if by is None else item.message.utime + by)
    return _each(kind, every, change)


def _plain(treat):
    return lambda _: treat


FAULTS = (
    Fault("missing_half", 10.0, "each other picture is lost, at random", _some_lost(0.5)),
    Fault("missing_1s", 1.0, "no pictures", _plain(_pictures(_lost))),
    Fault("missing_2s", 2.0, "no pictures", _plain(_pictures(_lost))),
    Fault("late", 5.0, "pictures come 0.3 s late", _late(0.3)),
    Fault("doubled", 5.0, "pictures and samples come twice", _plain(lambda item: [item, item])),
    Fault("order", 5.0, "each third picture comes after the next one", _overtaken("STEREO", 3, 0.06)),
    Fault("order_imu", 5.0, "each tenth sample comes after the next one", _overtaken("IMU", 10, 0.006)),
    Fault("sides", 1.0, "left for right", _plain(_pictures(_sides_swapped))),
    Fault("black_1s", 1.0, "black pictures", _plain(_pictures(_black))),
    Fault("flicker", 5.0, "each third picture is black", _each("STEREO", 3, lambda item, _: _black(item))),
    Fault("featureless_1s", 1.0, "a grey wall", _grey),
    Fault("featureless_2s", 2.0, "a grey wall", _grey),
    Fault("frozen_1s", 1.0, "the same picture again and again", _frozen),
    Fault("imu_gap_0.3s", 0.3, "no samples", _plain(_samples(_lost))),
    Fault("imu_gap_1s", 1.0, "no samples", _plain(_samples(_lost))),
    Fault("imu_full_scale", 0.2, "a knock: samples at the end of the sensor's range", _plain(_samples(_pinned))),
    Fault("imu_clipped", 2.0, "turns clipped at 0.3 rad/s, accelerations at 10 m/s^2: half of what is flown", _clipped(0.3, 10.0)),
    Fault("stamps", 10.0, "each fifth picture has a wrong stamp", _stamps_wrong("STEREO", 5)),
    Fault("stamps_imu", 10.0, "each fiftieth sample has a wrong stamp", _stamps_wrong("IMU", 50)),
    Fault("right_stops_10s", 10.0, "no right picture", _plain(_pictures(_no_right))),
    Fault("right_stops", float("inf"), "no right picture any more", _plain(_pictures(_no_right))),
    Fault("left_stops_5s", 5.0, "no left picture", _plain(_pictures(_no_left))),
)
