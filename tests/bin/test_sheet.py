# SPDX-License-Identifier: BSD-3-Clause
"""bin/sheet as a whole: real processes, in private networks."""

import fcntl
import os
import pty
import re
import signal
import struct
import sys
import termios
import time
import unittest

import support
from covey_tools import bus, namespace, status
from support import FAKE_PROCESS, PYTHON, Folder, is_alive, run_tool, wait_until


def command(name, line, *attributes):
    """One cmd of a sheet."""
    escaped = line.replace("\\", "\\\\").replace('"', '\\"')
    return f'cmd "{name}" {{ exec = "{escaped}"; deputy = "d"; {"".join(f"{each}; " for each in attributes)}}}\n'


RESPAWN = 'auto_respawn = "true"'


class Ending(Folder, unittest.TestCase):
    def test_ends_when_all_have_ended(self):
        code, out, err = self.run_sheet(command("a", "true") + command("b", "sleep 0.2"))
        self.assertEqual((code, err), (0, ""))
        self.assertRegex(out, r"(?m)^0\.\d s  a      started pid \d+$")
        self.assertRegex(out, r"(?m)^0\.\d s  b      exited with 0$")

    def test_a_failed_process_makes_it_1_and_its_last_words_are_shown(self):
        code, out, _ = self.run_sheet(command("a", "sh -c 'echo cannot open the sensor; exit 7'")
                                      + command("b", "sleep 0.2"))
        self.assertEqual(code, 1)
        self.assertIn("exited with 7: cannot open the sensor", out)

    def test_until_exit_gives_that_code(self):
        for last, code in (("exit 0", 0), ("exit 5", 5), ("kill -9 $$", 137)):
            with self.subTest(last=last):
                got, out, _ = self.run_sheet(command("job", f"sh -c 'sleep 0.1; {last}'")
                                             + command("rest", "sleep 100", RESPAWN), "--until-exit", "job")
                self.assertEqual(got, code, out)
                self.assertIn("rest   stopped: exited by signal 2", out)

    def test_until_exit_that_never_came_is_a_failure(self):
        code, _, err = self.run_sheet(command("job", "sleep 100"), "--until-exit", "job", "--duration", "0.3")
        self.assertEqual(code, 1)
        self.assertIn("job had not ended yet", err)

    def test_duration(self):
        start = time.monotonic()
        code, out, _ = self.run_sheet(command("a", "sleep 100"), "--duration", "0.5")
        self.assertEqual(code, 0, out)
        self.assertLess(time.monotonic() - start, 5)

    def test_wrong_sheets_and_options_exit_2_before_anything_starts(self):
        touched = os.path.join(self.folder, "touched")
        for text, arguments, word in [
                (command("a", f"touch {touched}") + "cmd", [], "test.procman:2:4: "),
                (command("a", f"touch {touched}") + command("b", "no-such-program"), [], "test.procman:2:19: "),
                (command("a", f"touch {touched}") + command("b", "echo ${NOT_SET_HERE}"), [], "test.procman:2:24: "),
                (command("a", f"touch {touched}"), ["start", "x"], 'no script "x"'),
                (command("a", f"touch {touched}"), ["go"], "start SCRIPT"),
                (command("a", f"touch {touched}"), ["--until-exit", "b"], "--until-exit b"),
                (command("a", f"touch {touched}"), ["--wait-for", "b"], "--wait-for b"),
                (command("a", f"touch {touched}"), ["--wait-for", "a"], "--robot"),
                (command("a", f"touch {touched}"), ["--set", "x"], "NAME=VALUE"),
                (command("a", f"touch {touched}"), ["--duration", "-1"], "--duration"),
                (command("a", f"touch {touched}"), ["--logs", "/proc/x"], "--logs /proc/x")]:
            with self.subTest(word=word):
                code, out, err = self.run_sheet(text, *arguments)
                self.assertEqual((code, out), (2, ""))
                self.assertIn(word, err)
                self.assertFalse(os.path.exists(touched))

    def test_dry_run_starts_nothing(self):
        touched = os.path.join(self.folder, "touched")
        code, out, _ = self.run_sheet(command("a", f"X=1 touch {touched}"), "--dry-run")
        self.assertEqual((code, out), (0, f"a: X=1 /usr/bin/touch {touched}\n"))
        self.assertFalse(os.path.exists(touched))

    def test_help(self):
        done = run_tool(f"{support.BIN}/sheet", "--help")
        self.assertEqual(done.returncode, 0)
        self.assertIn("--wait-for", done.stdout)


class Respawning(Folder, unittest.TestCase):
    def test_a_killed_process_comes_back_until_it_is_stopped_on_purpose(self):
        run = self.start_sheet(command("a", "sleep 100", RESPAWN))
        run.wait_for_event("a      started pid")
        pid = int(re.search(r"a      started pid (\d+)", self.read("logs/events.txt")).group(1))
        os.kill(pid, signal.SIGKILL)
        run.wait_for_event("exited by signal 9, respawning")
        run.wait_for_event("started pid")
        self.assertTrue(wait_until(lambda: self.read("logs/events.txt").count("started pid") == 2))
        run.interrupt()
        code, out, _ = run.finish()
        self.assertEqual(code, 0, out)
        self.assertEqual(out.count("started pid"), 2)

    def test_back_off_like_procmans(self):
        _, out, _ = self.run_sheet(command("a", "false", RESPAWN), "--duration", "2")
        self.assertEqual(re.findall(r"respawning in (\d+) ms", out)[:6], ["10", "20", "40", "80", "160", "320"])

    def test_without_auto_respawn_it_stays_away(self):
        _, out, _ = self.run_sheet(command("a", "false") + command("b", "sleep 0.5"))
        self.assertEqual(out.count("a      started"), 1)

    def test_what_a_dead_process_leaves_behind_is_killed(self):
        run = self.start_sheet(command("a", f"sh -c 'sleep 100 & echo $! > {self.folder}/child; exit 1'")
                               + command("b", "sleep 100"))
        run.wait_for_event("a      exited with 1")
        child = int(self.read("child"))
        self.assertTrue(wait_until(lambda: not is_alive(child)))


class Stopping(Folder, unittest.TestCase):
    # ignores SIGINT, and has a child that ignores it too and a grandchild in a session of its own
    STUBBORN = ("sh -c \"trap '' INT; echo $$ > {0}/p; "
                "(trap '' INT; echo $$; setsid sh -c 'echo \\$\\$ > {0}/g; exec sleep 100'; sleep 100) & "
                "while :; do sleep 1; done\"")

    def pids(self, *names):
        def read():
            try:
                return [int(self.read(name)) for name in names]
            except (FileNotFoundError, ValueError):
                return []
        self.assertTrue(wait_until(lambda: len(read()) == len(names)))
        return read()

    def test_sigkill_for_a_process_that_ignores_sigint_and_its_descendants(self):
        run = self.start_sheet(command("a", self.STUBBORN.format(self.folder), "stop_time_allowed = 1"))
        pids = self.pids("p", "g")
        run.interrupt()
        start = time.monotonic()
        code, out, _ = run.finish()
        self.assertEqual(code, 0, out)
        self.assertIn("still there after 1 s, killing it", out)
        self.assertIn("stopped: exited by signal 9", out)
        self.assertTrue(0.8 < time.monotonic() - start < 6)
        self.assertEqual([pid for pid in pids if is_alive(pid)], [])

    def test_a_second_interrupt_does_not_wait(self):
        run = self.start_sheet(command("a", self.STUBBORN.format(self.folder), "stop_time_allowed = 60"))
        pids = self.pids("p", "g")
        run.interrupt()
        run.wait_for_event("told to stop")
        run.interrupt()
        _, out, _ = run.finish(10)
        self.assertIn("killing what is left", out)
        self.assertEqual([pid for pid in pids if is_alive(pid)], [])

    def test_stop_signal_reaches_the_whole_group(self):
        line = f"sh -c \"sleep 100 & echo $! > {self.folder}/c; trap 'exit 4' USR1; wait\""
        run = self.start_sheet(command("a", line, "stop_signal = 10"))
        child, = self.pids("c")
        run.interrupt(signal.SIGTERM)
        code, out, _ = run.finish()
        self.assertEqual(code, 0)
        self.assertIn("told to stop by signal 10", out)
        self.assertIn("stopped: exited with 4", out)
        self.assertFalse(is_alive(child))

    def test_reverse_order(self):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            with self.subTest(number=number):
                run = self.start_sheet("".join(command(name, "sleep 100") for name in "abc"))
                run.wait_for_event("c      started")
                run.interrupt(number)
                code, out, _ = run.finish()
                self.assertEqual(code, 0)
                self.assertEqual(re.findall(r"(\w) +told to stop", out), ["c", "b", "a"])

    def test_daemons_do_not_outlive_the_sheet(self):
        daemon = f"setsid -f sh -c 'echo \\$\\$ > {self.folder}/d; exec sleep 100'"
        run = self.start_sheet(command("a", f'sh -c "{daemon}; sleep 100"'))
        daemon, = self.pids("d")
        run.interrupt()
        run.finish()
        self.assertFalse(is_alive(daemon))

    def test_killing_the_sheet_takes_the_processes_along(self):
        child = f"sleep 100 & echo $! > {self.folder}/c"
        run = self.start_sheet(command("a", f"sh -c 'echo $$ > {self.folder}/a; {child}; wait'"))
        pids = self.pids("a", "c")
        run.process.kill()
        run.finish()
        self.assertTrue(wait_until(lambda: not any(is_alive(pid) for pid in pids)))

    def test_a_sheet_started_with_sigint_ignored_still_stops_its_processes(self):
        with open(os.path.join(self.folder, "inner.procman"), "w", encoding="utf-8") as file:
            file.write(command("inner", "sleep 100"))
        inner = f"{support.BIN}/sheet {self.folder}/inner.procman --logs {self.folder}/inner --duration 0.3"
        code, out, _ = self.run_sheet(command("outer", f"sh -c \"trap '' INT; exec {inner}\""))
        self.assertEqual(code, 0, out)
        self.assertIn("stopped: exited by signal 2", self.read("inner/events.txt"))


class Scripts(Folder, unittest.TestCase):
    def test_a_script_in_its_order(self):
        text = (command("once", "sh -c 'sleep 0.3; echo done'") + command("server", "sleep 100", RESPAWN)
                + command("never", "sleep 100") + 'group "g" { ' + command("x", "sleep 100") + " }\n"
                'script "go" { start cmd "once" wait "stopped"; start cmd "server" wait "running"; run_script "more"; '
                'wait ms 200; restart cmd "server" wait "running"; stop everything wait "stopped"; }\n'
                'script "more" { start group "g"; }')
        code, out, err = self.run_sheet(text, "start", "go")
        self.assertEqual((code, err), (0, ""))
        out = re.sub(r"pid \d+", "pid", out)
        lines = [re.sub(r"^[\d.]+ s  (\w+) +", r"\1 ", line) for line in out.splitlines()][1:]
        self.assertEqual(lines, [
            'sheet start cmd "once" wait "stopped"', "once started pid", "once exited with 0",
            'sheet start cmd "server" wait "running"', "server started pid", 'sheet start group "g"', "x started pid",
            "sheet wait ms 200", 'sheet restart cmd "server" wait "running"', "server told to stop by signal 2",
            "server stopped: exited by signal 2, to be started again", "server started pid",
            'sheet stop everything wait "stopped"', "x told to stop by signal 2", "server told to stop by signal 2",
            *lines[15:17], "sheet ending: every process has ended"])
        self.assertEqual(sorted(lines[15:17]), ["server stopped: exited by signal 2", "x stopped: exited by signal 2"])


class Waiting(Folder, unittest.TestCase):
    def link(self, name):
        """fake_process.py by another name: a process's identity is its program's."""
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(f"#!/bin/sh\nexec {PYTHON} {FAKE_PROCESS} {name} \"$@\"\n")
        os.chmod(path, 0o755)
        return path

    def test_ready_when_all_publish_status(self):
        dpgo, other = self.link("dpgo"), self.link("radio_bridge")
        text = (command("dpgo-0", f"{dpgo} --robot 0 --after 0.4") + command("dpgo-1", f"{dpgo} --robot 1")
                + command("bridge", f"{other} --robot 1") + command("late", "sleep 100") +
                'script "go" { start cmd "dpgo-0"; start cmd "dpgo-1"; start cmd "bridge"; '
                'wait cmd "dpgo-0" status "running"; start cmd "late"; }')
        run = self.start_sheet(text, "start", "go", "--wait-for", "dpgo-0,dpgo/1,radio_bridge/1")
        run.wait_for_event("ready: 3 of 3")
        run.wait_for_event("late    started")
        run.interrupt()
        code, out, err = run.finish()
        self.assertEqual((code, err), (0, ""))
        self.assertLess(out.index("dpgo-0  publishes STATUS"), out.index("late    started"))

    def test_not_ready_in_time(self):
        dpgo = self.link("dpgo")
        code, out, err = self.run_sheet(command("dpgo-0", f"{dpgo} --robot 0")
                                        + command("dpgo-1", f"{dpgo} --robot 1 --after 100"),
                                        "--wait-for", "dpgo-0,dpgo-1", "--timeout", "4")
        self.assertEqual(code, 1, out)
        self.assertIn("no STATUS from dpgo-1 (dpgo of robot 1 on udpm://239.255.76.67:7701) in 4 s", err)
        self.assertNotIn("dpgo-0", err)

    def test_a_process_that_dies_first(self):
        code, out, err = self.run_sheet(command("a", "sh -c 'exit 2' --robot 0") + command("b", "sleep 100"),
                                        "--wait-for", "a")
        self.assertEqual(code, 1, out)
        self.assertIn("a ended before it published STATUS", err)

    def test_in_place_on_a_bus_of_its_own(self):
        dpgo = self.link("dpgo")
        run = self.start_sheet(command("a", f"{dpgo} --robot 5 --url udpm://239.255.76.99:17705?ttl=0"),
                               "--namespace", "in-place", "--wait-for", "dpgo/5")
        run.wait_for_event("ready: 1 of 1")


class Networks(Folder, unittest.TestCase):
    def test_commands_share_a_network_that_is_not_this_one(self):
        where = "readlink /proc/self/ns/net > " + self.folder
        text = command("a", f"sh -c '{where}/a'") + command("b", f"sh -c '{where}/b'")
        text += command("c", f"sh -c '{where}/c; stat -Lc %i $1 >> {self.folder}/c' x ${{COVEY_NETNS}}")
        code, out, _ = self.run_sheet(text, "--namespace", "private")
        self.assertEqual(code, 0, out)
        a, b, c = (self.read(name) for name in "abc")
        here = os.readlink("/proc/self/ns/net")
        self.assertEqual(a, b)
        self.assertNotEqual(a.strip(), here)
        outside, inside = c.split()
        self.assertEqual(outside, here)  # starts outside ...
        self.assertEqual(f"net:[{inside}]", a.strip())  # ... and is told the way in

    def test_a_bridge_hears_outside_and_speaks_inside(self):
        """The field case, in a network of its own for the outside: see fake_process.py."""
        bridge = os.path.join(self.folder, "radio_bridge")
        with open(bridge, "w", encoding="utf-8") as file:
            file.write(f"#!/bin/sh\nexec {PYTHON} {FAKE_PROCESS} radio_bridge \"$@\"\n")
        os.chmod(bridge, 0o755)
        with open(os.path.join(self.folder, "field.procman"), "w", encoding="utf-8") as file:
            file.write(command("bridge", f"{bridge} --robot 2 --netns ${{COVEY_NETNS}}"))
        done = run_tool(support.IN_NAMESPACE, "--require-private", "--", PYTHON, __file__, "--field", self.folder)
        self.assertEqual((done.returncode, done.stdout), (0, "inside: over the air\noutside: nothing\n"), done.stderr)

    def test_a_killed_holder_is_replaced(self):
        where = "readlink /proc/self/ns/net >> " + self.folder
        told = f"stat -Lc %i $1 >> {self.folder}/a"
        run = self.start_sheet(command("a", f"sh -c '{where}/a; {told}; sleep 100' x ${{COVEY_NETNS}}", RESPAWN)
                               + command("b", f"sh -c '{where}/b; sleep 100'", RESPAWN))
        run.wait_for_event("b      started")
        self.assertTrue(wait_until(lambda: len(self.lines("a") + self.lines("b")) == 3))
        holder = int(re.search(r"private network of process (\d+)", self.read("logs/events.txt")).group(1))
        os.kill(holder, signal.SIGKILL)
        run.wait_for_event("takes its place")
        for pid in re.findall(r"started pid (\d+)", self.read("logs/events.txt")):
            os.kill(int(pid), signal.SIGKILL)
        self.assertTrue(wait_until(lambda: len(self.lines("a") + self.lines("b")) == 6))
        self.assertEqual(self.lines("a")[:2], self.lines("a")[2:])
        self.assertEqual(self.lines("b")[:1], self.lines("b")[1:])

    def lines(self, name):
        return self.read(name).split() if os.path.exists(os.path.join(self.folder, name)) else []

    def test_in_place(self):
        code, out, _ = self.run_sheet(command("a", f"sh -c 'readlink /proc/self/ns/net > {self.folder}/a'")
                                      + command("b", f"sh -c 'echo \"<$1>\" > {self.folder}/b' x \"${{COVEY_NETNS}}\""),
                                      "--namespace", "in-place")
        self.assertEqual(code, 0, out)
        self.assertEqual(self.read("a").strip(), os.readlink("/proc/self/ns/net"))
        self.assertEqual(self.read("b").strip(), "<>")

    def test_the_network_ends_with_the_sheet(self):
        run = self.start_sheet(command("a", "sleep 100"))
        run.wait_for_event("started pid")
        holder = int(re.search(r"private network of process (\d+)", self.read("logs/events.txt")).group(1))
        self.assertTrue(is_alive(holder))
        run.process.kill()  # even so
        run.finish()
        self.assertTrue(wait_until(lambda: not is_alive(holder)))


class Terminal(Folder, unittest.TestCase):
    def test_one_line_per_process(self):
        with open(os.path.join(self.folder, "t.procman"), "w", encoding="utf-8") as file:
            file.write(command("talker", "sh -c 'echo hello; sleep 100'", RESPAWN) + command("other", "sleep 100"))
        child, terminal = pty.fork()
        if child == 0:
            os.environ["TERM"] = "xterm"
            sheet = os.path.join(support.BIN, "sheet")
            os.execv(sheet, [sheet, f"{self.folder}/t.procman", "--logs", f"{self.folder}/logs", "--duration", "1.5"])
        fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 100, 0, 0))
        shown = b""
        while True:
            try:
                shown += os.read(terminal, 65536)
            except OSError:  # the terminal's other side is closed
                break
        os.close(terminal)
        self.assertEqual(os.waitpid(child, 0)[1], 0)
        text = re.sub(r"\x1b\[\d*[mFJ]", "", shown.decode())
        self.assertRegex(text, r"talker  running +\d+ +1 s +1 +\d+ +\d+  hello\r\n")
        self.assertTrue(all(len(line) < 100 for line in text.splitlines()))


def field(folder):
    """A sheet with a bridge: what do a radio message and the bridge's STATUS reach?"""
    with open(f"{folder}/field.procman", encoding="utf-8") as file:
        run = support.SheetRun(folder, file.read(), "--wait-for", "bridge")
    run.wait_for_event("ready")
    with open(f"{folder}/logs/events.txt", encoding="utf-8") as file:
        holder = int(re.search(r"--join (\d+)", file.read()).group(1))
    inner, = namespace.network_of(holder).open_sockets(lambda: [bus.open_bus(*bus.robot_bus(2))])
    inner.setblocking(False)
    outer = bus.open_bus(*bus.robot_bus(2))
    with bus.open_sender() as sender:
        sender.sendto(bus.pack_small("OUT_X", b"over the air"), (bus.RADIO_GROUP, bus.RADIO_PORT))
    phases = []

    def heard():
        phases.extend(status.decode(bus.parse_packet(packet)[1].payload).phase for packet, _ in bus.drain(inner))
        return "over the air" in phases
    print("inside:", "over the air" if wait_until(heard, 5) else phases)
    print("outside:", list(bus.drain(outer)) or "nothing")
    run.interrupt()
    run.finish()


if __name__ == "__main__":
    if sys.argv[1:2] == ["--field"]:
        field(sys.argv[2])
    else:
        unittest.main()
