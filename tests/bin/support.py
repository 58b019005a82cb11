# SPDX-License-Identifier: BSD-3-Clause
"""What the tests of bin/ share: where things are, running a sheet, a process that publishes STATUS."""

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
BIN = os.path.join(ROOT, "bin")
IN_NAMESPACE = os.path.join(BIN, "covey_tools", "in_namespace")
PYTHON = "/usr/bin/python3"
sys.path.insert(0, BIN)
sys.dont_write_bytecode = True
os.environ["PATH"] = os.environ.get("PATH", os.defpath) + ":/usr/sbin:/sbin"  # ip, for an ordinary user

# dpgo, as far as a sheet can see: `fake_process NAME --robot R [--after S] [--url U]` publishes STATUS at 10 Hz.
FAKE_PROCESS = os.path.join(ROOT, "tests", "bin", "fake_process.py")


def run_tool(*command):
    """A finished command, its output as text."""
    return subprocess.run(command, capture_output=True, text=True, check=False)


class SheetRun:
    """A running bin/sheet in a folder of its own."""

    def __init__(self, folder, text, *arguments, environment=None):
        self.folder = folder
        self.file = os.path.join(folder, "test.procman")
        with open(self.file, "w", encoding="utf-8") as file:
            file.write(text)
        with contextlib.suppress(FileNotFoundError):
            os.remove(os.path.join(folder, "logs", "events.txt"))  # of a run before
        self.process = subprocess.Popen(
            [os.path.join(BIN, "sheet"), self.file, "--logs", os.path.join(folder, "logs"), *arguments], text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, env={**os.environ, **(environment or {})})

    def finish(self, timeout_s=30):
        """(exit code, stdout, stderr) at its end."""
        try:
            out, err = self.process.communicate(timeout=timeout_s)
        except subprocess.TimeoutExpired:
            self.process.kill()
            out, err = self.process.communicate()
            raise AssertionError(f"the sheet did not end in {timeout_s} s:\n{out}\n{err}") from None
        return self.process.returncode, out, err

    def wait_for_event(self, text, timeout_s=20):
        """Until a line with `text` stands among the events."""
        path = os.path.join(self.folder, "logs", "events.txt")
        for _ in range(int(timeout_s / 0.02)):
            with contextlib.suppress(FileNotFoundError), open(path, encoding="utf-8") as file:
                if text in file.read():
                    return
            if self.process.poll() is not None:
                break
            time.sleep(0.02)
        raise AssertionError(f"no event with '{text}': {self.finish(1)}")

    def interrupt(self, number=signal.SIGINT):
        self.process.send_signal(number)


class Folder:
    """Mixin: self.folder, gone after the test."""

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="covey-test-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def read(self, name):
        with open(os.path.join(self.folder, name), encoding="utf-8") as file:
            return file.read()

    def start_sheet(self, text, *arguments, **options):
        run = SheetRun(self.folder, text, *arguments, **options)

        def end():
            if run.process.poll() is None:
                run.interrupt()
                run.finish()
            for stream in (run.process.stdout, run.process.stderr):
                stream.close()
        self.addCleanup(end)
        return run

    def run_sheet(self, text, *arguments, **options):
        return self.start_sheet(text, *arguments, **options).finish()


def is_alive(pid):
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def wait_until(condition, timeout_s=10):
    """Whether the condition came true in time."""
    for _ in range(int(timeout_s / 0.02)):
        if condition():
            return True
        time.sleep(0.02)
    return False
