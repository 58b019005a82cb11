# SPDX-License-Identifier: BSD-3-Clause
"""What a report says of how closures were found and lost."""

import unittest

import support  # noqa: finds covey_tools

from covey_tools import funnels
from covey_tools.team import Said


def lcd(**counters):
    return Said(counters={name.replace("__", "/"): n for name, n in counters.items()})


class Funnels(unittest.TestCase):
    def test_both_robots_words_are_summed_by_pair(self):
        pairs = funnels.of_pairs({
            0: lcd(funnel__0__accepted=2, funnel__1__received=30, funnel__1__told=4, funnel__2__received=9, in__LCD_BAG=39),
            1: lcd(funnel__0__received=20, funnel__0__candidate=50, funnel__0__accepted=4, funnel__0__refused__overlap=3,
                   funnel__0__refused__matches=40, funnel__0__refused__gone=0),
            2: Said()})
        self.assertEqual([(pair["a"], pair["b"]) for pair in pairs], [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)])
        of = {(pair["a"], pair["b"]): pair for pair in pairs}
        self.assertEqual(of[0, 0]["accepted"], 2)
        self.assertEqual((of[0, 1]["received"], of[0, 1]["candidate"], of[0, 1]["accepted"], of[0, 1]["told"]), (50, 50, 4, 4))
        self.assertEqual(of[0, 1]["refused"], {"matches": 40, "overlap": 3})
        self.assertEqual(funnels.in_words(of[0, 1]), "40 matches, 3 overlap")
        self.assertEqual(of[0, 2]["received"], 9)
        self.assertEqual(funnels.in_words(of[1, 2]), "-")

    def test_counters_of_earlier_runs_count(self):
        killed = lcd(funnel__1__accepted=5)
        killed._before = {"funnel/1/accepted": 7}
        self.assertEqual(funnels.of_pairs({0: killed, 1: Said()})[1]["accepted"], 12)

    def test_what_is_not_of_a_robot_of_the_team_is_left_out(self):
        found = funnels.of_pairs({0: lcd(funnel__9__accepted=5, funnel__x__accepted=5, funnel__accepted=5)})
        self.assertEqual(found, [{"a": 0, "b": 0, **dict.fromkeys(funnels.STEPS, 0), "refused": {}}])


if __name__ == "__main__":
    unittest.main()
