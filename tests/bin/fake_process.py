#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Publishes STATUS like a process of Covey's: NAME [--robot R] [--url U] [--after S] [--netns PATH] ; ends at SIGINT.

With --netns like radio_bridge in the field: opens a radio socket where it was started, enters the network at PATH and
says there, as its phase, what it hears on the radio.
"""

import argparse
import time

import support  # noqa: puts bin/ in the path
from covey_tools import bus, namespace, status

parser = argparse.ArgumentParser()
parser.add_argument("name")
parser.add_argument("--robot", type=int, default=-1)
parser.add_argument("--url", default="")
parser.add_argument("--after", type=float, default=0.0)
parser.add_argument("--netns", default="")
options = parser.parse_args()

address = bus.parse_url(options.url) if options.url else bus.robot_bus(options.robot)
said = status.status_type()()
said.process, said.robot, said.phase = options.name, options.robot, "running"
said.start_utime = int(time.time() * 1e6)
time.sleep(options.after)
radio = None
if options.netns:
    radio = bus.open_bus(bus.RADIO_GROUP, bus.RADIO_PORT)
    namespace.join_network_of(int(options.netns.split("/")[2]))
number = 0
with bus.open_sender() as sender:
    while True:
        for packet, _ in bus.drain(radio) if radio else ():
            said.phase = bus.parse_packet(packet)[1].payload.decode()
        said.utime = int(time.time() * 1e6)
        sender.sendto(bus.pack_small(status.CHANNEL, said.encode(), number), address)
        number += 1
        time.sleep(0.1)
