# SPDX-License-Identifier: BSD-3-Clause
"""bin/check_net and bin/rates on a real (private) network."""

import json
import re
import unittest

from support import BIN, FAKE_PROCESS, IN_NAMESPACE, PYTHON, Folder, run_tool


def inside(shell, *options):
    """Run a shell line in a private network."""
    return run_tool(IN_NAMESPACE, "--require-private", *options, "--", "sh", "-c", shell)


class CheckNet(unittest.TestCase):
    def findings(self, shell, *options):
        done = inside(f"{shell} {BIN}/check_net --json", *options)
        answer = json.loads(done.stdout)
        self.assertEqual(done.returncode, 0 if answer["ok"] else 1)
        return {finding["name"]: finding for finding in answer["findings"]}

    def test_a_private_network_is_well_but_for_what_the_kernel_caps(self):
        findings = self.findings("")
        for name in ("loopback", "route", "multicast", "ports"):
            self.assertEqual(findings[name]["level"], "ok", findings[name])
        self.assertIn(findings["buffers"]["level"], ("ok", "problem"))

    def test_loopback_down(self):
        finding = self.findings("ip link set lo down;")["loopback"]
        self.assertEqual((finding["level"], finding["fix"]), ("problem", "ip link set lo up"))

    def test_no_route(self):
        findings = self.findings("ip route del 224.0.0.0/4;")
        self.assertEqual(findings["route"]["level"], "problem")
        self.assertIn("ip route add 224.0.0.0/4 dev lo", findings["route"]["fix"])
        self.assertEqual(findings["multicast"]["level"], "problem")
        self.assertIn("does not come back", findings["multicast"]["text"])

    def test_fix(self):
        done = inside(f"ip route del 224.0.0.0/4; {BIN}/check_net --fix")
        self.assertIn("ok       multicast", done.stdout)

    def test_somebody_on_our_ports(self):
        listen = ("import socket, subprocess, sys; s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM); "
                  "s.bind(('', 7703)); sys.exit(subprocess.run(sys.argv[1:]).returncode)")
        finding = self.findings(f'{PYTHON} -c "{listen}"')["ports"]
        self.assertEqual(finding["level"], "problem")
        self.assertRegex(finding["text"], r"port 7703 \(a robot's bus\) is open in python3 \(process \d+\)")


class Rates(Folder, unittest.TestCase):
    def test_a_bus(self):
        done = inside(f"{PYTHON} {FAKE_PROCESS} dpgo --robot 2 & sleep 0.5; "
                      f"{BIN}/rates --here --robot 2 --seconds 2; kill $!")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("udpm://239.255.76.67:7702\n", done.stdout)
        hz, kb_per_s = map(float, re.search(r"STATUS +([\d.]+) +([\d.]+)", done.stdout).groups())
        self.assertTrue(2 < hz < 12 and 0.1 < kb_per_s < 2, done.stdout)
        self.assertIn("0 messages lost\n", done.stdout)

    def test_inside_a_running_sheet(self):
        run = self.start_sheet(f'cmd "a" {{ exec = "{PYTHON} {FAKE_PROCESS} dpgo --robot 4"; deputy = "d"; }}')
        run.wait_for_event("started pid")
        holder = re.search(r"--join (\d+)", self.read("logs/events.txt")).group(1)
        done = run_tool(f"{BIN}/rates", "--join", holder, "--robot", "4", "--seconds", "2")
        self.assertIn("STATUS", done.stdout, done.stderr)
        silent = run_tool(f"{BIN}/rates", "--here", "--robot", "4", "--seconds", "0.3")
        self.assertNotIn("STATUS", silent.stdout)

    def test_usage(self):
        for arguments in (["--url", "7700"], ["--robot", "99"], ["--robot", "1", "--radio"], ["--seconds", "0"]):
            done = run_tool(f"{BIN}/rates", *arguments)
            self.assertEqual((done.returncode, done.stdout), (2, ""), arguments)


if __name__ == "__main__":
    unittest.main()
