# SPDX-License-Identifier: BSD-3-Clause
"""bin/replay's command line."""

import argparse
import json
import os
import sys
import tempfile

from covey_tools import replay
from covey_tools.errors import InputError

DESCRIPTION = """Runs processes from a log, twice each; says a digest of every output channel and whether both runs agree.

Without --process: every process whose STATUS is in the log, as the robot that it said, but for sources (player, sim)
and radio_bridge, which needs a log of the air too: --process 'radio_bridge --radio-url file://AIR.lcm'.
vio, lcd and mesher need the log of the sensors too: --sensors; without it they are left out, unless named.
Event time is the only clock, so what is published must be the same bytes at the same times; STATUS is left out.
Exit 0: identical (and as stored), 1: not."""


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="replay", description=DESCRIPTION,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("log", metavar="LOG", help="an LCM log of a robot's bus")
    parser.add_argument("--process", action="append", metavar="'NAME [OPTION ...]'", default=[],
                        help="run this one, with options of its own; may be repeated")
    parser.add_argument("--robot", type=int, metavar="R",
                        help="robot of the processes that --process names (default 0); else only this robot's")
    parser.add_argument("--config", metavar="F", help="configuration for all of them")
    parser.add_argument("--sensors", metavar="LOG", help="the LCM log of the robot's sensors")
    parser.add_argument("--store", metavar="F", help="write the digests to this JSON file")
    parser.add_argument("--compare", metavar="F", help="show differences to digests that were stored")
    parser.add_argument("--keep", metavar="DIR", help="keep the output logs here")
    options = parser.parse_args(arguments)
    commands = _commands(options)
    stored = _read_digests(options.compare) if options.compare else None
    shared = ("--config", options.config) if options.config else ()
    found, good = {}, True
    with tempfile.TemporaryDirectory(prefix="covey-replay-") as scratch:
        folder = options.keep or scratch
        os.makedirs(folder, exist_ok=True)
        on_sensor_time = os.path.join(folder, "on-sensor-time.lcm")
        if options.sensors:
            replay.on_sensor_time(options.log, on_sensor_time)
        for command in commands:
            outs = [os.path.join(folder, f"{command.name}-{command.robot}-{number}.lcm") for number in (1, 2)]
            log = on_sensor_time if options.sensors and command.name in replay.SENSOR_OPTIONS else options.log
            arguments = (*shared, *_sensor_arguments(command, options.sensors))
            first, second = (_digests(command, log, out, arguments) for out in outs)
            unlike = replay.differences(first, second)
            found[command.title] = first
            good = good and not unlike
            _print(command, first, unlike)
    if stored is not None:
        good = _compare(stored, found) and good
    if options.store:
        with open(options.store, "w", encoding="utf-8") as file:
            json.dump(found, file, indent=1, sort_keys=True)
    return 0 if good else 1


def _commands(options):
    if options.process:
        return [replay.parse_command(text, options.robot or 0) for text in options.process]
    commands = [command for command in replay.commands_in(options.log) if options.robot in (None, command.robot)]
    blind = [command for command in commands if command.name in replay.SENSOR_OPTIONS and not options.sensors]
    if blind:
        print(f"replay: left out, since there is no --sensors: {', '.join(each.title for each in blind)}", file=sys.stderr)
    commands = [command for command in commands if command not in blind]
    if not commands:
        raise InputError(f"{options.log}: no process says STATUS in this log; name the ones to run with --process")
    return commands


def _sensor_arguments(command, sensors):
    names = replay.SENSOR_OPTIONS.get(command.name, ()) if sensors else ()
    return [word for name in names for word in (name, f"file://{os.path.abspath(sensors)}")]


def _digests(command, log, out, shared):
    replay.run(command, log, out, shared)
    return replay.digests(out)


def _print(command, digests, unlike):
    events = sum(channel["events"] for channel in digests.values())
    verdict = "DIFFERENT in two runs" if unlike else "identical in two runs"
    print(f"{command.title}: {events} events on {len(digests)} channels, {verdict}")
    for channel, digest in digests.items():
        print(f"  {channel:<24} {digest['events']:>8}  {digest['sha256']}")
    for sentence in unlike:
        print(f"  second run: {sentence}")


def _read_digests(path):
    try:
        with open(path, encoding="utf-8") as file:
            return json.load(file)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: {error}; expected a file that bin/replay --store wrote") from None


def _compare(stored, found):
    good = True
    for title in sorted({*stored, *found}):
        sentences = replay.differences(stored.get(title, {}), found.get(title, {}))
        good = good and not sentences
        print(f"{title}: {'not as stored' if sentences else 'as stored'}")
        for sentence in sentences:
            print(f"  {sentence}")
    return good
