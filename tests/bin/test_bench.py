# SPDX-License-Identifier: BSD-3-Clause
"""The bench around the robots, as programs: sim, evaluate, player."""

import json
import os
import unittest

from support import IN_NAMESPACE, Folder, run_tool

from covey_tools import lcm_log, places

PROGRAMS = os.path.join(places.build_folder(), "bin")
SIM, EVALUATE, PLAYER = (os.path.join(PROGRAMS, name) for name in ("sim", "evaluate", "player"))


class Bench(Folder, unittest.TestCase):
    def path(self, *names):
        return os.path.join(self.folder, *names)

    def simulate(self, folder="graph", **options):
        arguments = [word for name, value in options.items() for word in (f"--{name}", str(value))]
        done = run_tool(SIM, "--graph", self.path(folder), *arguments)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def truths(self):
        return [self.path("graph", f"robot{robot}_truth.tum") for robot in range(3)]

    def evaluate(self, *arguments):
        done = run_tool(EVALUATE, *arguments)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return json.loads(done.stdout)

    def refuses(self, sentence, program, *arguments):
        done = run_tool(program, *arguments)
        self.assertEqual(done.returncode, 2, done.stdout)
        self.assertIn(sentence, done.stderr)


class Sim(Bench):
    def test_the_same_seed_gives_the_same_files(self):
        for folder, seed in (("a", 5), ("b", 5), ("c", 6)):
            self.simulate(folder, seconds=40, seed=seed)
        a, b, c = (self.read(f"{folder}/robot1.csv") for folder in "abc")
        self.assertEqual(a, b)
        self.assertNotEqual(a, c)

    def test_one_robot_alone(self):
        self.simulate("all", seconds=40)
        self.simulate("one", seconds=40, robot=2)
        self.assertEqual(sorted(os.listdir(self.path("one"))), ["robot2.csv", "robot2_truth.tum"])
        self.assertEqual(self.read("one/robot2.csv"), self.read("all/robot2.csv"))

    def test_refusals(self):
        self.refuses("say what to make", SIM, "--seconds", "40")
        self.refuses("there are only robots 0 to 2", SIM, "--robot", "3", "--graph", self.folder)
        with open(self.path("bad.yaml"), "w", encoding="utf-8") as file:
            file.write("sim:\n  block_m: 8\n  fog: 1\n")
        self.refuses("bad.yaml:3: unknown key 'sim.fog'", SIM, "--graph", self.folder, "--config",
                     self.path("bad.yaml"))
        with open(self.path("nobody.yaml"), "w", encoding="utf-8") as file:
            file.write("dpgo: {rounds: 3}\nsmi:\n  block_m: 8\n")
        self.refuses("nobody.yaml:2: unknown key 'smi'", SIM, "--graph", self.folder, "--config",
                     self.path("nobody.yaml"))


class Evaluate(Bench):
    def test_trajectories_of_a_team(self):
        self.simulate(seconds=40)
        a, b, c = self.truths()
        all_three = self.evaluate("trajectory", "--estimate", a, b, c, "--reference", a, b, c)
        self.assertLess(all_three["ate_m"], 1e-6)
        self.assertEqual(all_three["matched"], 120)
        joint = self.evaluate("trajectory", "--estimate", a, "--reference", a, "--joint", b, b, c, c)
        self.assertEqual(joint, all_three)
        mixed = self.evaluate("trajectory", "--estimate", a, c, "--reference", a, b)
        self.assertLess(mixed["robots"][0]["by_itself"]["rmse_m"], 1e-6)
        self.assertGreater(mixed["ate_m"], 1.0)
        self.assertGreater(mixed["robots"][0]["with_team"]["rmse_m"], 0.1)

    def test_a_graph_at_its_truth(self):
        self.simulate(seconds=40)
        score = self.evaluate("graph", "--graph", self.path("graph"), "--estimate", *self.truths(), "--truth",
                              *self.truths(), "--barc2", "25", "--loops", self.path("loops.txt"))
        self.assertEqual(score["precision"], 1.0)
        kinds = [line.split()[6] for line in self.read("loops.txt").splitlines()]
        self.assertEqual(kinds.count("true"), score["loops"]["accepted"])
        self.assertEqual(len(kinds), score["loops"]["total"])

    def test_refusals(self):
        with open(self.path("bad.tum"), "w", encoding="ascii") as file:
            file.write("1.0 0 0 0 0 0 0 1\n2.0 0 0 zero 0 0 0 1\n")
        bad = self.path("bad.tum")
        self.refuses("bad.tum:2: expected eight numbers", EVALUATE, "trajectory", "--estimate", bad, "--reference", bad)
        self.simulate(seconds=40)
        a, b, c = self.truths()
        self.refuses("one reference for each estimate", EVALUATE, "trajectory", "--estimate", a, b, "--reference", a)
        self.refuses("an estimate and its reference in turn", EVALUATE, "trajectory", "--estimate", a, "--reference", a,
                     "--joint", b)
        self.refuses("--estimate has 2 files, and the graph has 3 robots", EVALUATE, "graph", "--graph",
                     self.path("graph"), "--barc2", "25", "--estimate", a, b)
        self.refuses("nowhere.lcm", EVALUATE, "radio", "--log", self.path("nowhere.lcm"))
        self.refuses("subcommand is required", EVALUATE)


class Player(Bench):
    URL = "udpm://239.255.76.67:7751?ttl=0&recv_buf_size=4194304"

    def record(self, shell, seconds):
        """What is heard on URL while the shell line runs, in a private network: {channel: [bytes]}."""
        log = self.path("heard.lcm")
        logger = f"timeout -s INT {seconds} lcm-logger --quiet -f --lcm-url='{self.URL}' {log}"
        run_tool(IN_NAMESPACE, "--require-private", "--", "sh", "-c", f"{logger} & sleep 0.5; {shell}; wait")
        heard = {}
        for event in lcm_log.Log(log):
            heard.setdefault(event.channel, []).append(event.data)
        return heard

    def test_a_pose_graph_and_its_log_again(self):
        self.simulate(seconds=40)
        graph = f"{PLAYER} --robot 1 --pose-graph {self.path('graph')} --speed 0 --url '{self.URL}'"
        first = self.record(f"timeout -s INT 1.5 {graph}; timeout -s INT 1.5 {graph}", 4.5)
        own_loops = self.read("graph/robot1.csv").count("\n") - 1 - 39
        # A player that is started again says the same again.
        self.assertEqual(len(first["KEYFRAME"]), 80)
        self.assertEqual(first["KEYFRAME"][:40], first["KEYFRAME"][40:])
        self.assertEqual(len(first["LOOP"]), 2 * own_loops)
        self.assertEqual(len(set(first["LOOP"])), own_loops)
        self.assertIn("STREAM_HEAD", first)
        os.rename(self.path("heard.lcm"), self.path("first.lcm"))
        log = f"{PLAYER} --log {self.path('first.lcm')} --channels 'KEYFRAME|LOOP' --speed 0 --url '{self.URL}'"
        again = self.record(log, 2)
        self.assertEqual(again["KEYFRAME"], first["KEYFRAME"])
        self.assertEqual(again["LOOP"], first["LOOP"])
        self.assertNotIn("STREAM_HEAD", again)

    def test_a_killed_player_catches_up(self):
        self.simulate(seconds=40)
        graph = (f"{PLAYER} --robot 1 --pose-graph {self.path('graph')} --speed 13 --state {self.path('state')} "
                 f"--url '{self.URL}'")  # 39 s of data in 3 s
        keyframes = self.record(f"timeout -s KILL 2 {graph}; timeout -s INT 2 {graph}", 5)["KEYFRAME"]
        # From its own start on, the second player would come to the 26th of 40.
        before, after = keyframes[:-40], keyframes[-40:]
        self.assertEqual(len(set(after)), 40)
        self.assertEqual(before, after[:len(before)])
        self.assertGreater(len(before), 5)
        self.assertLess(len(before), 35)
        stamps = [event.utime for event in lcm_log.Log(self.path("heard.lcm")) if event.channel == "KEYFRAME"]
        self.assertGreater((stamps[-1] - stamps[0]) * 1e-6, 2.9)  # the rest comes in time

    def test_refusals(self):
        self.refuses("give one source to play", PLAYER, "--robot", "1")
        self.refuses("--pose-graph needs --robot", PLAYER, "--pose-graph", self.folder, "--url", self.URL)
        self.refuses("has no robot<i>.csv", PLAYER, "--robot", "1", "--pose-graph", self.folder)
        self.refuses("not a regular expression", PLAYER, "--robot", "1", "--log", "x", "--channels", "(")


if __name__ == "__main__":
    unittest.main()
