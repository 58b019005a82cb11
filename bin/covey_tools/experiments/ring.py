# SPDX-License-Identifier: BSD-3-Clause
"""A pose graph with a planted local minimum: odometry, weak, goes around a circle twice, loops, strong, say once.

The loops reach three poses ahead, so that wound twice each is as content as one can be that all share alike: no small move helps. From
odometry a solver ends there, from the chordal relaxation at the optimum. Cut into robots of three poses no loop is a robot's own,
and each odometry edge stands five times, so that across a cut the four loops or fewer are outvoted: a team's start is wound, too.
"""

import math

POSES = 30
ROBOTS = 10
BARC2 = 1e9  # rejects nothing
_KAPPA = {"odometry": 0.2, "loop": 100.0}
_TAU_OF_KAPPA = 0.01  # rotations decide
_COPIES = 5


def write(path):
    """In g2o."""
    turn = 2 * math.pi / POSES
    edges = [_edge(k, k + 1, 1, 2 * turn, _KAPPA["odometry"]) for k in range(POSES - 1)] * _COPIES
    edges += [_edge(k, (k + 3) % POSES, 3, turn, _KAPPA["loop"]) for k in range(POSES)]
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(edges) + "\n")


def _edge(begin, end, steps, turn, kappa):
    """So many steps of 1 m, each followed by a turn about z."""
    x = sum(math.cos(k * turn) for k in range(steps))
    y = sum(math.sin(k * turn) for k in range(steps))
    half = steps * turn / 2
    tau = _TAU_OF_KAPPA * kappa
    information = f"{tau} 0 0 0 0 0 {tau} 0 0 0 0 {tau} 0 0 0 {kappa} 0 0 {kappa} 0 {kappa}"
    return f"EDGE_SE3:QUAT {begin} {end} {x:.9f} {y:.9f} 0 0 0 {math.sin(half):.9f} {math.cos(half):.9f} {information}"
