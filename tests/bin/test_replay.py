# SPDX-License-Identifier: BSD-3-Clause
"""bin/replay on a log of trajectories, with the probe of tests/procs/common."""

import importlib
import json
import os
import struct
import subprocess
import unittest

import support
from covey_tools import lcm_log, replay, status
from covey_tools.errors import InputError
from support import BIN, Folder


def generated(name):
    status.status_type()  # puts build/<preset>/python into the path
    return getattr(importlib.import_module(f"covey.{name}"), name)


def event(number, utime, channel, data):
    return struct.pack(">Iqqii", 0xEDA1DA01, number, utime, len(channel), len(data)) + channel.encode() + data


class Replay(Folder, unittest.TestCase):
    def setUp(self):
        super().setUp()
        self.log = os.path.join(self.folder, "in.lcm")
        self.write_log(100)

    def write_log(self, rounds):
        said = generated("status_t")()
        said.process, said.robot = "probe", 4
        events = [event(0, 1_000_000, "STATUS", said.encode())]
        for number in range(1, rounds + 1):
            trajectory = generated("trajectory_t")()
            trajectory.round = number
            events.append(event(number, 1_000_000 + 10_000 * number, "TRAJECTORY", trajectory.encode()))
        with open(self.log, "wb") as file:
            file.write(b"".join(events))

    def replay(self, *arguments):
        done = subprocess.run([os.path.join(BIN, "replay"), self.log, *arguments], capture_output=True, text=True,
                              check=False)
        return done.returncode, done.stdout, done.stderr

    def test_the_processes_in_the_log_run_twice_alike(self):
        code, out, err = self.replay()
        self.assertEqual((code, err), (0, ""))
        self.assertIn("probe[4]: ", out)
        self.assertIn("identical in two runs", out)
        self.assertRegex(out, r"LOOP_WEIGHTS +100 +[0-9a-f]{64}\n")
        self.assertRegex(out, r"LOOP +20 +")  # 10 Hz over 1 s of log and 1 s after it
        self.assertNotIn("STATUS", out)

    def test_a_digest_that_was_stored_is_met_or_the_first_difference_named(self):
        digests = os.path.join(self.folder, "digests.json")
        self.assertEqual(self.replay("--store", digests)[0], 0)
        with open(digests, encoding="utf-8") as file:
            self.assertEqual(json.load(file)["probe[4]"]["LOOP_WEIGHTS"]["events"], 100)
        code, out, _ = self.replay("--compare", digests)
        self.assertEqual(code, 0)
        self.assertIn("as stored", out)
        self.write_log(90)
        code, out, _ = self.replay("--compare", digests)
        self.assertEqual(code, 1)
        self.assertIn("LOOP_WEIGHTS: differs from event 90 on (100 events before, 90 now)", out)

    def test_an_output_that_depends_on_the_wall_clock_is_caught(self):
        code, out, _ = self.replay("--process", "probe --wall-clock")
        self.assertEqual(code, 1)
        self.assertIn("DIFFERENT", out)
        self.assertIn("second run: LOOP_WEIGHTS: differs from event 0 on", out)

    def test_faults_are_seeded_too(self):
        code, out, _ = self.replay("--process", "probe --bus-faults drop=0.3,duplicate=0.2,delay_ms=40,seed=5")
        self.assertEqual(code, 0, out)
        self.assertNotRegex(out, r"LOOP_WEIGHTS +100 ")

    def test_what_needs_sensors_is_left_out_with_a_word(self):
        said = generated("status_t")()
        said.process, said.robot = "vio", 4
        with open(self.log, "ab") as file:
            file.write(event(999, 3_000_000, "STATUS", said.encode()))
        code, out, err = self.replay()
        self.assertEqual((code, err), (0, "replay: left out, since there is no --sensors: vio[4]\n"))
        self.assertNotIn("vio", out)

    def test_a_log_of_the_bus_is_put_on_the_time_of_the_sensors(self):
        """Played at twice its speed; one STATE came at once, the others 10 ms late."""
        log, out = lcm_log.Writer(self.log), os.path.join(self.folder, "out.lcm")
        for utime in range(5_000_000, 6_000_001, 100_000):
            state = generated("state_t")()
            state.utime = utime
            late_us = 0 if utime == 5_500_000 else 5_000
            log.write("STATE", state.encode(), 1_700_000_000_000_000 + (utime - 5_000_000) // 2 + late_us)
            log.write("MARK", b"", 1_700_000_000_000_000 + (utime - 5_000_000) // 2)
        log.close()
        replay.on_sensor_time(self.log, out)
        times = [each.utime for each in lcm_log.Log(out) if each.channel == "MARK"]
        self.assertEqual(times, list(range(5_000_000, 6_000_001, 100_000)))
        self.write_log(3)
        with self.assertRaisesRegex(InputError, "has no STATE of vio"):
            replay.on_sensor_time(self.log, out)

    def test_refusals(self):
        for arguments, word in ((["--process", "nosuch"], "nosuch"), (["--compare", "/nowhere.json"], "/nowhere.json"),
                                (["--process", "probe --wat"], "--wat"), (["--robot", "9"], "--process")):
            code, _, err = self.replay(*arguments)
            self.assertEqual(code, 2, err)
            self.assertIn(word, err)
            self.assertEqual(err.count("\n"), 1)


if __name__ == "__main__":
    unittest.main()
