# SPDX-License-Identifier: BSD-3-Clause
"""exec strings: quoting, assignments, variables."""

import unittest

import support  # noqa: puts bin/ in the path
from covey_tools.errors import InputError
from covey_tools.grammar import SheetError, parse_sheet
from covey_tools.launch import identity, prepare, sheet_environment
from covey_tools.words import WordError, split_exec

VALUES = {"A": "one two", "B_2": "b", "EMPTY": ""}


class Words(unittest.TestCase):
    def check(self, text, arguments, environment=None):
        words = split_exec(text, VALUES)
        self.assertEqual((words.arguments, words.environment), (arguments, environment or {}))

    def test_quoting(self):
        self.check("a  b\tc", ["a", "b", "c"])
        self.check("a 'b c' \"d e\"", ["a", "b c", "d e"])
        self.check("a 'b'\"c\"d", ["a", "bcd"])
        self.check("a '' \"\"", ["a", "", ""])
        self.check(r"a b\ c \"d\" \\", ["a", "b c", '"d"', "\\"])
        self.check("a 'it\\s'", ["a", "it\\s"])

    def test_variables(self):
        self.check("x $A ${B_2}y $B_2/z", ["x", "one two", "by", "b/z"])  # a value is one word, as in procman
        self.check('x "$A" \'$A\' \\$A', ["x", "one two", "$A", "$A"])
        self.check("x $NONE $ $1 ${A", ["x", "$NONE", "$", "$1", "${A"])
        self.check("x $EMPTY", ["x", ""])
        self.assertEqual(split_exec("x ${NONE}", VALUES).missing, [(2, "NONE")])

    def test_assignments(self):
        self.check("N=1 M='2 3' K=$A run a=b", ["run", "a=b"], {"N": "1", "M": "2 3", "K": "one two"})
        self.check('"N=1" run', ["N=1", "run"])
        self.check("2N=1 run", ["2N=1", "run"])

    def test_refusals(self):
        for text, offset in [("a 'b", 2), ('a b"', 3), ("", 0), ("N=1", 0), ("''", 0), ("a \0", 2)]:
            with self.subTest(text=text), self.assertRaises(WordError) as caught:
                split_exec(text, VALUES)
            self.assertEqual(caught.exception.offset, offset)


class Launches(unittest.TestCase):
    def prepare(self, text, settings=()):
        sheet = parse_sheet('cmd "a" {\n  exec = "' + text.replace('"', '\\"') + '"; deputy = "d"; }')
        return prepare(sheet.commands[0], sheet_environment(settings), "/proc/1/ns/net")

    def test_program_is_looked_up(self):
        self.assertEqual(self.prepare("sh -c true").arguments[0], "/usr/bin/sh")
        with self.assertRaisesRegex(SheetError, r'^sheet:2:11: command "a": no program "no-such-program"; expected'):
            self.prepare("no-such-program --robot 1")

    def test_settings_reach_the_command(self):
        launch = self.prepare("echo ${WORLD}", ["WORLD=grid"])
        self.assertEqual((launch.arguments[1:], launch.environment["WORLD"]), (["grid"], "grid"))
        with self.assertRaisesRegex(SheetError, r"^sheet:2:16: .*WORLD.*--set WORLD="):
            self.prepare("echo ${WORLD}")
        with self.assertRaises(InputError):
            sheet_environment(["WORLD"])

    def test_who_enters_the_network_by_itself(self):
        launch = self.prepare("sh ${COVEY_NETNS}")
        self.assertTrue(launch.outside)
        self.assertEqual(launch.arguments[1], "/proc/1/ns/net")
        self.assertFalse(self.prepare("sh x").outside)

    def test_identity(self):
        self.assertEqual(identity(self.prepare("sh --robot 3")), ("sh", 3, ("239.255.76.67", 7703)))
        self.assertEqual(identity(self.prepare("sh --robot=3 --url udpm://239.1.2.3:9000?ttl=0")),
                         ("sh", 3, ("239.1.2.3", 9000)))
        self.assertEqual(identity(self.prepare("sh x")), ("sh", -1, None))
        self.assertEqual(identity(self.prepare("nice -n 5 lcd --robot 3")), ("lcd", 3, ("239.255.76.67", 7703)))


if __name__ == "__main__":
    unittest.main()
