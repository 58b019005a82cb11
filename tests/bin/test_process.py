# SPDX-License-Identifier: BSD-3-Clause
"""The parts of a supervised process that need no process."""

import os
import unittest

from support import Folder
from covey_tools.process import Backoff, last_log_line
from covey_tools.view import duration


class BackingOff(unittest.TestCase):
    def test_doubles_for_early_exits_up_to_a_second(self):
        backoff, delays = Backoff(), []
        for start in range(10):
            backoff.on_start(start * 0.5)
            delays.append(backoff.delay_ms)
        self.assertEqual(delays, [10, 20, 40, 80, 160, 320, 640, 1000, 1000, 1000])

    def test_halves_for_each_second_of_a_run(self):
        backoff = Backoff()
        for start in range(8):
            backoff.on_start(start * 0.5)
        for start_s, delay_ms in [(5.0, 500), (8.0, 62), (1000.0, 10), (1e9, 10)]:
            backoff.on_start(start_s)
            self.assertEqual(backoff.delay_ms, delay_ms)


class LastWords(Folder, unittest.TestCase):
    def check(self, content, line):
        path = os.path.join(self.folder, "x.log")
        with open(path, "wb") as file:
            file.write(content)
        self.assertEqual(last_log_line(path), line)

    def test_the_last_line_that_says_something(self):
        self.check(b"", "")
        self.check(b"--- dpgo --robot 0\n", "")
        self.check(b"--- dpgo\none\ntwo\n\n  \n", "two")
        self.check(b"one\ntwo, unfinished", "two, unfinished")
        self.check(b"\x1b[31mred\xff\x1b[0m\r\n", "red\N{REPLACEMENT CHARACTER}")
        self.check(b"x" * 100000, "x" * 200)
        self.assertEqual(last_log_line(os.path.join(self.folder, "absent")), "")


class Durations(unittest.TestCase):
    def test_for_people(self):
        self.assertEqual([duration(seconds) for seconds in (0.9, 59.9, 60, 185, 3723)],
                         ["0 s", "59 s", "1:00", "3:05", "1:02:03"])


if __name__ == "__main__":
    unittest.main()
