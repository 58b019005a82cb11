# SPDX-License-Identifier: BSD-3-Clause
"""The sheet's grammar: what is read, and where and why a wrong sheet is refused."""

import glob
import os
import random
import tempfile
import unittest

import support
from covey_tools.errors import InputError
from covey_tools.grammar import SheetError, parse_sheet, read_sheet
from covey_tools.run import make_plan

WHOLE = r'''
# a comment
cmd "load configuration" {   # another; with { = } "in it"
    exec = "configure \"the robot\" a\\b";
    deputy = "robot";
}
group "hardware" {
    group "cameras" {
        cmd "left" { exec = "left_camera"; deputy = "robot"; auto_respawn = "true"; stop_signal = 15;
                     stop_time_allowed = 20; }
        cmd "right" { host = "robot"; exec = "right_camera"; auto_respawn = "false"; }
    }
    cmd "imu" { exec = "imu"; deputy = "robot"; }
}
group "hardware" { cmd "gps" { exec = "gps"; deputy = "robot"; } }
script "go" {
    start cmd "load configuration" wait "stopped";
    start group "hardware/cameras" wait "running";
    wait ms 250;
    restart cmd "left";
    run_script "rest";
    wait group "/hardware/" status "running";
    stop everything wait "stopped";
}
script "rest" { start everything; wait cmd "imu" status "running"; }
'''


class Accepted(unittest.TestCase):
    def test_whole_grammar(self):
        sheet = parse_sheet(WHOLE)
        self.assertEqual([command.id for command in sheet.commands],
                         ["load configuration", "left", "right", "imu", "gps"])
        left = sheet.command("left")
        self.assertEqual((left.group, left.exec, left.deputy), ("hardware/cameras", "left_camera", "robot"))
        self.assertEqual((left.auto_respawn, left.stop_signal, left.stop_time_allowed_s), (True, 15, 20))
        right = sheet.command("right")
        self.assertEqual((right.auto_respawn, right.stop_signal, right.stop_time_allowed_s), (False, 2, 7))
        self.assertEqual(right.deputy, "robot")
        self.assertEqual(sheet.command("load configuration").exec, r'configure "the robot" a\b')

    def test_groups_include_subgroups(self):
        sheet = parse_sheet(WHOLE)
        self.assertEqual([command.id for command in sheet.select("group", "hardware")], ["left", "right", "imu", "gps"])
        self.assertEqual([command.id for command in sheet.select("group", "hardware/cameras")], ["left", "right"])
        self.assertEqual(len(sheet.select("everything")), 5)

    def test_scripts_are_flattened(self):
        self.assertEqual([str(action) for action in parse_sheet(WHOLE).flatten("go")], [
            'start cmd "load configuration" wait "stopped"', 'start group "hardware/cameras" wait "running"',
            "wait ms 250", 'restart cmd "left"', "start everything", 'wait cmd "imu" status "running"',
            'wait group "/hardware/" status "running"', 'stop everything wait "stopped"'])

    def test_what_the_sheriff_would_mind_is_noted(self):
        sheet = parse_sheet('cmd "a" { exec = "x"; }\ncmd "b" { host = "h"; exec = "x"; }')
        self.assertEqual([note.split(": ")[0] for note in sheet.notes], ["sheet:1:5", "sheet:2:11"])

    def test_empty_sheet_and_unicode(self):
        self.assertEqual(parse_sheet("").commands, [])
        self.assertEqual(parse_sheet('cmd "größe" { exec = "echo ☃"; deputy = "d"; }').commands[0].exec, "echo ☃")

    def test_any_line_ending_ends_a_line(self):
        unix = "# a comment\n" + 'cmd "a" { exec = "x \\\n y"; deputy = "d"; }\n'
        with tempfile.TemporaryDirectory() as folder:
            for ending in ("\n", "\r\n", "\r"):
                path = os.path.join(folder, "endings.procman")
                with open(path, "w", encoding="utf-8", newline="") as file:
                    file.write(unix.replace("\n", ending))
                self.assertEqual([command.exec for command in read_sheet(path).commands], ["x \n y"], repr(ending))

    def test_a_byte_order_mark_is_noted(self):
        sheet = parse_sheet('\ufeffcmd "a" { exec = "x"; deputy = "d"; }')
        self.assertEqual((len(sheet.commands), [note.split(": ")[0] for note in sheet.notes]), (1, ["sheet:1:1"]))

    def test_numbers_at_their_bounds(self):
        sheet = parse_sheet('cmd "a" { exec = "x"; deputy = "d"; stop_signal = 0064; stop_time_allowed = 86400; }\n'
                            'script "s" { wait ms 0; wait ms 00; wait ms 86400000; }')
        self.assertEqual((sheet.commands[0].stop_signal, sheet.commands[0].stop_time_allowed_s), (64, 86400))
        self.assertEqual([action.delay_ms for action in sheet.scripts["s"].actions], [0, 0, 86400000])

    def test_every_sheet_of_ours_needs_no_note(self):
        files = glob.glob(os.path.join(support.ROOT, "configs", "sheets", "*.procman"))
        self.assertTrue(files)
        for file in files:
            self.assertEqual(read_sheet(file).notes, [], file)


class Refused(unittest.TestCase):
    def assert_refused(self, text, line, column, *words):
        with self.assertRaises(SheetError) as caught:
            parse_sheet(text, "f.procman")
        message = str(caught.exception)
        self.assertTrue(message.startswith(f"f.procman:{line}:{column}: "), message)
        for word in (*words, "expected"):
            self.assertIn(word, message)

    def test_places(self):
        command = 'cmd "a" { exec = "x"; deputy = "d"; }\n'
        for text, line, column, word in [
                ('cmd "a" { exec = "x" }', 1, 22, "';'"),
                ('cmd "a" { exec "x"; }', 1, 16, "'='"),
                ('cmd "a" { exec = x; }', 1, 18, '"string"'),
                ('cmd "a" {\n  exce = "x"; }', 2, 3, "exce"),
                ('cmd "a" { deputy = "d"; }', 1, 5, "nothing to execute"),
                ('cmd "a" { exec = "x"; stop_signal = "2"; }', 1, 37, "integer without quotes"),
                ('cmd "a" { exec = "x"; stop_signal = 0; }', 1, 37, "stop_signal"),
                ('cmd "a" { exec = "x"; stop_signal = 65; }', 1, 37, "stop_signal"),
                ('cmd "a" { exec = "x"; stop_time_allowed = 0; }', 1, 43, "stop_time_allowed"),
                ('cmd "a" { exec = "x"; stop_time_allowed = 1.5; }', 1, 44, "'.'"),
                ('cmd "a" { exec = "x"; auto_respawn = "maybe"; }', 1, 38, "maybe"),
                ('cmd "a" { exec = "x"; auto_respawn = true; }', 1, 38, '"string"'),
                ('cmd "a/b" { exec = "x"; }', 1, 5, "'/'"),
                ('cmd " " { exec = "x"; }', 1, 5, "empty"),
                ('cmd a { exec = "x"; }', 1, 5, "'a'"),
                ('cmd "a" { exec = "x"; ', 1, 23, "end of the file"),
                ('cmd "a" { exec = "x;\n }', 1, 18, "does not end"),
                ('cmd "a" { exec = "x', 1, 18, "does not end"),
                (command + command, 2, 5, "line 1"),
                ('group "g/h" { }', 1, 7, "'/'"),
                ('group "" { }', 1, 7, "empty"),
                ('group "g" {\n script "s" { } }', 2, 2, "'script'"),
                ('group "g" {\n' + command, 3, 1, "line 1"),
                ('task "a" { }', 1, 1, "'task'"),
                ("}", 1, 1, "'}'"),
                ("\t$", 1, 2, "'$'"),
                ("script go { }", 1, 8, "'go'"),
                ('script "s" { }\nscript "s" { }', 2, 8, "line 1"),
                ('script "s" { begin everything; }', 1, 14, "'begin'"),
                ('script "s" { start everything }', 1, 31, "'wait'"),
                ('script "s" { wait 5; }', 1, 19, "'ms'"),
                ('script "s" { wait ms "5"; }', 1, 22, "integer"),
                ('script "s" { wait ms 86400001; }', 1, 22, "86400000"),
                ('script "s" { wait ms ' + "9" * 5000 + "; }", 1, 22, "5000 digits"),
                ('cmd "a" { exec = "x"; stop_signal = ' + "9" * 5000 + "; }", 1, 37, "stop_signal"),
                (command + 'script "s" {\n start cmd "b"; }', 3, 2, 'no command "b"'),
                (command + 'script "s" { start group "g"; }', 2, 14, 'group "g"'),
                (command + 'script "s" { start cmd "a" wait "ready"; }', 2, 33, '"running" or "stopped"'),
                (command + 'script "s" { stop cmd "a" wait "running"; }', 2, 32, '"stopped"'),
                (command + 'script "s" { wait cmd "a" "running"; }', 2, 27, "'status'"),
                ('script "s" { run_script "t"; }', 1, 14, 'no script "t"'),
                ('script "s" { run_script "t"; }\nscript "t" { run_script "s"; }', 2, 14, "runs itself"),
                ('script "s" {', 1, 13, "line 1")]:
            with self.subTest(text=text):
                self.assert_refused(text, line, column, word)

    def test_a_script_that_waits_for_what_it_never_starts(self):
        sheet = parse_sheet('cmd "a" { exec = "x"; }\nscript "s" { wait cmd "a" status "running"; start cmd "a"; }')
        with self.assertRaisesRegex(SheetError, "^sheet:2:14: .*never|has not"):
            make_plan(sheet, "s")

    def test_files_that_cannot_be_read(self):
        with self.assertRaisesRegex(InputError, "no such file"):
            read_sheet("/nowhere/x.procman")
        with self.assertRaisesRegex(InputError, "is a directory"):
            read_sheet("/")

    def test_damaged_sheets_are_refused_or_read_but_nothing_else(self):
        generator = random.Random(1)
        for _ in range(3000):
            text = list(WHOLE)
            for _ in range(generator.randint(1, 4)):
                at = generator.randrange(len(text))
                kind = generator.randrange(3)
                if kind == 0:
                    del text[at]
                elif kind == 1:
                    text.insert(at, generator.choice('"{}=;#\\\n a1/\0é'))
                else:
                    text[at] = chr(generator.randrange(32, 127))
            try:
                parse_sheet("".join(text))
            except SheetError as error:
                self.assertRegex(str(error), r"^sheet:\d+:\d+: .*expected")


if __name__ == "__main__":
    unittest.main()
