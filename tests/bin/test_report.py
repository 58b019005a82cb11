# SPDX-License-Identifier: BSD-3-Clause
"""bin/demo's bookkeeping and report, from canned words and files."""

import html
import json
import os
import types
import unittest
from unittest import mock

from support import Folder

from covey_tools import (demo_command, evaluation, lcm_log, messages, motion, pictures, report, report_page, report_words,
                         team_sheet, worlds)
from covey_tools.errors import InputError
from covey_tools.grammar import read_sheet
from covey_tools.run import make_plan
from covey_tools.team import Team
from covey_tools.team_run import Outcome


def said(process, robot, phase="idle", start_utime=1, counters=None, gauges=None):
    """As much of a status_t as Team reads."""
    counters, gauges = counters or {}, gauges or {}
    return types.SimpleNamespace(process=process, robot=robot, phase=phase, start_utime=start_utime,
                                 counter_names=list(counters), counter_values=list(counters.values()),
                                 gauge_names=list(gauges), gauge_values=list(gauges.values()))


def done_gauges(**changed):
    return {"solved_keyframes": 10, "solved_loops": 4, "round": 7, "robots": 2, "cost": 50.0, **changed}


class TeamTest(unittest.TestCase):
    def setUp(self):
        self.team = Team([worlds.Robot(robot, "", keyframes=10, loops=4) for robot in (0, 1)])

    def test_done_when_all_have_solved_all_in_one_round(self):
        self.assertEqual(len(self.team.missing()), 2)
        self.team.take(said("dpgo", 0, gauges=done_gauges()), 1.0)
        self.team.take(said("dpgo", 1, gauges=done_gauges()), 1.0)
        self.assertEqual(self.team.missing(), [])

    def test_what_is_missing_is_said(self):
        self.team.take(said("dpgo", 0, gauges=done_gauges()), 1.0)
        for changed, sentence in (({"solved_loops": 3}, "robot 1: 3 of 4 loops solved"),
                                  ({"robots": 1}, "robot 1: 1 of 2 robots in its last round"),
                                  ({"round": 8}, "the robots' last rounds differ: 7, 8")):
            self.team.take(said("dpgo", 1, gauges=done_gauges(**changed)), 1.0)
            self.assertEqual(self.team.missing(), [sentence])
        self.team.take(said("dpgo", 1, phase="round", gauges=done_gauges()), 1.0)
        self.assertEqual(self.team.missing(), ["robot 1: dpgo is round"])

    def test_bytes_are_summed_over_restarts(self):
        for start, sent in ((1, 100), (1, 250), (5, 30), (5, 40)):
            self.team.take(said("radio_bridge", 0, start_utime=start, counters={"sent_bytes/dpgo": sent}), 1.0)
        late_word_of_the_first_run = said("radio_bridge", 0, start_utime=1, counters={"sent_bytes/dpgo": 999})
        self.team.take(late_word_of_the_first_run, 1.0)
        self.team.take(said("radio_bridge", 1, counters={"sent_bytes/dpgo": 1, "sent_bytes/control": 2}), 1.0)
        self.assertEqual(self.team.radio_bytes(), {"dpgo": 291, "control": 2})
        self.assertEqual(self.team.restarts(), {"radio_bridge-0": 1})

    def test_the_common_frame_is_timed_from_the_first_data(self):
        self.team.take(said("player", 0, phase="playing"), 10.0)
        self.team.take(said("dpgo", 0, gauges=done_gauges(robots=1, round=1)), 12.0)
        self.team.take(said("dpgo", 0, gauges=done_gauges(robots=2, round=2)), 15.0)
        self.team.take(said("dpgo", 0, gauges=done_gauges(robots=2, round=3)), 19.0)
        self.assertEqual(self.team.common_frame_s, 5.0)
        self.team.take(said("dpgo", 1, gauges=done_gauges(robots=2, round=3, cost=4.0)), 20.0)
        self.assertEqual([each[2] for each in self.team.rounds], [1, 2, 3, 3])
        self.assertEqual(self.team.costs(), [(10.0, 54.0)])


class MotionTest(unittest.TestCase):
    def test_inverse_and_chain(self):
        quarter = (0.0, 0.0, 2 ** -0.5, 2 ** -0.5, 1.0, 0.0, 0.0)  # forward 1 m, then left: four of them close a square
        square = motion.chain([quarter] * 4)
        self.assertEqual([stamp for stamp, _ in square], [1.0, 2.0, 3.0, 4.0, 5.0])
        for at, expected in ((1, (1, 0, 0)), (2, (1, 1, 0)), (3, (0, 1, 0)), (4, (0, 0, 0))):
            for k in range(3):
                self.assertAlmostEqual(square[at][1][1][k], expected[k])
        self.assertAlmostEqual(motion.length(square), 4.0)
        q, t = motion.compose(square[2][1], motion.inverse(square[2][1]))
        self.assertAlmostEqual(abs(q[0]), 1.0)
        self.assertAlmostEqual(max(map(abs, t)), 0.0)


class SheetTest(Folder, unittest.TestCase):
    def test_the_sheet_of_a_run_is_one_that_sheet_takes(self):
        path = os.path.join(self.folder, "demo.procman")
        values = {"OUT": "/tmp/a b", "CONFIG": "w.yaml", "RADIO": "r.yaml", "GRAPH": "/tmp/g", "SPEED": "8",
                  "LOGS": "/tmp/l"}
        for kind, sources in ((team_sheet.GRAPH, ()), (team_sheet.SENSORS, team_sheet.SENSORS.sources)):
            team_sheet.write(path, kind, 3, values)
            sheet = read_sheet(path)
            self.assertEqual(len(sheet.commands), 3 * len(kind.readers + kind.sources) + 1)
            for command in sheet.commands:
                self.assertEqual(command.auto_respawn, command.id.split("-")[0] not in sources, command.id)
            self.assertNotIn("@", "".join(command.exec for command in sheet.commands))
            started = [str(action) for action in make_plan(sheet, "go").actions]
            for process in kind.wait_for:
                self.assertLess(started.index(f'wait cmd "{process}-2" status "running"'),
                                started.index(f'start cmd "{kind.sources[0]}-0"'))
        with self.assertRaisesRegex(InputError, "cannot stand in a sheet"):
            team_sheet.write(path, team_sheet.GRAPH, 1, {**values, "OUT": "/tmp/it's"})


class WorldsTest(unittest.TestCase):
    def test_every_world_loads(self):
        for name in worlds.names():
            world = worlds.load(name)
            self.assertGreater(world.robots, 1)
            self.assertGreater(world.barc2, 1.0)

    def test_refusals(self):
        with self.assertRaisesRegex(InputError, "no such world; expected one of euroc-v1, grid, rooms, town, tunnels"):
            worlds.load("moon")
        with self.assertRaisesRegex(InputError, "take --world grid"):
            worlds.check(worlds.load("tunnels"), "/nowhere")
        with self.assertRaisesRegex(InputError, "/nowhere/euroc/motion: no such folder; .* take --world town"):
            worlds.check(worlds.load("euroc-v1"), "/nowhere")
        worlds.check(worlds.load("town"), "/nowhere")

    def test_the_threshold_is_a_quantile_where_the_robots_have_a_probability(self):
        self.assertAlmostEqual(worlds.load("town").barc2, 16.8119, places=4)  # chi-square, 6 degrees of freedom, 0.99


class ReportTest(Folder, unittest.TestCase):
    def setUp(self):
        super().setUp()
        for name in ("traj", "snapshots", "logs"):
            os.makedirs(os.path.join(self.folder, name))
        self.world = worlds.load("grid")
        self.world.seconds = 40.0
        self.robots = worlds.prepare_graph(self.world, 3, "", os.path.join(self.folder, "graph"))

    def solve(self):
        """The central solution in the place of the team's, with weights that keep every second closure."""
        keyframes = [robot.keyframes for robot in self.robots]
        central = evaluation.solve_centrally(os.path.join(self.folder, "graph"), self.world.barc2, keyframes,
                                             os.path.join(self.folder, "solved"))
        results = lcm_log.Writer(os.path.join(self.folder, "results.lcm"))
        for robot, file in zip(self.robots, central.files):
            os.rename(file, os.path.join(self.folder, "traj", f"robot{robot.id}_team.tum"))
            results.write("LOOP_WEIGHTS", self.weights(robot).encode(), 5)
            trajectory = messages.message_type("trajectory_t")()
            trajectory.robot, trajectory.round, trajectory.anchor = robot.id, 3, 0
            results.write("TRAJECTORY", trajectory.encode(), 5)
        results.close()
        lcm_log.Writer(os.path.join(self.folder, "logs", "air.lcm")).close()
        for robot in self.robots:
            self.drive(robot)
        return central

    def drive(self, robot):
        """The robot's bus: one round, in a W that stands still, after 15 keyframes, and another at the end."""
        log = lcm_log.Writer(os.path.join(self.folder, "logs", f"robot{robot.id}.lcm"))
        solution = motion.read_tum(os.path.join(self.folder, "traj", f"robot{robot.id}_team.tum"))
        for index, (stamp, (q, t)) in enumerate(motion.chain(robot.steps)):
            keyframe = messages.message_type("keyframe_t")()
            keyframe.utime, keyframe.robot, keyframe.segment, keyframe.id = int(stamp * 1e6), robot.id, 1_000_000, index
            keyframe.q_O_K, keyframe.t_O_K = q, t
            log.write("KEYFRAME", keyframe.encode(), keyframe.utime)
            if index in (14, 39):
                trajectory = messages.message_type("trajectory_t")()
                trajectory.utime, trajectory.robot, trajectory.parts = keyframe.utime, robot.id, 1
                trajectory.n = trajectory.total_poses = index + 1
                trajectory.segments, trajectory.ids = [1_000_000] * trajectory.n, list(range(trajectory.n))
                trajectory.utimes = [int(at * 1e6) for at, _ in solution[:trajectory.n]]
                trajectory.T_W_K = [value for _, (r, p) in solution[:trajectory.n] for value in (*r, *p)]
                trajectory.n_values = len(trajectory.T_W_K)
                log.write("TRAJECTORY", trajectory.encode(), keyframe.utime)
        log.close()

    def weights(self, robot):
        message = messages.message_type("loop_weights_t")()
        message.utime, message.robot, message.round, message.parts = 5, robot.id, 3, 1
        with open(robot.file, encoding="ascii") as file:
            rows = [line.split(",") for line in file][1:]
        for a, i, b, j, *_, known_inlier, _ in rows:
            if known_inlier == "0":
                for name, value in (("robots_a", a), ("ids_a", i), ("robots_b", b), ("ids_b", j)):
                    getattr(message, name).append(int(value))
                message.segments_a.append(1_000_000)
                message.segments_b.append(1_000_000)
                message.residuals_sq.append(1.0)
        message.n = len(message.ids_a)
        # By the index within the pair of ids, so that both robots of a closure say the same.
        message.weights = [float((i + j) % 2) for i, j in zip(message.ids_a, message.ids_b)]
        return message

    def make(self):
        team = Team(self.robots)
        team.take(said("player", 0), 0.0)
        for robot in self.robots:
            team.take(said("dpgo", robot.id, gauges=done_gauges(robots=3)), 9.0)
            team.take(said("radio_bridge", robot.id, counters={"sent_bytes/dpgo": 1000}), 9.0)
        outcome = Outcome(team, "done", [], 10.0, 40.0)
        with mock.patch.object(pictures, "SIZE", "480x320"):
            facts = report.make(report.Run(self.folder, self.world, self.robots, outcome, "ideal.yaml", 3))
        report_page.write(self.folder, facts)
        with open(os.path.join(self.folder, "report.json"), encoding="utf-8") as file:
            return json.load(file)

    def test_a_whole_run(self):
        central = self.solve()
        found = self.make()
        self.assertEqual(found["notes"], [])
        team = found["team"]
        self.assertAlmostEqual(team["cost"], central.cost, places=3)
        self.assertAlmostEqual(team["cost_centralized"], central.cost, places=3)
        self.assertAlmostEqual(team["ate_m"], team["ate_centralized_m"], places=4)
        self.assertLess(team["ate_m"], team["ate_vio_m"])
        self.assertEqual(team["keyframes_online"], 3 * 25)
        self.assertTrue(team["ate_m"] < team["ate_online_m"] < team["ate_vio_m"], team)
        self.assertIn(" for 75 of 120 keyframes)", report_words.table(found))
        pairs = [(pair["a"], pair["b"]) for pair in team["loops"]]
        self.assertEqual(pairs, [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)])
        self.assertTrue(all(pair["met"] for pair in team["loops"]))
        self.assertEqual(sum(pair["accepted"] for pair in team["loops"]), team["loops_accepted"])
        self.assertTrue(0 < team["loops_accepted"] < team["loops_total"])
        self.assertTrue(all(pair["true"] <= min(pair["accepted"], pair["true_total"]) for pair in team["loops"]))
        self.assertEqual(found["communication_bytes"]["total"], 3000)
        self.assertEqual(found["realtime_factor"], 4.0)
        for robot in found["robots"]:
            self.assertEqual(robot["keyframes"], 40)
            self.assertAlmostEqual(robot["length_m"], 39 * 1.6, delta=6.0)
            self.assertLess(robot["ate_team_m"], 1.0)
        self.assertNotIn("mesh", found)
        page = self.read("report.html")
        self.assertIn("robust cost", page)
        self.assertGreaterEqual(page.count("data:image/png;base64,"), 3)

    def test_a_run_without_an_end_still_has_a_report(self):
        lcm_log.Writer(os.path.join(self.folder, "results.lcm")).close()
        found = self.make()
        self.assertTrue(found["notes"])
        self.assertNotIn("cost", found["team"])
        self.assertTrue(os.path.getsize(os.path.join(self.folder, "traj", "robot2_vio.tum")) > 1000)
        self.assertTrue(os.path.exists(os.path.join(self.folder, "report.html")))

    def test_whatever_goes_wrong_in_one_part_the_others_are_there(self):
        self.solve()
        for part, culprit in (("rounds", (report, "_measure_rounds")), ("radio", (evaluation, "evaluate_radio")),
                              ("poses at the time", (evaluation, "evaluate_online")),
                              ("lengths", (motion, "length")), ("graph", (evaluation, "evaluate_graph")),
                              ("truth", (evaluation, "evaluate_trajectories")),
                              ("central solution", (evaluation, "solve_centrally")), ("pictures", (pictures, "draw"))):
            with mock.patch.object(pictures, "draw", return_value=[]), \
                    mock.patch.object(*culprit, side_effect=KeyError("gone")):
                found = self.make()
            named = [note for note in found["notes"] if note.startswith(f"{part}: KeyError: 'gone' (")]
            self.assertEqual(len(named), 1, found["notes"])
            self.assertIn(html.escape(named[0]), self.read("report.html"))
            for name, needs in (("rounds", {"rounds"}), ("precision", {"graph"}), ("ate_m", {"truth"}),
                                ("ate_online_m", {"poses at the time"}),
                                ("loops_accepted_centralized", {"central solution", "graph"})):
                self.assertEqual(name in found["team"], part not in needs, f"{name} without {part}")
            self.assertEqual("length_m" in found["robots"][0], part != "lengths")
            self.assertIn(named[0], report_words.table(found))
            self.assertEqual(demo_command._conclude(Outcome(Team(self.robots), "done"), found), 1)

    def test_a_torn_trajectory_costs_what_needs_it_and_no_more(self):
        self.solve()
        with open(os.path.join(self.folder, "traj", "robot1_team.tum"), "a", encoding="ascii") as file:
            file.write("41.000000 1.0 2.0 3.0 0.0 0.0 0.0 1.0.5\n")
        found = self.make()
        self.assertTrue(any("robot1_team.tum" in note for note in found["notes"]), found["notes"])
        self.assertIn("loops_accepted_centralized", found["team"])


if __name__ == "__main__":
    unittest.main()
