# SPDX-License-Identifier: BSD-3-Clause
"""The pose graph that a team solved from sensors, as files that evaluate and pgo read.

A chain is one segment of a robot's odometry: a robot whose vio was started again has several. No odometry crosses
segments, so each chain stands for a robot of its own in the graph's files, and pairs of chains count for pairs of robots.

    robot<c>.csv   the edges that touch chain c
    weights.lcm    the team's word on its closures
    robot<c>.tum   in other folders: the chain's poses in some trajectory, pose k at k + 1 s
"""

import csv
import os
from dataclasses import dataclass

from covey_tools import lcm_log, messages, motion

_COLUMNS = ("robot_src", "pose_src", "robot_dst", "pose_dst", "qx", "qy", "qz", "qw", "tx", "ty", "tz", "kappa", "tau",
            "is_known_inlier", "weight")


@dataclass
class Chain:
    robot: int
    segment: int
    keyframes: list  # session.Keyframe, by id


class Chains:
    """Of the keyframes that have a pose in `solution` ({robot: trajectory}), and the closures between them."""

    def __init__(self, session, solution, folder):
        self.folder = folder
        self._session = session
        placed = {robot: {round(stamp * 1e6) for stamp, _ in trajectory} for robot, trajectory in solution.items()}
        chains = [Chain(robot, segment, _placed(keyframes, placed[robot]))
                  for robot in solution for segment, keyframes in session.segments(robot).items()]
        chains = [chain for chain in chains if chain.keyframes]
        self.chains = [chain for chain in chains if len(chain.keyframes) > 1 or self._is_tied(chain, chains)]
        self._index = {(chain.robot, chain.segment): index for index, chain in enumerate(self.chains)}
        self.loops = [loop for loop in session.loops if self._id(loop.a) and self._id(loop.b)]
        os.makedirs(folder, exist_ok=True)
        self._write_edges()
        self._write_weights()

    @property
    def weights(self):
        return os.path.join(self.folder, "weights.lcm")

    def write(self, ways, folder):
        """Files of the chains' poses in `ways` ({robot: trajectory by utime}); the nearest pose within 10 ms counts."""
        files = []
        os.makedirs(folder, exist_ok=True)
        for index, chain in enumerate(self.chains):
            files.append(os.path.join(folder, f"robot{index}.tum"))
            poses = motion.at(ways[chain.robot], [keyframe.utime * 1e-6 for keyframe in chain.keyframes])
            motion.write_tum(files[-1], [(k + 1.0, pose) for k, pose in enumerate(poses) if pose])
        return files

    def by_robot(self, files):
        """The poses of such files in time again: {robot: trajectory}."""
        ways = {}
        for chain, file in zip(self.chains, files):
            poses = [pose for _, pose in motion.read_tum(file)]
            ways.setdefault(chain.robot, []).extend(
                (keyframe.utime * 1e-6, pose) for keyframe, pose in zip(chain.keyframes, poses))
        return {robot: sorted(way) for robot, way in ways.items()}

    def pairs(self, scores, robots):
        """evaluate's scores of pairs of chains, summed for every pair of robots a <= b; all that were found are in total."""
        sums = {(a, b): {"a": a, "b": b, "total": 0, "accepted": 0, "true": 0, "true_total": 0}
                for a in robots for b in robots if a <= b}
        for score in scores:
            pair = sums[tuple(sorted((self.chains[score["a"]].robot, self.chains[score["b"]].robot)))]
            for name in ("accepted", "true", "true_total"):
                pair[name] += score.get(name, 0)
        for loop in self._session.loops:
            pair = sums.get(tuple(sorted((loop.a[0], loop.b[0]))))
            if pair:
                pair["total"] += 1
        return list(sums.values())

    def _is_tied(self, chain, chains):
        """Whether a closure joins this one to another."""
        known = {(each.robot, each.segment) for each in chains}
        ends = [(loop.a[:2], loop.b[:2]) for loop in self._session.loops]
        return any((chain.robot, chain.segment) in pair and set(pair) <= known for pair in ends)

    def _id(self, name):
        """(chain, pose) of a keyframe's name, or None."""
        robot, segment, number = name
        index = self._index.get((robot, segment))
        return (index, number) if index is not None and number < len(self.chains[index].keyframes) else None

    def _write_edges(self):
        edges = []
        for index, chain in enumerate(self.chains):
            edges += [((index, k), (index, k + 1), keyframe.T_P_K, keyframe.precision, 1)
                      for k, keyframe in enumerate(chain.keyframes[1:])]
        edges += [(self._id(loop.a), self._id(loop.b), loop.T_A_B, loop.precision, 0) for loop in self.loops]
        for index in range(len(self.chains)):
            with open(os.path.join(self.folder, f"robot{index}.csv"), "w", encoding="ascii", newline="") as file:
                writer = csv.writer(file, lineterminator="\n")
                writer.writerow(_COLUMNS)
                for a, b, (q, t), (kappa, tau), known in edges:
                    if index in (a[0], b[0]):
                        writer.writerow([*a, *b, *map(repr, (*q[1:], q[0], *t, kappa, tau)), known, 1])

    def _write_weights(self):
        """LOOP_WEIGHTS with chains for robots; each by the chain that answers for it, the lower one."""
        said = {}
        for each in self._session.weights:
            a, b = self._id(each.a), self._id(each.b)
            if a and b:
                said.setdefault(min(a[0], b[0]), []).append((a, b, each))
        log = lcm_log.Writer(self.weights)
        for index, entries in sorted(said.items()):
            message = messages.message_type("loop_weights_t")()
            message.utime, message.robot, message.parts, message.n = 1, index, 1, len(entries)
            for (chain_a, id_a), (chain_b, id_b), each in entries:
                message.robots_a.append(chain_a)
                message.ids_a.append(id_a)
                message.robots_b.append(chain_b)
                message.ids_b.append(id_b)
                message.weights.append(each.weight)
                message.residuals_sq.append(each.residual_sq)
            message.segments_a = message.segments_b = [0] * message.n
            log.write("LOOP_WEIGHTS", message.encode(), 1)
        log.close()


def _placed(keyframes, stamps):
    """As many from the first one on as have a pose."""
    count = next((k for k, keyframe in enumerate(keyframes) if keyframe.utime not in stamps), len(keyframes))
    return keyframes[:count]
