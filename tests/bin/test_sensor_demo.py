# SPDX-License-Identifier: BSD-3-Clause
"""bin/demo on worlds with sensors: what is kept, when it is over, what is measured. With made-up processes and data."""

import contextlib
import fcntl
import io
import json
import math
import os
import types
import unittest
from unittest import mock

import numpy

from support import Folder

from covey_tools import contract, evaluation, lcm_log, messages, motion, pictures, ply, recordings, report, report_page, worlds
from covey_tools.errors import Failure, InputError
from covey_tools.sensor_team import SETTLE_S, SensorTeam
from covey_tools.team_run import Outcome

FAKE_SIM = """#!/usr/bin/python3
import os, sys
values = dict(zip(sys.argv[1::2], sys.argv[2::2]))
with open(os.path.join(os.path.dirname(sys.argv[0]), "runs.txt"), "a") as runs:
    runs.write(values.get("--robot", "truth") + " ")
if values.get("--robot", "truth") == os.environ.get("FAKE_SIM_FAILS"):
    sys.exit("sim: the graphics card is on fire")
if "--truth" in values:
    os.makedirs(values["--truth"])
    open(os.path.join(values["--truth"], "world.ply"), "w").close()
else:
    with open(values["--log"], "w") as log:
        log.write(" ".join(sys.argv[1:]))
"""


class RecordingsTest(Folder, unittest.TestCase):
    def setUp(self):
        super().setUp()
        self.bin = os.path.join(self.folder, "build", "bin")
        self.cache = os.path.join(self.folder, "cache")
        os.makedirs(self.bin)
        self.write_sim(FAKE_SIM)
        patch = mock.patch.dict(os.environ, {"COVEY_BUILD": os.path.join(self.folder, "build")})
        patch.start()
        self.addCleanup(patch.stop)
        self.world = worlds.load("town")

    def write_sim(self, text):
        path = os.path.join(self.bin, "sim")
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
        os.chmod(path, 0o755)

    def prepare(self, seed=1):
        with contextlib.redirect_stdout(io.StringIO()) as said:
            recording = recordings.prepare(self.world, seed, "", self.cache)
        self.said = said.getvalue()
        self.addCleanup(recording.lock.close)
        return recording

    def runs(self):
        return sorted(self.read("build/bin/runs.txt").split())

    def test_made_once_and_kept(self):
        first = self.prepare()
        self.assertEqual(self.runs(), ["0", "1", "2", "truth"])
        self.assertIn("making sensor data of 45 s", self.said)
        with open(first.log(1), encoding="ascii") as log:
            self.assertRegex(log.read(), "--world town --robots 3 --seconds 45 --seed 1 --config .* --robot 1 --log ")
        self.assertTrue(os.path.exists(first.truth("world.ply")))
        self.assertEqual(self.prepare().folder, first.folder)
        self.assertEqual((len(self.runs()), self.said), (4, ""))

    def test_what_is_missing_is_made_and_the_rest_is_kept(self):
        with mock.patch.dict(os.environ, {"FAKE_SIM_FAILS": "1"}), self.assertRaisesRegex(Failure, "on robot 1: .* on fire"):
            self.prepare()
        recording = self.prepare()
        self.assertEqual(self.runs().count("1"), 2)
        self.assertEqual(self.runs().count("truth"), 1)
        self.assertFalse([name for name in os.listdir(recording.folder) if name.endswith(".partial")])

    def test_another_simulator_makes_it_anew_and_the_old_data_goes_unless_it_is_in_use(self):
        used = self.prepare()
        self.write_sim(FAKE_SIM + "# another\n")
        with open(f"{used.folder}.lock", "ab") as lock:
            fcntl.flock(lock, fcntl.LOCK_SH)
            second = self.prepare()
            self.assertNotEqual(second.folder, used.folder)
            self.assertTrue(os.path.exists(used.log(0)))
        used.lock.close()
        second.lock.close()
        self.write_sim(FAKE_SIM + "# a third\n")
        third = self.prepare()
        self.assertFalse(os.path.exists(used.folder) or os.path.exists(second.folder))
        self.assertTrue(os.path.exists(third.log(0)))

    def test_other_seeds_stand_beside(self):
        self.assertTrue(os.path.exists(self.prepare(1).log(0)) and os.path.exists(self.prepare(2).log(0)))
        self.assertEqual(len(self.runs()), 8)

    def test_a_cache_that_cannot_be(self):
        self.cache = "/proc/nowhere"
        with self.assertRaisesRegex(InputError, "--cache /proc/nowhere: "):
            self.prepare()


def said(process, robot, phase="idle", start_utime=1, counters=None, gauges=None):
    counters, gauges = counters or {}, gauges or {}
    return types.SimpleNamespace(process=process, robot=robot, phase=phase, start_utime=start_utime,
                                 counter_names=list(counters), counter_values=list(counters.values()),
                                 gauge_names=list(gauges), gauge_values=list(gauges.values()))


def keyframe(robot, segment, number, utime=0, T_O_K=motion.IDENTITY, T_P_K=motion.IDENTITY):
    message = messages.message_type("keyframe_t")()
    message.utime, message.robot, message.segment, message.id = utime, robot, segment, number
    message.q_O_K, message.t_O_K = T_O_K
    message.q_P_K, message.t_P_K = T_P_K
    message.covariance = [1e-4 if row == column and number else 0.0 for row in range(6) for column in range(6)]
    return message


class SensorTeamTest(unittest.TestCase):
    def setUp(self):
        self.team = SensorTeam([worlds.Robot(robot, "") for robot in (0, 1)], 45.0, 1.0)
        self.now_s = 10.0
        for source in ("sensors-0", "depth-0", "sensors-1", "depth-1"):
            self.team.event(source, "started pid 4711", self.now_s)

    def say(self, process, robot, **status):
        self.team.take(said(process, robot, **status), self.now_s)

    def work(self, robot, keyframes=3):
        """Everything that a robot has to say when it is done."""
        for number in range(keyframes):
            self.team.hear(robot, "KEYFRAME", keyframe(robot, 7, number).encode(), self.now_s)
        self.say("vio", robot, phase="running", counters={
            "in/STEREO": 100, "lost/STEREO": 2, "dropped/STEREO/late": 1, "dropped/STEREO/queue_full": 4,
            "dropped/STEREO/old": 50})
        for process in ("radio_bridge", "mesher", "lcd"):
            self.say(process, robot)
        self.say("dpgo", robot, gauges={"solved_keyframes": keyframes, "loops": 0, "robots": 2, "round": 4})
        self.say("lmo", robot, gauges={"solved_round": 4})
        for source in (f"sensors-{robot}", f"depth-{robot}"):
            self.team.event(source, "exited with 0", self.now_s)

    def test_over_when_all_is_played_solved_and_still(self):
        self.now_s = 60.0
        self.work(0)
        self.work(1)
        self.assertEqual(self.team.missing(), [])
        self.assertFalse(self.team.is_done(self.now_s))
        self.assertTrue(self.team.is_done(self.now_s + SETTLE_S))
        self.assertEqual(self.team.settled_s(self.now_s + SETTLE_S), 50.0)  # the wait is no work
        self.assertEqual(self.team.data_s(self.now_s), 45.0)

    def test_what_is_missing_is_said(self):
        self.work(0)
        for sentence, undo in (
                ("robot 1: lmo has the mesh of round 3, and the last round is 4", {"lmo": {"gauges": {"round": 4, "solved_round": 3}}}),
                ("robot 1: lmo is solving", {"lmo": {"phase": "solving", "gauges": {"solved_round": 4}}}),
                ("robot 1: mesher has 7 blocks to say", {"mesher": {"gauges": {"waiting_blocks": 7}}}),
                ("robot 1: lcd is verifying", {"lcd": {"phase": "verifying"}}),
                ("robot 1: dpgo is round", {"dpgo": {"phase": "round", "gauges": {
                    "solved_keyframes": 3, "robots": 2, "round": 4}}}),
                ("robot 1: 2 of 3 keyframes solved", {"dpgo": {"gauges": {
                    "solved_keyframes": 2, "robots": 2, "round": 4}}})):
            self.work(1)
            for process, status in undo.items():
                self.say(process, 1, **status)
            self.assertEqual(self.team.missing(), [sentence])
        self.work(1)
        loop = messages.message_type("loop_t")()
        loop.robot_b = 1
        self.team.hear(1, "LOOP", loop.encode(), self.now_s)
        self.assertEqual(self.team.missing(), ["robot 1: 0 of 1 loops taken"])

    def test_nothing_is_over_while_data_is_played_or_somebody_is_silent(self):
        self.assertIn("sensors-1 has not played its log to the end", self.team.missing())
        self.assertIn("robot 0: mesher has not been heard", self.team.missing())
        self.assertEqual(self.team.data_s(self.now_s + 20.0), 20.0)

    def test_the_same_word_again_is_no_change_and_another_segment_is(self):
        self.work(0)
        self.work(1)
        self.now_s += SETTLE_S
        self.work(1)
        self.assertTrue(self.team.is_done(self.now_s))
        self.team.hear(1, "KEYFRAME", keyframe(1, 8, 0).encode(), self.now_s)
        self.assertFalse(self.team.is_done(self.now_s))
        self.assertEqual(self.team.keyframes(1), 4)
        self.assertEqual(self.team.missing(), ["robot 1: 3 of 4 keyframes solved"])

    def test_rows_show_every_robot(self):
        self.work(1)
        lines = self.team.rows()
        self.assertEqual(len(lines), 3)
        self.assertRegex(lines[2], r"^ +1 +106 +7 +3 +0 +3\+0 ")


def turned(yaw, x, y, z=0.0):
    return (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)), (x, y, z)


class SensorReportTest(Folder, unittest.TestCase):
    """Three robots drive circles that touch, 40 s, one keyframe a second; robot 1's vio is started again after 20 s."""

    SECONDS = 40

    def setUp(self):
        super().setUp()
        for name in ("traj", "snapshots", "logs", "mesh", "truth"):
            os.makedirs(os.path.join(self.folder, name))
        self.world = worlds.load("town")
        self.robots = [worlds.Robot(robot, "", truth=self.path("truth", f"robot{robot}.tum")) for robot in range(3)]
        self.truth = {robot: [(stamp, self.true_pose(robot, stamp)) for stamp in range(1, self.SECONDS + 1)]
                      for robot in range(3)}
        for robot, way in self.truth.items():
            motion.write_tum(self.path("truth", f"robot{robot}.tum"), way)
        with open(self.path("truth", "contacts.yaml"), "w", encoding="ascii") as file:
            file.write("radio_bridge:\n  contacts:\n    - {a: 0, b: 1, from_s: 0, until_s: 9}\n"
                       "    - {a: 1, b: 2, from_s: 3.5, until_s: 40}\n"
                       "    - {a: 0, b: 2, from_s: 45, until_s: 1000000}\n")
        self.T_truth_W = self.true_pose(0, 1)  # level, so robot 0's first keyframe is its odometry frame
        self.results = lcm_log.Writer(self.path("results.lcm"))
        for robot in range(3):
            lcm_log.Writer(self.path("logs", f"robot{robot}.lcm")).close()
            self.drive(robot)
        lcm_log.Writer(self.path("logs", "air.lcm")).close()
        self.say_loops()
        self.results.close()
        for robot in range(3):
            for kind in ("vio", "team"):
                ply.write(self.path("mesh", f"robot{robot}_{kind}.ply"), self.triangle())

    def path(self, *names):
        return os.path.join(self.folder, *names)

    @staticmethod
    def triangle():
        mesh = ply.Mesh(numpy.zeros(3, ply._VERTEX), numpy.array([[0, 1, 2]], "<i4"))
        mesh.vertices["x"], mesh.vertices["y"], mesh.vertices["label"] = [0, 1, 0], [0, 0, 1], [1, 2, 3]
        return mesh

    @staticmethod
    def true_pose(robot, stamp):
        angle = 2 * math.pi * stamp / 40 + robot
        return turned(angle + math.pi / 2, 8 * math.cos(angle) + 3 * robot, 8 * math.sin(angle), 0.1 * robot)

    def segment_of(self, robot, stamp):
        """(segment, id)"""
        return (21_000_000, stamp - 21) if robot == 1 and stamp >= 21 else (1_000_000, stamp - 1)

    def drive(self, robot):
        """Odometry whose steps are 2 % too long, and the truth as the team's solution."""
        way, T_O_K = self.truth[robot], motion.IDENTITY
        for (_, before), (stamp, now) in zip([way[0], *way], way):
            segment, number = self.segment_of(robot, stamp)
            q, t = motion.compose(motion.inverse(before), now)
            T_P_K = (q, tuple(1.02 * each for each in t)) if number else motion.IDENTITY
            T_O_K = motion.compose(T_O_K, T_P_K) if number else motion.IDENTITY
            message = keyframe(robot, segment, number, int(stamp * 1e6), T_O_K, T_P_K)
            self.results.write("KEYFRAME", message.encode(), 5)
            self.results.write("KEYFRAME", message.encode(), 6)  # heard twice
        T_W_truth = motion.inverse(self.T_truth_W)
        motion.write_tum(self.path("traj", f"robot{robot}_team.tum"), motion.moved(way, T_W_truth))
        trajectory = messages.message_type("trajectory_t")()
        trajectory.robot, trajectory.round = robot, 3
        self.results.write("TRAJECTORY", trajectory.encode(), 7)

    def say_loops(self):
        """True ones of each pair of robots and of robot 1 across its restart, kept; one false one, not kept."""
        loops = [(self.loop(a, stamp_a, b, stamp_b), 1.0) for a, stamp_a, b, stamp_b in
                 [(0, stamp, 1, stamp + 2) for stamp in (3, 9, 15, 24, 30, 36)]
                 + [(1, stamp, 2, stamp + 1) for stamp in (4, 12, 25, 33)] + [(1, 5, 1, 38), (1, 8, 1, 31)]]
        false = self.loop(0, 10, 2, 30)
        false.t_A_B = [5.0, 5.0, 5.0]
        loops.append((false, 0.0))
        for loop, _ in loops:
            for _ in {loop.robot_a, loop.robot_b}:  # on both robots' buses
                self.results.write("LOOP", loop.encode(), 8)
        for robot in range(3):
            mine = [each for each in loops if robot in (each[0].robot_a, each[0].robot_b)]
            message = messages.message_type("loop_weights_t")()
            message.utime, message.robot, message.parts, message.n = 9, robot, 1, len(mine)
            for loop, weight in mine:
                for name in ("robot", "segment", "id"):
                    for end in "ab":
                        getattr(message, f"{name}s_{end}").append(getattr(loop, f"{name}_{end}"))
                message.weights.append(weight)
                message.residuals_sq.append(0.1)
            self.results.write("LOOP_WEIGHTS", message.encode(), 9)

    def loop(self, robot_a, stamp_a, robot_b, stamp_b):
        message = messages.message_type("loop_t")()
        message.robot_a, (message.segment_a, message.id_a) = robot_a, self.segment_of(robot_a, stamp_a)
        message.robot_b, (message.segment_b, message.id_b) = robot_b, self.segment_of(robot_b, stamp_b)
        T_A_B = motion.compose(motion.inverse(self.true_pose(robot_a, stamp_a)), self.true_pose(robot_b, stamp_b))
        message.q_A_B, message.t_A_B = T_A_B
        message.covariance = [1e-4 if row == column else 0.0 for row in range(6) for column in range(6)]
        return message

    def make(self, draw=False):
        team = SensorTeam(self.robots, self.SECONDS, 1.0)
        team.event("sensors-0", "started pid 1", 0.0)
        for robot in self.robots:
            team.take(said("dpgo", robot.id, gauges={"robots": 3, "round": 3, "updates": 20}), 9.0)
            team.take(said("radio_bridge", robot.id, counters={"sent_bytes/dpgo": 1000}), 9.0)
            team.take(said("vio", robot.id, counters={"in/STEREO": 800, "lost/STEREO": 3},
                           gauges={"frame_ms_mean": 12.0, "frame_ms_p99": 30.0}), 9.0)
        recording = recordings.Recording(self.folder, 3, None)
        run = report.Run(self.folder, self.world, self.robots, Outcome(team, "done", [], 80.0, 40.0), "ideal.yaml", 1,
                         recording)
        scores = iter([{"error_m": 0.2, "completeness_m": 0.5, "labels": 0.9}] * 4
                      + [{"error_m": error, "completeness_m": 0.6, "labels": 0.95} for error in (0.1, 0.1, 0.3, 0.1)])
        with contextlib.ExitStack() as patches:
            patches.enter_context(mock.patch.object(evaluation, "evaluate_mesh", lambda *_: next(scores)))
            patches.enter_context(mock.patch.object(pictures, "SIZE", "480x320"))
            if not draw:
                patches.enter_context(mock.patch.object(pictures, "draw", return_value=[]))
            facts = report.make(run)
        report_page.write(self.folder, facts)
        with open(self.path("report.json"), encoding="utf-8") as file:
            return json.load(file)

    def test_a_whole_report(self):
        found = self.make()
        self.assertEqual(found["notes"], [])
        team = found["team"]
        self.assertLess(team["ate_m"], 1e-4)
        self.assertGreater(team["ate_vio_m"], 0.02)
        self.assertLess(team["ate_centralized_m"], team["ate_vio_m"])
        self.assertGreater(team["ate_centralized_m"], 0.0)
        self.assertIsNone(team["ate_online_m"])  # the made-up robots said nothing on their buses
        pairs = {(pair["a"], pair["b"]): pair for pair in team["loops"]}
        for ends, met, total, accepted in (((0, 0), True, 0, 0), ((0, 1), True, 6, 6), ((0, 2), False, 1, 0),
                                           ((1, 1), True, 2, 2), ((1, 2), True, 4, 4), ((2, 2), True, 0, 0)):
            pair = pairs[ends]
            self.assertEqual((pair["met"], pair["total"], pair["accepted"], pair["true"]), (met, total, accepted, accepted))
        self.assertEqual((team["precision"], team["recall"]), (1.0, 1.0))
        self.assertEqual([robot["keyframes"] for robot in found["robots"]], [40, 40, 40])
        self.assertEqual([robot["loops"] for robot in found["robots"]], [7, 12, 5])
        self.assertEqual((found["robots"][2]["frames"], found["robots"][2]["frames_dropped"]), (803, 3))
        self.assertEqual(found["communication_bytes"]["centralized_keypoints"], 120 * 48_300)
        self.assertEqual(found["realtime_factor"], 0.5)
        mesh = found["mesh"]
        self.assertEqual([each["robot"] for each in mesh], [0, 1, 2, "merged"])
        self.assertEqual((mesh[0]["error_before_m"], mesh[0]["error_after_m"]), (0.2, 0.1))
        self.assertEqual(mesh[3]["completeness_after_m"], 0.6)
        self.assertEqual(len(found["remarks"]), 2)
        self.assertIn("robot 1's odometry was started again", found["remarks"][1])
        self.assertIn("mesh error of robot 2 is 0.300 after optimisation and 0.200 before", found["remarks"][0])
        self.assertEqual(len(ply.read(self.path("mesh", "merged.ply")).vertices), 9)
        self.assertIn("labels right before", self.read("report.html"))

    def test_the_restarted_odometry_is_placed_by_truth_segment_by_segment(self):
        self.make()
        way = dict(motion.read_tum(self.path("traj", "robot1_vio.tum")))
        for stamp in (1.0, 21.0):
            true = motion.compose(motion.inverse(self.T_truth_W), self.true_pose(1, stamp))
            self.assertLess(math.dist(way[stamp][1], true[1]), 1e-6)
        self.assertGreater(math.dist(way[20.0][1], motion.compose(motion.inverse(self.T_truth_W),
                                                                  self.true_pose(1, 20.0))[1]), 0.05)

    def record(self):
        """A log of one image set, its bands in disorder."""
        stereo, depth = messages.message_type("stereo_t")(), messages.message_type("depth_t")()
        stereo.width = depth.width = 4
        stereo.height = depth.height = 3
        stereo.n_left = stereo.n_right = depth.n_depth = depth.n_labels = 12
        stereo.left = stereo.right = depth.labels = bytes(range(12))
        depth.colours = b""
        depth.depth_mm = [0, 1000, -5536, *[2000] * 9]  # 60 m does not fit an int16
        log = lcm_log.Writer(self.path("robot0.lcm"))
        log.write("IMU", b"", 0)
        for channel, message in (("STEREO", stereo), ("DEPTH", depth)):
            data = message.encode()
            for index in (1, 0):
                band = messages.message_type("band_t")()
                band.band, band.bands, band.data = index, 2, data[50 * index:50 if index == 0 else None]
                band.n = len(band.data)
                log.write(channel, band.encode(), 30_000_000)
        log.close()

    def test_the_pictures(self):
        ply.write(self.path("truth", "world.ply"), self.triangle())
        with open(self.path("truth", "labels.json"), "w", encoding="ascii") as file:
            json.dump({"1": "road", "3": "house"}, file)
        self.record()
        found = self.make(draw=True)
        self.assertEqual(found["notes"], [])
        self.assertGreaterEqual(self.read("report.html").count("data:image/png;base64,"), 11)

    def test_what_the_contract_asks_for_is_missed(self):
        found = self.make()
        del found["team"]["ate_m"], found["robots"][1]["vio_ms_p99"], found["mesh"][3]
        self.assertEqual(contract.lacks(found, True), ["the report has no team.ate_m, robots[1].vio_ms_p99",
                                                       "the report's meshes are not of every robot, and merged"])
        self.assertTrue(any("team.cost_centralized" in each for each in contract.lacks({
            **found, "team": {"loops": []}}, False)))

    def test_no_mesh_is_a_note_and_no_more(self):
        os.remove(self.path("mesh", "robot1_team.ply"))
        found = self.make()
        self.assertEqual(found["notes"], ["robot 1 has no mesh"])
        self.assertIsNone(found["mesh"][1]["error_after_m"])
        self.assertLess(found["team"]["ate_m"], 1e-4)


class PlyTest(Folder, unittest.TestCase):
    def test_moved_and_merged(self):
        mesh = SensorReportTest.triangle()
        file = os.path.join(self.folder, "mesh.ply")
        ply.write(file, ply.merged([mesh, mesh.moved(turned(math.pi / 2, 5.0, 0.0, 1.0))]))
        found = ply.read(file)
        self.assertEqual(found.corners.tolist(), [[0, 1, 2], [3, 4, 5]])
        self.assertEqual(found.vertices["label"].tolist(), [1, 2, 3, 1, 2, 3])
        self.assertTrue(numpy.allclose([found.vertices[name][4] for name in "xyz"], [5.0, 1.0, 1.0]))

    def test_refusals(self):
        file = os.path.join(self.folder, "mesh.ply")
        for text in (b"", b"ply\nformat ascii 1.0\n", b"ply\nformat binary_little_endian 1.0\nelement vertex 5\n"
                     b"property float x\nelement face 0\nend_header\n"):
            with open(file, "wb") as out:
                out.write(text)
            with self.assertRaisesRegex(Failure, "mesh.ply"):
                ply.read(file)


if __name__ == "__main__":
    unittest.main()
