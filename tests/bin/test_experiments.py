# SPDX-License-Identifier: BSD-3-Clause
"""bin/experiments, on a graph made up here: its rows, its report, what it refuses."""

import gzip
import json
import math
import os
import signal
import subprocess
import unittest

from support import BIN, Folder, run_tool, wait_until

from covey_tools.experiments import graphs, robustness, tables, vio

EXPERIMENTS = os.path.join(BIN, "experiments")


def circuit(laps=3, side=4):
    """Laps around a square, in g2o: odometry a little too long, and a loop from each pose to the same place a lap before."""
    lines, per_lap = [], 4 * side
    information = "400 0 0 400 0 10000"
    for k in range(laps * per_lap - 1):
        turn = 1.5707963267948966 if k % side == side - 1 else 0.0
        lines.append(f"EDGE_SE2 {k} {k + 1} {1.01 + 0.01 * (k % 3 - 1)} 0 {turn + 0.002} {information}")
        if k >= per_lap:
            lines.append(f"EDGE_SE2 {k - per_lap} {k} {0.01 * (k % 2)} 0 0 {information}")
    return "\n".join(lines) + "\n"


class Experiments(Folder, unittest.TestCase):
    def path(self, *names):
        return os.path.join(self.folder, *names)

    def write(self, name, text):
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)

    def command(self, *arguments):
        return [EXPERIMENTS, "robustness", "--quick", "--no-build", "--graph", "intel", "--data", self.path("data"),
                "--out", self.path("out"), *arguments]

    def test_rows_report_and_pictures(self):
        self.write("data/pose_graphs/intel.g2o", circuit())
        done = run_tool(*self.command("--seed", "5"))
        self.assertEqual((done.returncode, done.stderr.count("not measured")), (0, 0), done.stderr)
        self.assertEqual(done.stdout.strip(), self.path("out", "robustness.md"))
        facts = json.loads(self.read("out/robustness.json"))
        self.assertEqual((facts["seed"], set(facts)), (5, {"rows", "commit", "seed", "machine"}))
        # Two shares of outliers and three seeds; l2 once, the others at two thresholds, with one robot and with three.
        self.assertEqual(len(facts["rows"]), 2 * 3 * (2 + 2 * (3 + 7)))
        for row in facts["rows"]:
            self.assertTrue({"graph", "robots", "outliers", "seed", "probability", "barc2", "solver", "ate_m", "precision", "recall",
                             "cost", "seconds", "bytes_sent"} <= set(row))
            self.assertTrue(all(isinstance(value, (str, int, float, type(None))) for value in row.values()))
            self.assertGreaterEqual(row["ate_m"], 0.0)
            self.assertEqual(row["bytes_sent"] is not None, "dgnc" in row["solver"])
        gnc = tables.select(facts["rows"], solver="gnc", robots=3, outliers=0.1, probability=0.99)
        self.assertEqual([row["seed"] for row in gnc], [5, 6, 7])
        report = self.read("out/robustness.md")
        for text in ("## Claims", "dgnc's ATE is at most 1.05 x central gnc's", "| 70 % | 99 % |", "KITTI cut in three"):
            self.assertIn(text, report)
        for picture in ("robustness_intel_1.png", "robustness_intel_3.png"):
            self.assertIn(f"({picture})", report)
            with open(self.path("out", picture), "rb") as file:
                self.assertEqual(file.read(8), b"\x89PNG\r\n\x1a\n")

    def test_what_cannot_be_measured_is_said(self):
        self.write("data/pose_graphs/intel.g2o", circuit() + "EDGE_SE2 0 one\n")
        done = run_tool(*self.command())
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertRegex(done.stderr, r"nothing could be measured: graph intel .*intel.g2o:\d+: EDGE_SE2 has 3 fields")
        self.assertEqual(json.loads(self.read("out/robustness.json"))["rows"], [])
        self.write("data/pose_graphs/intel.g2o", circuit())
        done = run_tool(*self.command("--graph", "kitti_06_0.00"))
        self.assertEqual(done.returncode, 1)
        self.assertIn("kitti_06_alpha_0.00.g2o.gz is not there", done.stderr)
        self.assertIn("kitti_06_alpha_0.00.g2o.gz is not there", self.read("out/robustness.md"))

    def test_interrupted(self):
        self.write("data/pose_graphs/intel.g2o", circuit())
        process = subprocess.Popen(self.command(), stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.assertTrue(wait_until(lambda: os.path.isdir(self.path("out"))))
        process.send_signal(signal.SIGINT)
        out, complaint = process.communicate(timeout=20)
        self.assertEqual((process.returncode, out), (1, ""), complaint)
        self.assertNotIn("Traceback", complaint)
        self.assertLessEqual(set(os.listdir(self.path("out"))), {"robustness.runs"})

    def test_resumed(self):
        self.write("data/pose_graphs/intel.g2o", circuit())
        process = subprocess.Popen(self.command(), stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        journal = self.path("out", "robustness.runs")
        self.assertTrue(wait_until(lambda: os.path.exists(journal) and self.read("out/robustness.runs").count("\n") > 3))
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=20)
        runs = self.read("out/robustness.runs").splitlines()
        first = json.loads(runs[1])
        first[1]["cost"] = 4711.0  # so that one sees where it came from
        self.write("out/robustness.runs", "\n".join([runs[0], json.dumps(first), *runs[2:], runs[1][:20]]))
        self.assertEqual(run_tool(*self.command("--resume")).returncode, 0)
        rows = json.loads(self.read("out/robustness.json"))["rows"]
        self.assertEqual((rows[0]["cost"], len(rows)), (4711.0, 2 * 3 * (2 + 2 * (3 + 7))))
        self.assertFalse(os.path.exists(journal))
        # Of another pgo, or not asked for: nothing is taken over.
        for arguments, digest in ((["--resume"], "of another"), ([], runs[0])):
            self.write("out/robustness.runs", "\n".join([digest, json.dumps(first), ""]))
            self.assertEqual(run_tool(*self.command(*arguments)).returncode, 0)
            self.assertNotEqual(json.loads(self.read("out/robustness.json"))["rows"][0]["cost"], 4711.0)

    def test_usage(self):
        self.write("data/pose_graphs/intel.g2o", circuit())
        for arguments, sentence in ((["nonsense"], "invalid choice: 'nonsense'"), (["robustness", "--data", self.path("none")], "no such folder"),
                                    (["robustness", "--no-build", "--data", self.path("data"), "--out", self.path("out"), "--graph", "moon"],
                                     "--graph moon: no run is on"),
                                    ([], "NAME")):
            done = run_tool(EXPERIMENTS, *arguments)
            self.assertEqual((done.returncode, done.stdout), (2, ""), arguments)
            self.assertIn(sentence, done.stderr)
        text = run_tool(EXPERIMENTS, "--help").stdout
        for name in ("robustness", "graphs", "vio"):
            self.assertIn(f"\n  {name} ", text)


class Claims(Folder, unittest.TestCase):
    def row(self, solver, **values):
        return {"graph": "intel", "robots": 3, "outliers": 0.7, "seed": 1, "probability": None if solver == "l2" else 0.99, "barc2": None,
                "start": None, "solver": solver, "ate_m": 0.01, "precision": 1.0, "recall": 1.0, "cost": 1.0, "seconds": 1.0, **values}

    def verdict(self, claim, more=(), **of_dgnc):
        solvers = ("l2", "pcm", "gnc", "pcm+gnc", "gnc-naive", "pcm+dgnc", "dgnc-naive")
        rows = [self.row(solver) for solver in solvers] + [self.row("dgnc", **of_dgnc), *more]
        return next(line for line in robustness.report(rows, [], self.folder).splitlines() if claim in line)

    def test_claims_are_computed_from_the_rows(self):
        self.assertIn("**holds**", self.verdict("1.05 x central gnc", ate_m=0.0114))
        self.assertIn("**DOES NOT HOLD**", self.verdict("1.05 x central gnc", ate_m=0.0116))
        self.assertIn("**holds**", self.verdict("at most 0.10 m", ate_m=0.1))
        self.assertIn("**DOES NOT HOLD**", self.verdict("at most 0.10 m", ate_m=0.11))
        looser = [self.row(solver, probability=0.5, ate_m=0.2) for solver in ("gnc", "dgnc")]  # the claim is of 99 %
        self.assertRegex(self.verdict("at most 0.10 m", more=looser), r"\*\*holds\*\*.*not judged, at other thresholds: 50 % 0.2 m")
        self.assertIn("**DOES NOT HOLD**", self.verdict("recall is at least 0.99", recall=0.98))
        self.assertIn("**DOES NOT HOLD**", self.verdict("precision within 0.01", precision=0.98))
        for claim in ("from the naive start most runs fail", "the same by the team"):
            self.assertIn("**DOES NOT HOLD**", self.verdict(claim))
        self.assertIn("**not measured**", self.verdict("KITTI cut in three"))

    def test_decisions_are_compared_with_the_cheapest_central_run(self):
        def tunnels(solver, start, cost, decisions):
            return self.row(solver, graph="tunnels", robots=8, outliers=None, probability=None, barc2=100, start=start, cost=cost,
                            decisions=decisions)
        rows = [tunnels("gnc", None, 3.0, "1111"), tunnels("gnc", "odometry", 2.0, "1100"), tunnels("dgnc", None, 2.0, "1101"),
                self.row("gnc", decisions=None)]
        robustness.compare_decisions(rows)
        self.assertEqual([row["agreement"] for row in rows], [0.5, 1.0, 0.75, None])
        self.assertNotIn("decisions", rows[0])
        for row in rows:
            row.update(loops=4, kept_loops=2, shared_loops=4, kept_shared_loops=2, rounds=None, bytes_sent=None)
        report = robustness.report(rows, [], self.folder)
        self.assertRegex(report, "DOES NOT HOLD.*: the same: at least 97 % of its decisions.* 75.00 % of the loops")

    def test_medians(self):
        rows = [self.row("gnc", ate_m=value) for value in (3.0, 1.0, None, 2.0)]
        self.assertEqual(tables.median(rows, "ate_m"), 2.0)
        self.assertEqual(tables.select(rows, ate_m=(1.0, 2.0)), [rows[1], rows[3]])


class Graphs(Folder, unittest.TestCase):
    path, write = Experiments.path, Experiments.write

    def test_published_graphs(self):
        self.write("data/pose_graphs/intel.g2o", circuit())
        done = run_tool(EXPERIMENTS, "graphs", "--quick", "--no-build", "--graph", "intel", "--data", self.path("data"), "--out",
                        self.path("out"))
        self.assertEqual((done.returncode, done.stdout.strip()), (0, self.path("out", "graphs.md")), done.stderr)
        rows = json.loads(self.read("out/graphs.json"))["rows"]
        self.assertEqual([(row["solver"], row["robots"]) for row in rows],
                         [("l2", 1), ("rbcd", 5), ("schur", 5), ("gnc", 3), ("dgnc", 3), ("elected", 3)])
        for row in rows:
            self.assertEqual(row["graph"], "intel")
            self.assertGreater(row["certified_gap"], 0.0)
            self.assertEqual(row["bytes_sent"] is not None, row["robots"] > 1 and row["solver"] != "gnc")
        self.assertLess(rows[0]["certified_gap"], 1e-6)
        self.assertLess(abs(rows[5]["gap"]), 1e-3)  # to gnc's cost
        self.assertIn("(graphs.png)", self.read("out/graphs.md"))
        self.assertTrue(os.path.exists(self.path("out", "graphs.png")))

    def test_stata_claim(self):
        def held(**values):
            row = {"solver": "dgnc", "start": None, "robots": 3, "gap": -1e-3, "seconds": 4.0, "rounds": 40, "shared_loops": 3, "kept_shared_loops": 3,
                   "bytes_sent": 1, "certified_gap": None, "outliers": 0.0}
            rows = [{"graph": graph, **row, **values} for graph in graphs.STATA]
            return next(verdict for sentence, _, verdict in graphs.shows(rows) if sentence.startswith("Stata"))

        self.assertIs(held(), True)
        for worse in ({"gap": 2e-3}, {"seconds": 31.0}, {"rounds": 51}, {"kept_shared_loops": 2}):
            self.assertIs(held(**worse), False)

    def test_planted_minimum(self):
        done = run_tool(EXPERIMENTS, "graphs", "--quick", "--no-build", "--graph", "ring", "--data", self.folder, "--out", self.path("out"))
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = json.loads(self.read("out/graphs.json"))["rows"]
        self.assertEqual([(row["solver"], row["start"], row["robots"]) for row in rows], [("l2", None, 1), ("l2", "odometry", 1), ("dgnc", None, 10)])
        self.assertLess(rows[0]["certified_gap"], 1e-6)
        self.assertGreater(rows[1]["cost"], 100.0 * rows[0]["cost"])

        def held(rows):
            return [verdict for sentence, _, verdict in graphs.shows(rows) if "planted" in sentence or "the team's" in sentence]

        self.assertEqual(held(rows), [True, True])
        self.assertEqual(held(rows[:2]), [None, None])
        self.assertEqual(held([*rows[:2], {**rows[2], "certified_gap": 0.9}]), [False, False])
        self.assertEqual(held([*rows[:2], {**rows[2], "gap": 0.0}])[0], False)  # the optimum is no planted minimum

    def test_claims_need_all_that_they_name(self):
        def row(graph, gap):
            return {"graph": graph, "start": None, "solver": "l2", "robots": 1, "gap": gap, "seconds": 1.0, "certified_gap": 1e-8}

        def held(rows):
            return graphs.shows(rows)[0][2]

        self.assertIsNone(held([]))
        self.assertIsNone(held([row("intel", 1e-9)]))
        self.assertIs(held([row(graph, 1e-9) for graph in graphs.OPTIMA]), True)
        self.assertIs(held([row("intel", -1e-5)]), False)


def write_flight(folder, seconds=8.0):
    """A recorded flight: in a circle of 1 m, looking ahead, after standing for a second; its IMU without noise."""
    begin_ns, rate = 1_400_000_000_000_000_000, 200
    imu, truth = [], []
    for k in range(int(seconds * rate) + 1):
        t = max(0.0, k / rate - 1.0)
        # The angle and its derivatives: smooth from rest.
        angle, speed, gain = 0.2 * t * t * t / (1 + t * t), 0.2 * t * t * (3 + t * t) / (1 + t * t) ** 2, 0.4 * t * (3 - t * t) / (1 + t * t) ** 3
        x, y, ax, ay = math.cos(angle), math.sin(angle), 0.0, 0.0
        ax, ay = -speed * speed * x - gain * y, -speed * speed * y + gain * x
        yaw = angle + math.pi / 2
        # Body x up, z ahead, y to the right: half a turn about (x + z) / sqrt(2), then the yaw.
        ahead, right = ax * math.cos(yaw) + ay * math.sin(yaw), ax * math.sin(yaw) - ay * math.cos(yaw)
        stamp = begin_ns + k * 1_000_000_000 // rate
        imu.append(f"{stamp},{speed:.9f},0,0,9.81,{right:.9f},{ahead:.9f}")
        c, s = math.cos(yaw / 2) / math.sqrt(2), math.sin(yaw / 2) / math.sqrt(2)
        truth.append(f"{stamp},{x:.9f},{y:.9f},1.2,{-s:.9f},{c:.9f},{s:.9f},{c:.9f}")
    os.makedirs(folder)
    for name, rows in (("imu0", imu), ("groundtruth", truth)):
        with gzip.open(os.path.join(folder, f"{name}.csv.gz"), "wt") as file:
            file.write("#stamp\n" + "\n".join(rows) + "\n")


class Vio(Folder, unittest.TestCase):
    path = Experiments.path

    def run_vio(self, *arguments):
        return run_tool(EXPERIMENTS, "vio", "--no-build", "--data", self.folder, "--out", self.path("out"), "--cache", self.path("cache"), *arguments)

    def test_a_flight_in_a_folder_of_its_own(self):
        write_flight(self.path("flights", "circle"))
        write_flight(self.path("flights", "damaged"), 3.0)
        with gzip.open(self.path("flights", "damaged", "imu0.csv.gz"), "wt") as file:
            file.write("1,2,3\n")
        done = self.run_vio("--motion", self.path("flights"), "--seconds", "6")
        self.assertEqual((done.returncode, done.stdout.strip()), (1, self.path("out", "vio.md")), done.stderr)
        self.assertRegex(done.stderr, r"not measured: damaged: .*imu0.csv.gz:1")
        row, = json.loads(self.read("out/vio.json"))["rows"]
        self.assertEqual((row["sequence"], row["seconds"], row["segments"]), ("circle", 6.0, 1))
        self.assertLess(row["ate_m"], 0.02)
        self.assertGreaterEqual(row["completion"], 0.99)
        self.assertLess(row["first_state_s"], 2.0)
        for measure in ("ms_mean", "ms_p99", "rss_mb", "nees", "edge_nees_1s"):
            self.assertGreater(row[measure], 0.0, measure)
        self.assertTrue({"rpe_percent", "edge_nees_60s"} <= set(row))  # None: the way is too short
        report = self.read("out/vio.md")
        self.assertIn("- damaged: ", report)
        for picture in ("vio_ways.png", "vio_errors.png", "vio_ms.png"):
            self.assertIn(f"({picture})", report)
            self.assertTrue(os.path.exists(self.path("out", picture)))

        # Again: nothing is rendered, and the odometry is the same.
        family = self.path("cache", "flight-circle-6s-euroc-seed1")
        log = os.path.join(family, next(name for name in os.listdir(family) if not name.endswith(".lock")), "robot0.lcm")
        made = os.path.getmtime(log)
        again = self.run_vio("--motion", self.path("flights", "circle"), "--seconds", "6")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(os.path.getmtime(log), made)
        self.assertEqual(json.loads(self.read("out/vio.json"))["rows"][0]["ate_m"], row["ate_m"])

    def test_usage(self):
        os.makedirs(self.path("empty"))
        write_flight(self.path("flights", "circle"), 1.0)
        for arguments, sentence in ((["--motion", self.path("none")], "none: no such folder; expected recorded flights"),
                                    (["--motion", self.path("empty")], "no flight in it"),
                                    ([], "euroc/motion: no such folder"),
                                    (["--motion", self.path("flights"), "--sequences", "V9"], "V9: no such sequence; there are circle"),
                                    (["--graph", "intel"], "--graph is for robustness, graphs"),
                                    (["--seconds", "0"], "not a number from 2 on")):
            done = self.run_vio(*arguments)
            self.assertEqual((done.returncode, done.stdout), (2, ""), arguments)
            self.assertIn(sentence, done.stderr)
            self.assertNotIn("Traceback", done.stderr)

    def test_claims_are_computed_from_the_rows(self):
        def verdicts(**values):
            row = {"sequence": "V1_01_easy", "ate_m": 0.03, "first_state_s": 0.7, "completion": 1.0, "ms_mean": 8.0, "ms_p99": 20.0, "rss_mb": 60.0,
                   "edge_nees_1s": 1.0, "edge_nees_10s": 1.0, "edge_nees_60s": None, **values}
            return vio._claims([row]).splitlines()[2:]

        self.assertEqual([line.split("**")[1] for line in verdicts()], ["holds"] * 9 + ["not measured"])
        for wrong in ({"ate_m": 0.045}, {"first_state_s": None}, {"completion": 0.98}, {"ms_p99": 26.0}, {"edge_nees_1s": 3.0}):
            self.assertEqual(sum("DOES NOT HOLD" in line for line in verdicts(**wrong)), 1, wrong)
        self.assertIn("V1_01_easy 0.0450 m of 0.04", "".join(verdicts(ate_m=0.045)))


if __name__ == "__main__":
    unittest.main()
