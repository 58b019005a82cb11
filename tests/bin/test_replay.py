# SPDX-License-Identifier: BSD-3-Clause
"""bin/replay on a log of trajectories, with the probe of tests/procs/common."""

import importlib
import json
import os
import struct
import subprocess
import unittest

import support
from covey_tools import status
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

    def test_refusals(self):
        for arguments, word in ((["--process", "nosuch"], "nosuch"), (["--compare", "/nowhere.json"], "/nowhere.json"),
                                (["--process", "probe --wat"], "--wat"), (["--robot", "9"], "--process")):
            code, _, err = self.replay(*arguments)
            self.assertEqual(code, 2, err)
            self.assertIn(word, err)
            self.assertEqual(err.count("\n"), 1)


if __name__ == "__main__":
    unittest.main()
