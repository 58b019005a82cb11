# SPDX-License-Identifier: BSD-3-Clause
"""bin/check_net's command line."""

import argparse
import json
import os
import subprocess
import sys

from covey_tools import net_checks
from covey_tools.errors import InputError

DESCRIPTION = """Says what is wrong with multicast, routes or buffers on this host, and prints the fix for each.

Exit 0 when all is well (notes included), 1 when there is a problem. To check a sheet's own network:
bin/covey_tools/in_namespace -- bin/check_net"""


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="check_net", description=DESCRIPTION,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="the findings as JSON")
    parser.add_argument("--fix", action="store_true",
                        help="as root: run the fixes of the problems found in network settings, check again")
    options = parser.parse_args(arguments)
    findings = net_checks.all_findings()
    if options.fix:
        findings = _fix(findings)
    if options.json:
        answer = {"ok": not _problems(findings), "findings": [vars(finding) for finding in findings]}
        print(json.dumps(answer, indent=2))
    else:
        for finding in findings:
            print(f"{finding.level:8} {finding.name}: {finding.text}")
            if finding.fix and finding.level != "ok":
                print(f"{'':8} fix: {finding.fix}")
    return 1 if _problems(findings) else 0


def _problems(findings):
    return [finding for finding in findings if finding.level == "problem"]


def _fix(findings):
    if os.geteuid() != 0:
        raise InputError("--fix changes this host's network; run it as root")
    for finding in _problems(findings):
        if finding.fix and finding.name != "ports":  # never kill somebody's process
            print(f"check_net: {finding.fix}", file=sys.stderr)
            subprocess.run(finding.fix, shell=True, check=False)
    return net_checks.all_findings()
