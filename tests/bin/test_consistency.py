# SPDX-License-Identifier: BSD-3-Clause
"""bin/experiments consistency: its report, from made-up rows, and its runs, from what programs in the others' places say."""

import json
import os
import types
import unittest
from unittest import mock

from support import Folder

from covey_tools import lcm_log, recordings
from covey_tools.errors import Failure
from covey_tools.experiments import consistency

TOLD = {"ate_m": 0.02, "position_nees": 1.0, "yaw_nees": 1.0, "nees": 1.0, **dict.fromkeys(consistency._EDGES, 1.0)}


class Consistency(Folder, unittest.TestCase):
    def recording(self, world, seed, data, cache, say):
        self.assertEqual(world.robots, 3)
        for robot in range(world.robots):
            log = lcm_log.Writer(self.path(f"robot{robot}.lcm"))
            for channel, data, utime in (("IMU", b"a", 1), ("STEREO", b"p", 1), ("DEPTH", b"d", 2), ("IMU", b"b", 2)):
                log.write(channel, data, utime)
            log.close()
        return recordings.Recording(self.folder, world.robots, mock.MagicMock())

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def program(self, name, arguments):
        value = lambda option: arguments[arguments.index(option) + 1]
        if name == "sim":
            self.assertIn("--imu-only", arguments)
            self.seeds.append((value("--robot"), value("--imu-seed")))
            log = lcm_log.Writer(value("--log"))
            for data, utime in ((b"A", 1), (b"B", 2)):
                log.write("IMU", data, utime)
            log.close()
        elif name == "vio":
            heard = [(event.channel, event.data, event.utime) for event in lcm_log.Log(value("--url")[len("file://"):])]
            self.assertEqual(heard, [("IMU", b"A", 1), ("STEREO", b"p", 1), ("IMU", b"B", 2)])
            if len(self.seeds) == 2:
                raise Failure("no start")
        return json.dumps(TOLD)

    def test_rows(self):
        self.seeds = []
        options = types.SimpleNamespace(quick=True, data=self.folder, seed=4, seconds=None, cache=self.folder, out=self.path("out"))
        with mock.patch.object(recordings, "prepare", self.recording), mock.patch("covey_tools.programs.run", self.program):
            rows, notes = consistency.run(options, lambda line: None)
        self.assertEqual(self.seeds, [("0", "4"), ("1", "5"), ("2", "6"), ("0", "7"), ("1", "8")])
        self.assertEqual(([row["imu_seed"] for row in rows], notes), ([4, 6, 7, 8], ["IMU of seed 5: no start"]))
        self.assertEqual((rows[0]["seconds"], rows[0]["edge_nees_60s"]), (consistency.QUICK_SECONDS, 1.0))
        self.assertFalse(os.path.exists(self.path("out", "consistency", "sensors.lcm")))

    def test_band(self):
        low, high = consistency.band(60)  # of a table of chi-square: 40.48 and 83.30
        self.assertAlmostEqual(60 * low, 40.48, delta=0.05)
        self.assertAlmostEqual(60 * high, 83.30, delta=0.05)

    def test_claims_are_computed_from_the_rows(self):
        def verdicts(**values):
            rows = [{"imu_seed": seed, "robot": 0, **TOLD, **values} for seed in range(20)]
            return consistency.report(rows, ["something"], self.folder).split("## Runs")[0].splitlines()

        def failed(**values):
            return [line for line in verdicts(**values) if "DOES NOT HOLD" in line]

        self.assertEqual(sum("**holds**" in line for line in verdicts()), 5)
        self.assertEqual(failed(position_nees=1.35, yaw_nees=1.6), [])
        for wrong in ({"position_nees": 1.45}, {"position_nees": 0.6}, {"yaw_nees": 1.8}, {"edge_nees_1s": 2.1}, {"edge_nees_60s": 0.4}):
            self.assertEqual(len(failed(**wrong)), 1, wrong)
        self.assertTrue(any("**not measured**" in line for line in verdicts(edge_nees_60s=None)))


if __name__ == "__main__":
    unittest.main()
