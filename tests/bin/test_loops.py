# SPDX-License-Identifier: BSD-3-Clause
"""bin/experiments loops: its report, from made-up rows, and its rows, from what a program in bench_place's place says."""

import json
import os
import types
import unittest
from unittest import mock

from support import Folder

from covey_tools import recordings
from covey_tools.errors import InputError
from covey_tools.experiments import loops

FOUND = {"keyframes": 100, "accepted": 50, "true": 48, "episodes": 20, "recall": 0.9, "median_m": 0.01, "median_deg": 0.1, "nees_median": 4.0,
         "bytes_pr": 50_000, "bytes_gv": 200_000, "metres": 60.0, "query_ms": 0.1, "extract_ms": 11.0, "exchange_ms": 30.0,
         "curve": [{"similarity": 1.0, "precision": 1.0, "recall": 0.5}], "pairs": [{"a": 0, "b": 1, "accepted": 50, "true": 48}]}
ALIASES = {"pairs": 200, "similar": 20, "accepted": 1, "refused": {"matches": 150, "overlap": 49}}
MEMORY = {"keyframes": 2000, "own_kb": 30.0, "other_kb": 8.0}
QUERIES = [{"keyframes": n, "query_ms": n / 5000} for n in (1000, 5000, 20000)]


class Loops(Folder, unittest.TestCase):
    def options(self, **changed):
        return types.SimpleNamespace(**{"quick": True, "data": self.folder, "seed": 3, "graph": [], "seconds": None, "cache": self.folder, **changed})

    def rows(self, **changed):
        self.asked = []

        def bench(name, arguments):
            self.asked.append((name, list(arguments)))
            return json.dumps({**FOUND, "queries": QUERIES, "wrong": [], "aliases": ALIASES, "memory": MEMORY})

        with mock.patch("covey_tools.programs.run", bench), mock.patch.object(recordings, "keyframe_pictures", self.pictures):
            return loops.run(self.options(**changed), lambda line: None)

    def pictures(self, world, seed, data, cache):
        self.assertEqual((world.robots, seed), (3, 3))
        return mock.MagicMock(**{"__enter__.return_value": "/pictures"})

    def test_rows(self):
        os.makedirs(os.path.join(self.folder, "rgbd", "seven_scenes"))
        rows, notes = self.rows()
        self.assertEqual(([row["set"] for row in rows], notes), (["town", "queries", "queries", "queries", "memory", "rooms", "aliases", "7-scenes"], []))
        for row in rows:
            self.assertTrue({"set", "accepted", "true", "recall", "median_m", "median_deg", "bytes_pr", "bytes_gv", "query_ms"} <= set(row))
            self.assertEqual(set(row), set(rows[0]))
        self.assertEqual((rows[0]["seconds"], rows[0]["seed"], rows[0]["recall"]), (45.0, 3, 0.9))
        self.assertEqual((rows[3]["keyframes"], rows[3]["query_ms"], rows[3]["accepted"]), (20000, 4.0, None))
        (_, town), (_, rooms), (_, room) = self.asked
        self.assertIn("/pictures", town)
        self.assertIn("--aliases", rooms)
        self.assertEqual((rows[6]["pairs"], rows[6]["accepted"], rows[6]["true"]), (200, 1, 0))
        self.assertEqual((rows[4]["own_kb"], rows[5]["pairs"]), (30.0, None))
        self.assertEqual(room[-1], os.path.join(self.folder, "rgbd", "seven_scenes"))
        self.assertEqual(self.rows(quick=False)[0][0]["seconds"], 300.0)
        self.assertEqual(self.rows(seconds=20.0)[0][0]["seconds"], 20.0)

    def test_only_what_is_asked_for_and_there(self):
        rows, notes = self.rows()
        self.assertEqual(len(rows), 7)
        self.assertRegex(notes[0], "seven_scenes is not there")
        self.assertEqual([row["set"] for row in self.rows(graph=["town"])[0]], ["town"])
        with self.assertRaisesRegex(InputError, "moon"):
            self.rows(graph=["moon"])

    def verdict(self, words, **changed):
        town = {**dict.fromkeys(loops._KEYS), "set": "town", "robots": 3, **FOUND, **changed}
        queries = [{**dict.fromkeys(loops._KEYS), "set": "queries", **query} for query in QUERIES]
        aliases = {**dict.fromkeys(loops._KEYS), "set": "aliases", **ALIASES, **changed.get("aliases", {})}
        memory = {**dict.fromkeys(loops._KEYS), "set": "memory", **MEMORY, **changed.get("memory", {})}
        text = loops.report([town, *queries, aliases, memory], ["something"], self.folder)
        self.assertTrue(os.path.exists(os.path.join(self.folder, "loops_bytes.png")))
        self.assertTrue(os.path.exists(os.path.join(self.folder, "loops_curve.png")))
        self.assertIn("- something", text)
        return next(line for line in text.splitlines() if words in line)

    def test_claims_are_computed_from_the_rows(self):
        for words, bad in (("90 % are true", {"true": 44}), ("80 % of the overlap", {"recall": 0.79}), ("0.05 m and 0.6 deg", {"median_m": 0.06}),
                           ("0.05 m and 0.6 deg", {"median_deg": 0.7}), ("honest", {"nees_median": 1.0}), ("honest", {"nees_median": 11.0}),
                           ("2.9 kB", {"bytes_gv": 241_000}), ("12 ms", {"extract_ms": 12.5}), ("that are alike", {"aliases": {"accepted": 3}}),
                           ("40 kB of memory", {"memory": {"own_kb": 41.0}})):
            self.assertIn("**holds**", self.verdict(words))
            self.assertIn("**DOES NOT HOLD**", self.verdict(words, **bad))
        self.assertIn("**holds**", self.verdict("among 20000 keyframes"))
        self.assertIn("**not measured**", self.verdict("7-scenes accepts"))


if __name__ == "__main__":
    unittest.main()
