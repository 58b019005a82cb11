# SPDX-License-Identifier: BSD-3-Clause
"""A bus seen from outside: LCM's UDP packets, read and written without liblcm.

A message of up to 1400 bytes or so is one packet, a larger one is cut into fragments (big endian throughout):

    small     u32 0x4c433032 "LC02", u32 number, channel, 0, payload
    fragment  u32 0x4c433033 "LC03", u32 number, u32 message size, u32 offset, u16 fragment, u16 fragments, then the
              payload's bytes from `offset`; fragment 0 has "channel, 0" before them

Whatever else arrives is refused with a reason: nothing that a packet says is believed before it is checked.
Format: LCM's udp-multicast-protocol; sizes and limits of liblcm 1.3.1 (reference: its lcm_udpm.c).
"""

import re
import socket
import struct
from dataclasses import dataclass, field

from covey_tools.errors import InputError

GROUP = "239.255.76.67"
RADIO_GROUP = "239.255.76.68"
ROBOT_PORT = 7700  # + robot
STEREO_PORT = 7720  # + robot
DEPTH_PORT = 7740  # + robot
RADIO_PORT = 7800
RECEIVE_BUFFER_BYTES = 4 << 20

MAX_CHANNEL_BYTES = 63
MAX_MESSAGE_BYTES = 1 << 28
MAX_PENDING_BYTES = 64 << 20  # of unfinished fragmented messages

_SMALL = 0x4C433032
_FRAGMENT = 0x4C433033


@dataclass
class Message:
    channel: str
    payload: bytes
    packets: int = 1
    wire_bytes: int = 0  # UDP payload, headers included


@dataclass
class Fragment:
    size: int
    offset: int
    number: int
    count: int
    channel: str  # "" but in fragment 0
    payload: bytes
    wire_bytes: int


def parse_url(url):
    """"udpm://group:port?ttl=0" -> (group, port)."""
    match = re.fullmatch(r"udpm://([0-9.]+):([0-9]+)(\?.*)?", url)
    if not match or not 0 < int(match.group(2)) < 65536:
        raise InputError(f"{url} is no bus; expected udpm://GROUP:PORT, such as udpm://{GROUP}:{ROBOT_PORT}")
    try:
        is_multicast = 224 <= socket.inet_aton(match.group(1))[0] < 240
    except OSError:
        is_multicast = False
    if not is_multicast:
        raise InputError(f"{url}: {match.group(1)} is no multicast group; expected an address such as {GROUP}")
    return match.group(1), int(match.group(2))


def robot_bus(robot):
    """(group, port) of a robot's private bus."""
    return GROUP, ROBOT_PORT + robot


def open_bus(group, port, buffer_bytes=RECEIVE_BUFFER_BYTES):
    """A non-blocking socket that hears what liblcm hears on that port (like liblcm's, it binds every interface)."""
    bus = socket.socket(socket.AF_INET, socket.SOCK_DGRAM | socket.SOCK_NONBLOCK)
    try:
        bus.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        bus.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer_bytes)
        bus.bind(("", port))
        any_interface = socket.inet_aton("0.0.0.0")
        bus.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(group) + any_interface)
    except OSError:
        bus.close()
        raise
    return bus


def open_sender():
    """A socket whose multicasts stay on this host."""
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
    sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
    return sender


def pack_small(channel, payload, number=0):
    """The packet of one small message."""
    return struct.pack(">II", _SMALL, number) + channel.encode() + b"\0" + payload


def pack_fragments(channel, payload, number=0, fragment_bytes=60000):
    """The packets of one large message."""
    head = channel.encode() + b"\0"
    stream = head + payload
    pieces = [stream[at:at + fragment_bytes] for at in range(0, len(stream), fragment_bytes)]
    packets, offset = [], 0
    for index, piece in enumerate(pieces):
        packets.append(struct.pack(">IIIIHH", _FRAGMENT, number, len(payload), offset, index, len(pieces)) + piece)
        offset += len(piece) - (len(head) if index == 0 else 0)
    return packets


def parse_packet(data):
    """(number, Message or Fragment) of one packet; ValueError with the reason when it is not one."""
    if len(data) < 8:
        raise ValueError("shorter than a header")
    magic, number = struct.unpack_from(">II", data)
    if magic == _SMALL:
        channel, at = _channel(data, 8)
        return number, Message(channel, data[at:], 1, len(data))
    if magic != _FRAGMENT:
        raise ValueError("not LCM")
    if len(data) < 20:
        raise ValueError("shorter than a fragment's header")
    size, offset, index, count = struct.unpack_from(">IIHH", data, 8)
    channel, at = _channel(data, 20) if index == 0 else ("", 20)
    if size > MAX_MESSAGE_BYTES:
        raise ValueError("message too large")
    if index >= count:
        raise ValueError("fragment number beyond the count")
    if offset + len(data) - at > size:
        raise ValueError("fragment beyond the message's end")
    return number, Fragment(size, offset, index, count, channel, data[at:], len(data))


def _channel(data, start):
    end = data.find(b"\0", start, start + MAX_CHANNEL_BYTES + 1)
    if end < 0:
        raise ValueError("channel name without an end")
    try:
        return data[start:end].decode("ascii"), end + 1
    except UnicodeDecodeError:
        raise ValueError("channel name is not ASCII") from None


@dataclass
class _Pending:
    size: int
    count: int
    channel: str = ""
    parts: dict = field(default_factory=dict)  # fragment number -> (offset, bytes)
    wire_bytes: int = 0


class Receiver:
    """Packets in, messages out, with counts of what was refused and of numbers that never came.

    One message per sender is put together at a time, as a sender sends its fragments one after the other.
    """

    def __init__(self):
        self.packets = 0
        self.refused = {}  # reason -> count
        self.lost = 0  # messages, from gaps in each sender's numbers
        self._last = {}  # sender -> newest number
        self._pending = {}  # sender -> (number, _Pending)

    def take(self, data, sender):
        """The Message that this packet completes, or None."""
        self.packets += 1
        try:
            number, part = parse_packet(data)
        except ValueError as error:
            self._refuse(str(error))
            return None
        self._count_gap(sender, number)
        if isinstance(part, Message):
            return part
        return self._assemble(sender, number, part)

    def _refuse(self, reason):
        self.refused[reason] = self.refused.get(reason, 0) + 1

    def _count_gap(self, sender, number):
        last = self._last.get(sender)
        if last is not None:
            step = (number - last) & 0xFFFFFFFF
            if 1 < step < 1 << 16:
                self.lost += step - 1
            elif step >= 1 << 16:  # out of order, or another process got this sender's port
                return
        self._last[sender] = number

    def _assemble(self, sender, number, part):
        old_number, pending = self._pending.get(sender, (None, None))
        if old_number != number or (pending.size, pending.count) != (part.size, part.count):
            if pending:
                self._refuse("fragmented message never completed")
            held = sum(each.wire_bytes for _, each in self._pending.values())
            if held + len(part.payload) > MAX_PENDING_BYTES:
                self._pending.clear()
                self._refuse("too many unfinished messages")
            pending = _Pending(part.size, part.count)
            self._pending[sender] = (number, pending)
        pending.wire_bytes += part.wire_bytes if part.number not in pending.parts else 0
        pending.parts[part.number] = (part.offset, part.payload)
        pending.channel = part.channel or pending.channel
        if len(pending.parts) < part.count:
            return None
        del self._pending[sender]
        payload = bytearray()
        for index in range(part.count):
            offset, piece = pending.parts[index]
            if offset != len(payload):
                self._refuse("fragments overlap or leave a hole")
                return None
            payload += piece
        if len(payload) != part.size:
            self._refuse("fragments do not add up to the message")
            return None
        return Message(pending.channel, bytes(payload), part.count, pending.wire_bytes)


def drain(bus, limit=1000):
    """Yield (packet, sender) of what waits on a non-blocking socket, up to `limit`."""
    for _ in range(limit):
        try:
            yield bus.recvfrom(65536)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            return  # an ICMP error of some other packet
