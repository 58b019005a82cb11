# SPDX-License-Identifier: BSD-3-Clause
"""bin/rates's command line."""

import argparse
import shutil
import signal
import sys

from covey_tools import bus, namespace
from covey_tools.errors import Failure, InputError
from covey_tools.lcm_log import Log
from covey_tools.loop import Loop
from covey_tools.rates import WINDOW_S, Rates, table

DESCRIPTION = """What flows on a bus or in a log: channels, Hz, kB/s, mean size, age of the newest message.

Live on a terminal (means over 5 s, until Ctrl-C); a plain table after --seconds, or for a log.
Where one sheet is running in a private network, looks inside that one; with several, --join says which."""


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="rates", description=DESCRIPTION,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--robot", type=int, metavar="R", help="the private bus of this robot (default 0)")
    where.add_argument("--url", metavar="U", help="any bus, udpm://GROUP:PORT")
    where.add_argument("--radio", action="store_true", help="the radio's bus")
    where.add_argument("--log", metavar="F.lcm", help="a log instead of a bus")
    parser.add_argument("--seconds", type=float, metavar="S", help="listen this long, print one table")
    parser.add_argument("--join", type=int, metavar="PID",
                        help="look inside the private network of this process (bin/sheet says it)")
    parser.add_argument("--here", action="store_true",
                        help="look at this network, even when a sheet runs in a private one")
    options = parser.parse_args(arguments)
    if options.seconds is not None and not 0 < options.seconds < 1e6:
        raise InputError(f"--seconds {options.seconds}: expected a positive number")
    if options.robot is not None and not 0 <= options.robot < 20:
        raise InputError(f"--robot {options.robot}: expected 0 to 19")
    if options.log:
        return _read_log(options.log)
    address = (bus.parse_url(options.url) if options.url else (bus.RADIO_GROUP, bus.RADIO_PORT) if options.radio
               else bus.robot_bus(options.robot or 0))
    where = _enter(options)
    try:
        source = bus.open_bus(*address)
    except OSError as error:
        raise Failure(f"cannot listen on {address[0]}:{address[1]}: {error.strerror.lower()}; "
                      "bin/check_net says more") from None
    return _listen(source, f"udpm://{address[0]}:{address[1]}{where}", options.seconds)


def _enter(options):
    holders = [] if options.here else namespace.holders()
    pid = options.join
    if pid is None and len(holders) > 1:
        raise InputError("several sheets run in private networks; say "
                         f"--join {' or --join '.join(map(str, holders))}, or --here")
    if pid is None and holders:
        pid = holders[0]
    if pid is None:
        return ""
    namespace.join_network_of(pid)
    return f" in the private network of process {pid}"


def _read_log(path):
    log, rates, now_s = Log(path), Rates(), 0.0
    for event in log:
        now_s = event.utime * 1e-6
        rates.add(event.channel, len(event.data), now_s)
    print("\n".join(table(rates.rows(now_s))))
    if log.skipped_bytes:
        print(f"{log.skipped_bytes:,} bytes of {path} are no events (torn or damaged)")
    return 0


def _listen(source, title, seconds):
    loop, receiver = Loop(), bus.Receiver()
    live = seconds is None and sys.stdout.isatty()
    rates = Rates(None if seconds else WINDOW_S)
    start = loop.now()
    rates.start(start)

    def read():
        now = loop.now()
        for packet, sender in bus.drain(source):
            message = receiver.take(packet, sender)
            if message:
                rates.add(message.channel, len(message.payload), now)

    def summary():
        refused = "".join(f", {count:,} refused: {reason}" for reason, count in sorted(receiver.refused.items()))
        return f"{receiver.packets:,} packets in {loop.now() - start:.1f} s, {receiver.lost:,} messages lost{refused}"

    def draw():
        columns, rows = shutil.get_terminal_size()
        lines = [title, *table(rates.rows(loop.now()))][:rows - 2] + [summary()]
        sys.stdout.write("\033[H\033[J" + "\n".join(line[:columns - 1] for line in lines) + "\n")
        sys.stdout.flush()
        loop.after(1.0, draw)

    def print_table():
        print("\n".join([title, *table(rates.rows(loop.now())), summary()]), flush=True)

    def every_five():
        print_table()
        loop.after(WINDOW_S, every_five)

    loop.on_readable(source, read)
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.on_signal(number, loop.stop)
    if seconds:
        loop.after(seconds, loop.stop)
    else:
        loop.after(0 if live else WINDOW_S, draw if live else every_five)
    loop.run()
    if seconds:
        print_table()
    return 0
