# SPDX-License-Identifier: BSD-3-Clause
"""Rigid motions and trajectory files, as much of them as pictures and reports need.

A motion is (q, t): q = (w, x, y, z) of norm 1, t = (x, y, z) in m. A trajectory is a list of (stamp in s, motion).
"""

import bisect
import math

IDENTITY = ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def rotate(q, v):
    """R(q) v."""
    w, x, y, z = q
    # v + 2 w (u x v) + 2 u x (u x v), with u the vector part
    c = (y * v[2] - z * v[1], z * v[0] - x * v[2], x * v[1] - y * v[0])
    d = (y * c[2] - z * c[1], z * c[0] - x * c[2], x * c[1] - y * c[0])
    return tuple(v[k] + 2.0 * (w * c[k] + d[k]) for k in range(3))


def compose(a, b):
    """T_A_B, T_B_C -> T_A_C."""
    (aw, ax, ay, az), (bw, bx, by, bz) = a[0], b[0]
    q = (aw * bw - ax * bx - ay * by - az * bz, aw * bx + ax * bw + ay * bz - az * by,
         aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw)
    norm = math.sqrt(sum(each * each for each in q))
    moved = rotate(a[0], b[1])
    return tuple(each / norm for each in q), tuple(a[1][k] + moved[k] for k in range(3))


def inverse(a):
    q = (a[0][0], -a[0][1], -a[0][2], -a[0][3])
    return q, tuple(-each for each in rotate(q, a[1]))


def chain(steps, start=IDENTITY):
    """The trajectory that odometry steps [qx, qy, qz, qw, tx, ty, tz] make, a pose a second from 1 s on."""
    pose, trajectory = start, [(1.0, start)]
    for qx, qy, qz, qw, *t in steps:
        pose = compose(pose, ((qw, qx, qy, qz), tuple(t)))
        trajectory.append((len(trajectory) + 1.0, pose))
    return trajectory


def moved(trajectory, motion):
    """Every pose seen from another frame: T_A_B for poses in B."""
    return [(stamp, compose(motion, pose)) for stamp, pose in trajectory]


def length(trajectory):
    """m, along the positions."""
    return sum(math.dist(a[1][1], b[1][1]) for a, b in zip(trajectory, trajectory[1:]))


def read_tum(path):
    """A trajectory; lines that are no pose are left out (evaluate is the one that complains)."""
    trajectory = []
    with open(path, encoding="ascii", errors="replace") as lines:
        for line in lines:
            fields = line.split()
            if len(fields) != 8 or line.startswith("#"):
                continue
            try:
                stamp, x, y, z, qx, qy, qz, qw = map(float, fields)
            except ValueError:
                continue
            trajectory.append((stamp, ((qw, qx, qy, qz), (x, y, z))))
    return trajectory


def write_tum(path, trajectory):
    with open(path, "w", encoding="ascii") as file:
        for stamp, (q, t) in trajectory:
            position = " ".join(f"{each:.9f}" for each in t)
            rotation = " ".join(f"{each:.12f}" for each in (q[1], q[2], q[3], q[0]))
            file.write(f"{stamp:.6f} {position} {rotation}\n")


def at(trajectory, stamps, within_s=0.01):
    """The trajectory's pose nearest to each of the stamps, None where none is so near; both ascend."""
    times = [stamp for stamp, _ in trajectory]
    found = []
    for stamp in stamps:
        index = bisect.bisect_left(times, stamp)
        near = min(trajectory[max(0, index - 1):index + 1], key=lambda each: abs(each[0] - stamp), default=None)
        found.append(near[1] if near and abs(near[0] - stamp) <= within_s else None)
    return found
