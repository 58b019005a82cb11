# SPDX-License-Identifier: BSD-3-Clause
"""A process run from a log, and digests of what it published.

A digest is SHA-256 over a channel's events in order: event time (int64, big endian), number of bytes (int64), bytes.
STATUS is left out: it says memory and latencies, which differ from run to run. Beside it stand the first 32 bits of each
event's own digest, so that a difference can be placed.
"""

import hashlib
import os
import shlex
import struct
import subprocess
from dataclasses import dataclass

from covey_tools import messages, places, status
from covey_tools.errors import Failure, InputError
from covey_tools.lcm_log import Log, Writer

# Left out unless named: sources read data sets and not a bus, and radio_bridge needs a log of the air too.
NOT_BY_THEMSELVES = {"player", "sim", "radio_bridge"}
# Options for the log of the sensors, which a log of the robot's bus does not have.
SENSOR_OPTIONS = {"vio": ("--sensor-url",), "lcd": ("--sensor-url",), "mesher": ("--depth-url",)}
_HEAD = struct.Struct(">qq")
_SHORT = 8  # hexadecimal digits of an event's own digest


@dataclass(frozen=True)
class Command:
    """A process to run: its name, its robot and further arguments."""

    name: str
    robot: int
    arguments: tuple = ()

    @property
    def title(self):
        return f"{self.name}[{self.robot}]"


def parse_command(text, robot):
    """The process of "dpgo" or "dpgo --config robot.yaml"."""
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise InputError(f"--process {text!r}: {str(error).lower()}") from None
    if not words:
        raise InputError("--process: expected a name, and the process's own options after it if need be")
    return Command(words[0], robot, tuple(words[1:]))


def commands_in(log_path):
    """The processes whose STATUS is in the log, by name."""
    found = set()
    for event in Log(log_path):
        if event.channel == status.CHANNEL:
            message = status.decode(event.data)
            if message and message.process not in NOT_BY_THEMSELVES and message.robot >= 0:
                found.add(Command(message.process, message.robot))
    return sorted(found, key=lambda command: (command.robot, command.name))


def on_sensor_time(log_path, out_path):
    """Writes the log of a robot's bus anew with its events at the time of the sensors' log.

    A bus is logged by the wall clock, sensors by the time of measurement; two logs are read in order of time. STATE,
    which is said at once, tells the one from the other: events move by the smallest lead that any STATE has.
    """
    stamps = [(event.utime, state.utime) for event in Log(log_path) if event.channel == "STATE"
              for state in [messages.decode("state_t", event.data)] if state]
    if len(stamps) < 2 or stamps[-1][1] <= stamps[0][1]:
        raise InputError(f"{log_path}: has no STATE of vio, so its time cannot be told from the sensors'")
    (wall_0, utime_0), (wall_1, utime_1) = stamps[0], stamps[-1]
    speed = (utime_1 - utime_0) / (wall_1 - wall_0)
    lead = min((wall - wall_0) * speed - (utime - utime_0) for wall, utime in stamps)
    out = Writer(out_path)
    for event in Log(log_path):
        out.write(event.channel, event.data, max(0, int((event.utime - wall_0) * speed - lead) + utime_0))
    out.close()


def run(command, log_path, out_path, options=()):
    """Run the process from the log; what it published is in out_path afterwards."""
    program = os.path.join(places.build_folder(), "bin", command.name)
    if not os.access(program, os.X_OK):
        raise InputError(f"{command.name}: {program} is missing; run bin/build first, or name processes with --process")
    arguments = ["--robot", str(command.robot), "--url", f"file://{log_path}", "--out", out_path]
    done = subprocess.run([program, *arguments, *options, *command.arguments], text=True, check=False,
                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    if done.returncode == 2:
        said = done.stderr.strip().splitlines()
        raise InputError(said[-1] if said else f"{command.title} refused its input")
    if done.returncode != 0:
        raise Failure(f"{command.title} ended with {done.returncode} on {log_path}:\n{done.stderr.strip()}")


def digests(out_path):
    """{channel: {"events", "sha256", "short"}} of a log."""
    whole, short = {}, {}
    for event in Log(out_path):
        if event.channel == status.CHANNEL:
            continue
        bytes_in_order = _HEAD.pack(event.utime, len(event.data)) + event.data
        whole.setdefault(event.channel, hashlib.sha256()).update(bytes_in_order)
        short.setdefault(event.channel, []).append(hashlib.sha256(bytes_in_order).hexdigest()[:_SHORT])
    return {channel: {"events": len(short[channel]), "sha256": whole[channel].hexdigest(),
                      "short": "".join(short[channel])}
            for channel in sorted(whole)}


def differences(expected, found):
    """Sentences, one for each channel that differs; empty where both are the same."""
    sentences = []
    for channel in sorted({*expected, *found}):
        if channel not in found:
            sentences.append(f"{channel}: nothing, where there were {expected[channel]['events']} events")
        elif channel not in expected:
            sentences.append(f"{channel}: {found[channel]['events']} events, where there was nothing")
        elif expected[channel]["sha256"] != found[channel]["sha256"]:
            before, now = expected[channel], found[channel]
            sentences.append(f"{channel}: differs from event {_first_difference(before, now)} on "
                             f"({before['events']} events before, {now['events']} now)")
    return sentences


def _first_difference(before, now):
    common = min(before["events"], now["events"])
    parts = (slice(_SHORT * i, _SHORT * (i + 1)) for i in range(common))
    return next((i for i, part in enumerate(parts) if before["short"][part] != now["short"][part]), common)
