# SPDX-License-Identifier: BSD-3-Clause
"""bin/demo as a whole: real processes over multicast in a private network, on a small grid and on 10 s of sensors.

usage: test_demo.py GraphDemo.TEST | SensorDemo.TEST     one test, as ctest runs them
"""

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "bin"))

from covey_tools import contract, lcm_log, places  # noqa: E402

SMALL = ["--world", "grid", "--seconds", "40", "--speed", "10", "--patience", "60"]
# Its data takes 10 s, so that a process is killed by how far the data has come, well before the end.
SLOW = [*SMALL, "--speed", "4"]
KINDS = ("dpgo-1", "radio_bridge-2", "player-0", "logger-1")  # dpgo-0 would be the anchor: it has a test of its own
# Every process of two robots, whose sensor data is made once for all tests of this build.
SENSORS = ["--world", "town", "--robots", "2", "--seconds", "10", "--speed", "0.5", "--patience", "90"]
SENSOR_KINDS = ("vio-1", "mesher-1", "lcd-1", "lmo-1", "dpgo-1", "radio_bridge-1")


class DemoRun(unittest.TestCase):
    LAST_ROBOT = 2  # whose logger no test kills

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="covey-demo-")
        self.addCleanup(folder.cleanup)
        self.out = os.path.join(folder.name, "a demo")  # spaces must not matter

    def start(self, *arguments):
        demo = os.path.join(ROOT, "bin", "demo")
        command = [demo, "--no-build", "--namespace", "private", "--out", self.out, *arguments]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

        def end():
            if process.poll() is None:
                process.terminate()
                process.communicate(timeout=60)
            process.stdout.close()
        self.addCleanup(end)
        return process

    def finish(self, process, expected_code):
        output, _ = process.communicate(timeout=400)
        self.assertEqual(process.returncode, expected_code, output)
        return output

    def report(self):
        with open(os.path.join(self.out, "report.json"), encoding="utf-8") as file:
            return json.load(file)

    def events(self):
        try:
            with open(os.path.join(self.out, "logs", "processes", "events.txt"), encoding="utf-8") as file:
                return file.read()
        except FileNotFoundError:
            return ""

    def wait_for_event(self, pattern, process, count=1, timeout_s=30):
        def found():
            events = re.findall(pattern, self.events())
            return events if len(events) >= count else None
        return self.wait_for(found, f"event '{pattern}', {count} of them", process, timeout_s)

    def wait_for_keyframes(self, count, process, timeout_s=30):
        """Until the last robot's logger has written down so many keyframes."""
        log = os.path.join(self.out, "logs", f"robot{self.LAST_ROBOT}.lcm")

        def found():
            return os.path.exists(log) and sum(event.channel == "KEYFRAME" for event in lcm_log.Log(log)) >= count
        self.wait_for(found, f"{count} keyframes", process, timeout_s)

    def wait_for(self, found, what, process, timeout_s):
        """What found() returns once it is true; fails with the events when the demo ends before that."""
        deadline = time.monotonic() + timeout_s
        while not (result := found()):
            if process.poll() is not None:
                self.fail(f"the demo ended before: {what}\n{self.events()}\n{process.communicate()[0]}")
            if time.monotonic() > deadline:
                self.fail(f"not in {timeout_s} s: {what}\n{self.events()}")
            time.sleep(0.1)
        return result

    def kill(self, names, process):
        """kill -9 all of them, and wait for the sheet to start them again."""
        starts = {name: self.wait_for_event(rf"{name} +started pid (\d+)", process) for name in names}
        for name, pids in starts.items():
            try:
                os.kill(int(pids[-1]), signal.SIGKILL)
            except ProcessLookupError:
                self.fail(f"{name} had gone before it was killed\n{self.events()}")
        for name, pids in starts.items():
            self.wait_for_event(rf"{name} +started pid (\d+)", process, len(pids) + 1)


class GraphDemo(DemoRun):
    def check_good(self, report):
        team = report["team"]
        self.assertTrue(report["complete"])
        self.assertEqual((report["missing"], report["notes"]), ([], []))
        self.assertLess(team["cost"], 1.05 * team["cost_centralized"])
        self.assertLess(team["ate_m"], 1.1 * team["ate_centralized_m"])
        self.assertLess(team["ate_m"], team["ate_vio_m"])
        self.assertGreater(team["precision"], 0.95)
        self.assertGreater(team["recall"], 0.9)
        trajectories = [f"traj/robot{robot}_{kind}.tum" for robot in range(3) for kind in ("vio", "team")]
        logs = [f"logs/{log}.lcm" for log in ("robot0", "robot1", "robot2", "air")]
        pictures = [f"snapshots/{name}.png"
                    for name in ("before_top", "before_oblique", "after_top", "after_oblique", "plan")]
        for name in (*trajectories, *logs, *pictures, "report.html"):
            self.assertGreater(os.path.getsize(os.path.join(self.out, name)), 500, name)

    def test_a_run(self):
        process = self.start(*SMALL)
        output = self.finish(process, 0)
        self.assertIn("team ATE", output)
        report = self.report()
        self.check_good(report)
        self.assertEqual(report["restarts"], {})
        self.assertEqual([robot["keyframes"] for robot in report["robots"]], [40, 40, 40])
        self.assertEqual(len(report["team"]["loops"]), 6)
        self.assertTrue(all(pair["met"] for pair in report["team"]["loops"]))
        sent = report["communication_bytes"]
        modules = ("place_recognition", "geometric_verification", "dpgo", "control")
        self.assertEqual(sent["total"], sum(sent[name] for name in modules))
        self.assertGreater(sent["dpgo"], 10_000)
        self.assertAlmostEqual(sent["total"], sent["on_air"], delta=20_000)
        self.assertGreater(report["realtime_factor"], 1.0)

    def test_every_kind_of_process_may_be_killed(self):
        process = self.start(*SLOW)
        for index, name in enumerate(KINDS):
            self.wait_for_keyframes(6 + 6 * index, process)
            self.kill([name], process)
        self.finish(process, 0)
        report = self.report()
        self.check_good(report)
        self.assertEqual({name for name in KINDS if not name.startswith("logger")} - set(report["restarts"]), set())

    def test_the_anchor_may_be_killed_with_its_bridge(self):
        process = self.start(*SMALL, "--radio", os.path.join(ROOT, "configs", "radio", "lossy.yaml"))
        self.wait_for_keyframes(20, process)  # 2 s of data are left, and then rounds that take longer
        self.kill(["dpgo-0", "radio_bridge-0"], process)
        self.finish(process, 0)
        report = self.report()
        self.check_good(report)
        self.assertLessEqual({"dpgo-0", "radio_bridge-0"}, set(report["restarts"]))

    def test_an_interrupt_stops_everything_and_leaves_a_report(self):
        process = self.start(*SMALL)
        pids = [int(self.wait_for_event(rf"{name} +started pid (\d+)", process)[0])
                for name in ("player-2", "dpgo-0", "logger-air")]
        self.wait_for_keyframes(5, process)
        process.send_signal(signal.SIGINT)
        self.finish(process, 130)
        report = self.report()
        self.assertFalse(report["complete"])
        self.assertTrue(report["missing"])
        for pid in pids:
            self.assertFalse(os.path.exists(f"/proc/{pid}"), f"process {pid} lives on")

    def test_refusals(self):
        for arguments, sentence in ((["--world", "moon"], "expected one of euroc-v1, grid, rooms, town, tunnels"),
                                    (["--world", "tunnels", "--data", "/nowhere"], "take --world grid, which needs no"),
                                    (["--world", "euroc-v1", "--data", "/nowhere"], "/nowhere/euroc/motion: no such folder"),
                                    (["--radio", "/nowhere.yaml"], "no such file"),
                                    (["--robots", "0"], "not between 1 and 20"),
                                    (["--world", "grid", "--robots", "6", "--seconds", "4"], "too few for 6 robots to meet")):
            self.assertIn(sentence, self.finish(self.start(*arguments), 2))


class SensorDemo(DemoRun):
    LAST_ROBOT = 1

    def start(self, *arguments):
        cache = os.path.join(os.path.dirname(places.build_folder()), "test_cache")
        return super().start(*SENSORS, "--cache", cache, *arguments)

    def check_good(self, report):
        self.assertTrue(report["complete"])
        self.assertEqual((report["missing"], report["notes"]), ([], []))
        self.assertEqual(contract.lacks(report, True), [])
        for robot in (0, 1):
            for name in (f"traj/robot{robot}_vio.tum", f"traj/robot{robot}_team.tum", f"mesh/robot{robot}_vio.ply",
                         f"logs/robot{robot}.lcm"):
                self.assertGreater(os.path.getsize(os.path.join(self.out, name)), 500, name)

    def test_sensors_in_a_mesh_out(self):
        self.finish(self.start(), 0)
        report = self.report()
        self.check_good(report)
        self.assertEqual(report["restarts"], {})
        for robot in report["robots"]:
            self.assertGreater(robot["frames"], 190)
            self.assertLess(robot["frames_dropped"], 100)  # on a busy machine
            self.assertGreater(robot["keyframes"], 5)
            self.assertLess(robot["ate_team_m"], 0.3)
        merged = report["mesh"][-1]
        self.assertLess(merged["error_after_m"], 0.3)
        self.assertGreater(merged["labels_after"], 0.7)

    def test_each_of_the_six_processes_may_be_killed(self):
        process = self.start("--speed", "0.3")
        for index, name in enumerate(SENSOR_KINDS):
            self.wait_for_keyframes(2 + index, process, 200)
            self.kill([name], process)
        self.finish(process, 0)
        report = self.report()
        self.check_good(report)
        self.assertEqual(set(SENSOR_KINDS) - set(report["restarts"]), set())


if __name__ == "__main__":
    sys.dont_write_bytecode = True
    unittest.main()
