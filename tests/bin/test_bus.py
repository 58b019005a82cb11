# SPDX-License-Identifier: BSD-3-Clause
"""LCM's packets and logs in Python: what is read, and that nothing else does harm."""

import os
import random
import struct
import unittest

import support
from covey_tools import bus
from covey_tools.errors import InputError
from covey_tools.lcm_log import Event, Log
from covey_tools.rates import Rates, table
from support import Folder, run_tool

SENDER = ("10.0.0.1", 5)


def fragment(size, offset, index, count, rest):
    return struct.pack(">IIIIHH", 0x4C433033, 7, size, offset, index, count) + rest


def take_all(packets, receiver=None):
    receiver = receiver or bus.Receiver()
    return [message for message in (receiver.take(packet, SENDER) for packet in packets) if message], receiver


class Packets(unittest.TestCase):
    def test_small(self):
        packet = struct.pack(">II", 0x4C433032, 7) + b"STATUS\0payload"
        number, message = bus.parse_packet(packet)
        self.assertEqual((number, message.channel, message.payload), (7, "STATUS", b"payload"))
        self.assertEqual(bus.pack_small("STATUS", b"payload", 7), packet)

    def test_fragments_by_hand(self):
        first, second = fragment(6, 0, 0, 2, b"IMAGE\0abc"), fragment(6, 3, 1, 2, b"def")
        for packets in ([first, second], [second, first], [first, first, second]):
            messages, _ = take_all(packets)
            self.assertEqual([(message.channel, message.payload) for message in messages], [("IMAGE", b"abcdef")])

    def test_large_round_trip(self):
        payload = random.Random(1).randbytes(700000)
        messages, receiver = take_all(bus.pack_fragments("STEREO", payload, 1))
        message, = messages
        self.assertEqual((message.channel, message.payload, message.packets), ("STEREO", payload, 12))
        self.assertEqual((receiver.packets, receiver.refused, receiver.lost), (12, {}, 0))

    def test_a_missing_fragment_loses_that_message_only(self):
        packets = bus.pack_fragments("A", bytes(200000), 1)
        del packets[1]
        messages, receiver = take_all(packets + bus.pack_fragments("B", bytes(100000), 2))
        self.assertEqual([message.channel for message in messages], ["B"])
        self.assertEqual(receiver.refused, {"fragmented message never completed": 1})

    def test_gaps_are_counted_per_sender(self):
        receiver = bus.Receiver()
        for sender, numbers in [("a", [1, 2, 5]), ("b", [100, 101]), ("c", [0xFFFFFFFF, 0]), ("a", [4, 6])]:
            for number in numbers:
                receiver.take(bus.pack_small("C", b"", number), sender)
        self.assertEqual(receiver.lost, 2)

    def test_refusals(self):
        for packet, reason in [
                (b"", "shorter"), (b"LC02", "shorter"), (b"GET / HTTP/1.1", "not LCM"),
                (struct.pack(">II", 0x4C433032, 1) + b"STATUS", "without an end"),
                (struct.pack(">II", 0x4C433032, 1) + b"S" * 64 + b"\0", "without an end"),
                (struct.pack(">II", 0x4C433032, 1) + b"\xff\0", "ASCII"),
                (struct.pack(">IIII", 0x4C433033, 1, 5, 0), "shorter"),
                (fragment(1 << 29, 0, 0, 2, b"C\0a"), "too large"),
                (fragment(10, 0, 2, 2, b"a"), "beyond the count"),
                (fragment(10, 0, 1, 0, b"a"), "beyond the count"),
                (fragment(10, 8, 1, 2, b"abc"), "beyond the message's end"),
                (fragment(1000, 0xFFFFFF00, 1, 2, b"a" * 300), "beyond the message's end")]:
            with self.subTest(packet=packet), self.assertRaisesRegex(ValueError, reason):
                bus.parse_packet(packet)

    def test_fragments_that_do_not_fit_together(self):
        self.assertEqual(take_all([fragment(9, 0, 0, 2, b"C\0abc"), fragment(9, 6, 1, 2, b"def")])[0], [])
        messages, receiver = take_all([fragment(9, 0, 0, 1, b"C\0abc")])
        self.assertEqual((messages, receiver.refused), ([], {"fragments do not add up to the message": 1}))

    def test_random_and_damaged_packets_never_raise_and_never_grow(self):
        generator = random.Random(2)
        receiver = bus.Receiver()
        good = bus.pack_fragments("IMAGE", generator.randbytes(5000), 3, 1000)
        good.append(bus.pack_small("STATUS", b"x" * 50, 4))
        for _ in range(20000):
            if generator.random() < 0.3:
                packet = generator.randbytes(generator.randrange(60))
            else:
                packet = bytearray(generator.choice(good))
                for _ in range(generator.randrange(1, 5)):
                    packet[generator.randrange(min(len(packet), 30))] = generator.randrange(256)
                packet = bytes(packet[:generator.randrange(len(packet) + 1)])
            message = receiver.take(packet, generator.randrange(3))
            if message:
                self.assertLessEqual(len(message.payload), 5000 + 1000)
        self.assertEqual(receiver.packets, 20000)
        self.assertGreater(sum(receiver.refused.values()), 5000)

    def test_unfinished_messages_are_bounded(self):
        receiver = bus.Receiver()
        piece = bytes(60000)
        for sender in range(3000):
            receiver.take(fragment(1 << 20, 0, 1, 20, piece), sender)
        self.assertIn("too many unfinished messages", receiver.refused)


class Urls(unittest.TestCase):
    def test_urls(self):
        self.assertEqual(bus.parse_url("udpm://239.255.76.67:7703?ttl=0&recv_buf_size=4"), ("239.255.76.67", 7703))
        for url in ("7703", "udpm://239.255.76.67", "udpm://10.0.0.1:7703", "udpm://239.255.76.67:70000",
                    "file://x.lcm", "udpm://1.2:3"):
            with self.subTest(url=url), self.assertRaises(InputError):
                bus.parse_url(url)


def event(number, utime, channel, data):
    name = channel.encode()
    return struct.pack(">IqqiI", 0xEDA1DA01, number, utime, len(name), len(data)) + name + data


class Logs(Folder, unittest.TestCase):
    def write(self, data):
        path = os.path.join(self.folder, "x.lcm")
        with open(path, "wb") as file:
            file.write(data)
        return path

    def test_events(self):
        log = Log(self.write(event(0, 10, "A", b"abc") + event(1, 20, "B", b"")))
        self.assertEqual(list(log), [Event(0, 10, "A", b"abc"), Event(1, 20, "B", b"")])
        self.assertEqual(log.skipped_bytes, 0)

    def test_damage_costs_only_the_damaged(self):
        whole = [event(number, number, "A", bytes([number]) * 100) for number in range(5)]
        log = Log(self.write(whole[0] + b"junk" + whole[1] + whole[2][:60] + whole[3] + whole[4][:50]))
        self.assertEqual([each.number for each in log if each.data == bytes([each.number]) * 100], [0, 1, 3])
        self.assertGreater(log.skipped_bytes, 4)

    def test_rates_of_a_log(self):
        events = [event(number, number * 100000, "IMU", bytes(100)) for number in range(11)]
        path = self.write(b"".join(events) + event(11, 1000000, "STATUS", bytes(40)))
        done = run_tool(f"{support.BIN}/rates", "--log", path)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"IMU +11\.0 +1\.10 +100 +0 ms +11\n")
        missing = run_tool(f"{support.BIN}/rates", "--log", path + "x")
        self.assertEqual(missing.returncode, 2)
        self.assertIn("no such file", missing.stderr)


class Table(unittest.TestCase):
    def test_live_rates_forget(self):
        rates = Rates(window_s=5.0)
        rates.start(0.0)
        for tenth in range(100):
            rates.add("A", 10, tenth / 10)
        row, = rates.rows(9.9)
        self.assertAlmostEqual(row.hz, 10.0, delta=0.3)
        row, = rates.rows(30.0)
        self.assertEqual((row.hz, row.count), (0.0, 100))
        self.assertAlmostEqual(row.age_s, 20.1)
        self.assertEqual(len(table([])), 2)


if __name__ == "__main__":
    unittest.main()
