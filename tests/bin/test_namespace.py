# SPDX-License-Identifier: BSD-3-Clause
"""Private networks: nothing from a neighbour reaches a private bus, by multicast or unicast; outside it is heard.

Each test's topology, built in a private network H of its own (this file runs itself again inside it):

    neighbour X --- veth --- H (the robot's computer)  ---  no wire  ---  P (the private network, by rung one or two)
"""

import select
import subprocess
import sys
import tempfile
import time
import unittest

import support
from covey_tools import bus, namespace
from covey_tools.errors import Failure
from support import IN_NAMESPACE, PYTHON, run_tool

H_ADDRESS, X_ADDRESS = "10.77.0.1", "10.77.0.2"
PORT = bus.ROBOT_PORT + 3


def run(*arguments):
    return subprocess.run(arguments, check=True, capture_output=True, text=True).stdout


def send(packet, *addresses):
    with bus.open_sender() as sender:
        sender.setsockopt(bus.socket.IPPROTO_IP, bus.socket.IP_MULTICAST_TTL, 1)
        for address in addresses:
            sender.sendto(packet, address)


def heard(source, wait_s):
    """Payloads that arrive within the time, or at least until two are there."""
    found, deadline = [], time.monotonic() + wait_s
    while len(found) < 2 and time.monotonic() < deadline:
        if select.select([source], [], [], max(0.0, deadline - time.monotonic()))[0]:
            found += [bus.parse_packet(packet)[1].payload for packet, _ in bus.drain(source)]
    return sorted(found)


def isolation(rung):
    """Inside H: build the wire and compare what the two listeners hear of the neighbour."""
    neighbour = namespace.hold("private", ("root",))
    private = namespace.hold("private", (rung,))
    run("ip", "link", "add", "v0", "type", "veth", "peer", "name", "v1", "netns", str(neighbour.pid))
    run("ip", "addr", "add", H_ADDRESS + "/24", "dev", "v0")
    run("ip", "link", "set", "v0", "up")
    run("ip", "route", "replace", "224.0.0.0/4", "dev", "v0")
    inside = [IN_NAMESPACE, "--join", str(neighbour.pid), "--"]
    run(*inside, "ip", "addr", "add", X_ADDRESS + "/24", "dev", "v1")
    run(*inside, "ip", "link", "set", "v1", "up")
    run(*inside, "ip", "route", "replace", "224.0.0.0/4", "dev", "v1")

    outer = bus.open_bus(bus.GROUP, PORT)
    inner, = private.open_sockets(lambda: [bus.open_bus(bus.GROUP, PORT)])
    inner.setblocking(False)
    for _ in range(50):  # a veth takes a moment to carry
        run(*inside, PYTHON, __file__, "--send")
        got = heard(outer, 0.2)
        if got == [b"multicast", b"unicast"]:
            break
    assert got == [b"multicast", b"unicast"], f"the listener outside should hear both, it heard {got}"
    assert heard(inner, 0.5) == [], "the private bus heard the neighbour"
    private.open_sockets(lambda: send(bus.pack_small("TEST", b"own"), (bus.GROUP, PORT)) or [])
    assert heard(inner, 0.5) == [b"own"], "the private bus should hear its own"
    assert heard(outer, 0.3) == [], "the private bus was heard outside"
    print("isolated")


class Isolation(unittest.TestCase):
    def check(self, rung):
        done = run_tool(IN_NAMESPACE, "--require-private", "--", PYTHON, __file__, "--isolation", rung)
        self.assertEqual((done.returncode, done.stdout), (0, "isolated\n"), done.stderr)

    def test_rung_one(self):
        self.check("user")

    def test_rung_two(self):
        self.check("root")


class Ladder(unittest.TestCase):
    def run_inside(self, *arguments):
        return run_tool(IN_NAMESPACE, *arguments)

    def test_the_command_takes_over(self):
        self.assertEqual(self.run_inside("--require-private", "--", "sh", "-c", "exit 7").returncode, 7)
        done = self.run_inside("--require-private", "sh", "-c", 'echo "$1"', "sh", "--help")
        self.assertEqual((done.stdout, done.stderr), ("--help\n", ""))

    def test_usage(self):
        self.assertEqual(self.run_inside().returncode, 2)
        done = self.run_inside("--", "/no/such/program")
        self.assertEqual(done.returncode, 2)
        self.assertIn("/no/such/program", done.stderr)

    def test_multicast_works_inside(self):
        done = self.run_inside("--require-private", "--", PYTHON, "-c",
                               f"import sys; sys.path.insert(0, {support.BIN!r})\n"
                               "from covey_tools import net_checks\nprint(net_checks.multicast_error(60000))")
        self.assertEqual(done.stdout, "\n", done.stderr)

    def test_where_no_rung_holds(self):
        # A user namespace may forbid further ones; in there even root gets neither rung.
        forbid = "echo 0 > /proc/sys/user/max_user_namespaces; echo 0 > /proc/sys/user/max_net_namespaces; "
        forbidden = lambda shell: self.run_inside("--rung", "user", "--", "sh", "-c", forbid + shell)
        done = forbidden(f"{IN_NAMESPACE} -- echo done")
        self.assertEqual((done.returncode, done.stdout), (0, "done\n"))
        self.assertIn("no private network (unshare -rn: no more namespaces are allowed; unshare -n: ", done.stderr)
        self.assertIn("this host's network interfaces", done.stderr)
        self.assertNotIn("Multicast does not work", done.stderr)
        done = forbidden(f"ip route del 224.0.0.0/4; {IN_NAMESPACE} -- echo done")
        self.assertIn(f"Multicast does not work here (no such device); type: {namespace.MULTICAST_ROUTE}", done.stderr)
        done = forbidden(f"{IN_NAMESPACE} --require-private -- echo done")
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn("run as root, or allow user namespaces: sysctl", done.stderr)
        with tempfile.TemporaryDirectory() as folder:
            with open(f"{folder}/x.procman", "w", encoding="utf-8") as file:
                file.write('cmd "a" { exec = "true"; deputy = "d"; }')
            sheet = f"{support.BIN}/sheet {folder}/x.procman --logs {folder}"
            done = forbidden(sheet)
            self.assertEqual(done.returncode, 0)
            self.assertIn("warning: no private network", done.stdout)
            done = forbidden(f"{sheet} --namespace private")
            self.assertEqual((done.returncode, done.stdout), (1, ""))
            self.assertIn("sheet: no private network here", done.stderr)

    def test_sockets_come_out_of_a_network(self):
        network = namespace.hold("private")
        self.addCleanup(network.release)
        sockets = network.open_sockets(lambda: [bus.open_bus(bus.GROUP, 7700 + robot) for robot in range(20)])
        self.assertEqual([each.getsockname()[1] for each in sockets], list(range(7700, 7720)))
        for each in sockets:
            each.close()
        with self.assertRaisesRegex(Failure, "Invalid argument"):
            network.open_sockets(lambda: [bus.open_bus("1.2.3.4", PORT)])


if __name__ == "__main__":
    if sys.argv[1:2] == ["--isolation"]:
        isolation(sys.argv[2])
    elif sys.argv[1:2] == ["--send"]:
        send(bus.pack_small("TEST", b"multicast"), (bus.GROUP, PORT))
        send(bus.pack_small("TEST", b"unicast"), (H_ADDRESS, PORT))
    else:
        unittest.main()
