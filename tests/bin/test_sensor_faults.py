# SPDX-License-Identifier: BSD-3-Clause
"""Faults in a log of sensors: what each does to it and when, and how the experiment counts what vio made of them."""

import math
import os
import unittest

from support import Folder

from covey_tools import lcm_log, messages, sensor_faults
from covey_tools.experiments import faults

BEGIN_US = 1_000_000_000
SIDE = 300  # two pictures of that side are four bands


def stereo(utime, left=50, right=60):
    message = messages.message_type("stereo_t")()
    message.utime, message.width, message.height = utime, SIDE, SIDE
    message.n_left = message.n_right = SIDE * SIDE
    message.left, message.right = bytes([left]) * message.n_left, bytes([right]) * message.n_right
    return message


def imu(utime):
    message = messages.message_type("imu_t")()
    message.utime, message.gyro, message.accel = utime, [0.1, -0.6, 0.2], [0.5, 9.8, -12.0]
    return message


class SensorFaults(Folder, unittest.TestCase):
    def setUp(self):
        super().setUp()
        self.clean = os.path.join(self.folder, "clean.lcm")
        writer = sensor_faults._Writer(self.clean)
        for k in range(100):  # half a second
            utime = BEGIN_US + 5000 * k
            items = [sensor_faults.Item(utime, "STEREO", stereo(utime, left=k))] if k % 10 == 0 else []
            writer.put([*items, sensor_faults.Item(utime, "IMU", imu(utime))], utime)
        writer.finish()

    def with_fault(self, name, begin_s=0.2):
        """(samples, pictures) of the log with a fault, each as (us since the beginning when it is in the log, message)."""
        fault = next(each for each in sensor_faults.FAULTS if each.name == name)
        path = os.path.join(self.folder, "faulty.lcm")
        sensor_faults.inject(self.clean, path, fault, begin_s, 1)
        times = [event.utime for event in lcm_log.Log(path)]
        self.assertEqual(times, sorted(times))
        items = list(sensor_faults._items(path))
        found = {kind: [(item.at - BEGIN_US, item.message) for item in items if item.kind == kind] for kind in ("IMU", "STEREO")}
        return found["IMU"], found["STEREO"]

    def test_without_a_fault_in_it_the_log_is_the_same(self):
        self.with_fault("missing_1s", begin_s=10.0)
        with open(self.clean, "rb") as a, open(os.path.join(self.folder, "faulty.lcm"), "rb") as b:
            self.assertEqual(a.read(), b.read())

    def test_pictures_go_missing_or_show_something_else(self):
        samples, pictures = self.with_fault("missing_1s")
        self.assertEqual(([at for at, _ in pictures], len(samples)), ([0, 50_000, 100_000, 150_000], 100))
        self.assertEqual(self.with_fault("black_1s")[1][4][1].left, bytes(SIDE * SIDE))
        self.assertEqual(self.with_fault("sides")[1][4][1].left, bytes([60]) * SIDE * SIDE)
        self.assertEqual({bytes(each.left) for _, each in self.with_fault("frozen_1s")[1][4:]}, {bytes([40]) * SIDE * SIDE})
        self.assertEqual([each.n_right for _, each in self.with_fault("right_stops")[1]], 4 * [SIDE * SIDE] + 6 * [0])
        grey = self.with_fault("featureless_1s")[1][4][1].left
        self.assertGreater(len(set(grey)), 10)
        self.assertAlmostEqual(sum(grey) / len(grey), 110.0, delta=0.5)

    def test_messages_come_late_twice_or_in_another_order(self):
        pictures = self.with_fault("order")[1]
        stamps = [each.utime - BEGIN_US for _, each in pictures]
        self.assertEqual(stamps[4:8], [200_000, 250_000, 350_000, 300_000])
        self.assertEqual(len(self.with_fault("doubled")[0]), 40 + 2 * 60)
        samples = self.with_fault("order_imu")[0]
        self.assertEqual(sum(a.utime > b.utime for (_, a), (_, b) in zip(samples, samples[1:])), 5)

    def test_samples_go_missing_or_reach_the_end_of_their_range(self):
        self.assertEqual([at for at, _ in self.with_fault("imu_gap_0.3s")[0]][40:42], [])
        clipped = self.with_fault("imu_clipped")[0][50][1]
        self.assertEqual((clipped.gyro, clipped.accel), ((0.1, -0.3, 0.2), (0.5, 9.8, -10.0)))
        self.assertGreater(self.with_fault("imu_full_scale")[0][50][1].gyro[0], 17.4)

    def test_stamps_go_wrong(self):
        wrong = [each.utime for at, each in self.with_fault("stamps_imu", begin_s=0.0)[0] if each.utime != BEGIN_US + at]
        self.assertEqual(wrong, [BEGIN_US + 49 * 5000 - 400_000, BEGIN_US + 99 * 5000 + 20_000])

    def test_continuity_counts_flagged_and_unflagged_jumps_apart(self):
        path = os.path.join(self.folder, "vio.lcm")
        writer = lcm_log.Writer(path)
        # 1 m/s along x; 0.3 m to the side while coasting, 0.1 m without, a new segment somewhere else.
        for k, (y, coasting, segment) in enumerate([(0, 0, 1), (0, 1, 1), (0.3, 1, 1), (0.3, 0, 1), (0.4, 0, 1), (9, 0, 2)]):
            state = messages.message_type("state_t")()
            state.utime, state.segment, state.coasting = 5000 * k, segment, bool(coasting)
            state.t_O_B, state.v_O = [0.005 * k, y, 0.0], [1.0, 0.0, 0.0]
            state.q_O_B, state.gyro_bias, state.accel_bias, state.covariance = [1.0, 0, 0, 0], [0.0] * 3, [0.0] * 3, [0.0] * 81
            writer.write("STATE", state.encode(), 5000 * k)
        writer.close()
        found = faults._continuity(path)
        self.assertEqual((found["names"], found["segments"]), ([1, 2], 2))
        self.assertAlmostEqual(found["flagged_jump_m"], 0.3)
        self.assertAlmostEqual(found["jump_m"], 0.1)
        self.assertAlmostEqual(found["coasting_s"], 0.01)

    def test_poses_belong_to_the_segment_that_was_open(self):
        pose = ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        poses = [(0.05 * k, pose) for k in range(20)]
        first, second = faults._split(poses, [0, 500_000])
        self.assertEqual((len(first), len(second)), (10, 10))
        self.assertTrue(math.isclose(second[0][0], 0.5))


if __name__ == "__main__":
    unittest.main()
