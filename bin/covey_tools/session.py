# SPDX-License-Identifier: BSD-3-Clause
"""What a team said while it ran, from logs of its buses: keyframes, loop closures, and what was made of these.

The same message may stand in several logs and several times in one: it counts once.
"""

import math
import os
from dataclasses import dataclass

import numpy

from covey_tools import lcm_log, messages

_TYPES = {"KEYFRAME": "keyframe_t", "LOOP": "loop_t", "LOOP_WEIGHTS": "loop_weights_t", "TRAJECTORY": "trajectory_t"}
_CLOSURE_FLOOR = [0.03] * 3 + [math.radians(0.3)] * 3  # dpgo's, unless it is told otherwise: m, rad


@dataclass
class Keyframe:
    utime: int  # us
    T_O_K: tuple  # motions, as in motion.py
    T_P_K: tuple  # from the keyframe before
    precision: tuple  # kappa, tau of T_P_K


@dataclass
class Loop:
    a: tuple  # names of keyframes: (robot, segment, id)
    b: tuple
    T_A_B: tuple
    precision: tuple  # kappa, tau


@dataclass
class Weight:
    """Of a closure between a and b, in the last round of the robot that answers for it: the lower one."""

    a: tuple
    b: tuple
    weight: float
    residual_sq: float


class Session:
    """keyframes: {name: Keyframe}; loops: [Loop]; weights: [Weight]; rounds: {(anchor, round): robots that ended it}."""

    def __init__(self, logs):
        self.keyframes = {}
        self.rounds = {}
        self._loops = {}
        self._weights = {}  # robot -> (utime, {part: message})
        for log in logs:
            if os.path.exists(log):
                self._read(log)

    @property
    def loops(self):
        return list(self._loops.values())

    @property
    def weights(self):
        found = []
        for robot, (_, parts) in sorted(self._weights.items()):
            found += [each for part in parts.values() for each in _weights(part)
                      if robot == min(each.a[0], each.b[0])]
        return found

    def segments(self, robot):
        """{segment: [Keyframe by id, as far as there is no gap]}, ascending."""
        found = {}
        for (owner, segment, number), keyframe in sorted(self.keyframes.items()):
            if owner == robot and number == len(found.setdefault(segment, [])):
                found[segment].append(keyframe)
        return {segment: keyframes for segment, keyframes in found.items() if keyframes}

    def count(self, robot):
        return sum(name[0] == robot for name in self.keyframes)

    def _read(self, log):
        for event in lcm_log.Log(log):
            if event.channel in _TYPES:
                message = messages.decode(_TYPES[event.channel], event.data)
                if message:
                    getattr(self, f"_take_{event.channel.lower()}")(message)

    def _take_keyframe(self, message):
        name = (message.robot, message.segment, message.id)
        if name not in self.keyframes:
            self.keyframes[name] = Keyframe(message.utime, (tuple(message.q_O_K), tuple(message.t_O_K)),
                                            (tuple(message.q_P_K), tuple(message.t_P_K)),
                                            precision(message.covariance))

    def _take_loop(self, message):
        a = (message.robot_a, message.segment_a, message.id_a)
        b = (message.robot_b, message.segment_b, message.id_b)
        T_A_B = (tuple(message.q_A_B), tuple(message.t_A_B))
        self._loops.setdefault((a, b, T_A_B), Loop(a, b, T_A_B, precision(floored(message.covariance))))

    def _take_loop_weights(self, message):
        utime, parts = self._weights.get(message.robot, (0, {}))
        if message.utime > utime:
            parts = {}
            self._weights[message.robot] = (message.utime, parts)
        if message.utime >= utime:
            parts[message.part] = message

    def _take_trajectory(self, message):
        self.rounds.setdefault((message.anchor, message.round), set()).add(message.robot)


def floored(covariance):
    """A closure's covariance as dpgo counts it (core/pgo/edge_noise.h)."""
    scaled = numpy.array(covariance).reshape(6, 6) / numpy.outer(_CLOSURE_FLOOR, _CLOSURE_FLOOR)
    if not scaled.any():
        return covariance
    values, vectors = numpy.linalg.eigh(scaled)
    kept = (vectors * numpy.maximum(values, 1.0)) @ vectors.T * numpy.outer(_CLOSURE_FLOOR, _CLOSURE_FLOOR)
    return [float(value) for value in kept.ravel()]


def precision(covariance):
    """kappa, tau of a 6x6 covariance of [rho; phi] (CONVENTIONS.md); 1, 1 where there is none."""
    translation, rotation = (sum(covariance[7 * k] for k in each) for each in ((0, 1, 2), (3, 4, 5)))
    return (1.5 / rotation, 3.0 / translation) if min(translation, rotation) > 0 else (1.0, 1.0)


def _weights(part):
    return [Weight(*each) for each in zip(zip(part.robots_a, part.segments_a, part.ids_a),
                                          zip(part.robots_b, part.segments_b, part.ids_b),
                                          part.weights, part.residuals_sq)]
