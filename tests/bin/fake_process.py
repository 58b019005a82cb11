#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Publishes STATUS like a process of Covey's: NAME [--robot R] [--url U] [--after S]; ends at SIGINT."""

import argparse
import time

import support  # noqa: puts bin/ in the path
from covey_tools import bus, status

parser = argparse.ArgumentParser()
parser.add_argument("name")
parser.add_argument("--robot", type=int, default=-1)
parser.add_argument("--url", default="")
parser.add_argument("--after", type=float, default=0.0)
options = parser.parse_args()

address = bus.parse_url(options.url) if options.url else bus.robot_bus(options.robot)
said = status.status_type()()
said.process, said.robot, said.phase = options.name, options.robot, "running"
said.start_utime = int(time.time() * 1e6)
time.sleep(options.after)
number = 0
with bus.open_sender() as sender:
    while True:
        said.utime = int(time.time() * 1e6)
        sender.sendto(bus.pack_small(status.CHANNEL, said.encode(), number), address)
        number += 1
        time.sleep(0.1)
