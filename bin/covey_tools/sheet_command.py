# SPDX-License-Identifier: BSD-3-Clause
"""bin/sheet's command line."""

import argparse
import os
import re
import shlex
import sys

from covey_tools import launch, namespace, net_checks, ready
from covey_tools.errors import InputError
from covey_tools.grammar import read_sheet
from covey_tools.loop import Loop
from covey_tools.run import Limits, Run, make_plan
from covey_tools.view import View

DESCRIPTION = """Runs a process sheet on this computer without procman: the same grammar, the same meaning.

The whole sheet is checked before anything starts; a wrong one is refused with file:line:column. Without `start SCRIPT`
every command is started. Ends at Ctrl-C, or when all processes have ended, stopping what runs in reverse order."""

EPILOG = """commands
  exec follows the shell's quoting; leading NAME=VALUE words are its environment; $NAME and ${NAME} come from this
  environment and from --set (${NAME} must have a value). build/<preset>/bin stands first in PATH; ${COVEY_ROOT} is the
  source tree, ${COVEY_BUILD} the build folder. Every command counts, whatever deputy it names.
  auto_respawn: after 10 ms, twice that after each early exit, up to 1 s; never when it was stopped on purpose.
  stop: stop_signal (default 2) to the process group, after stop_time_allowed (default 7 s) SIGKILL to all of it.

networks
  Commands run in a network namespace of their own where the machine allows it (--namespace auto), so that nothing from
  outside reaches their buses; the first line says the process id to look inside with: bin/rates --join PID --robot 0.
  A command that mentions ${COVEY_NETNS} starts outside with the path of that namespace, to enter it by itself
  (radio_bridge --netns, which opens its radio socket first).

waiting
  --wait-for lets "running" mean "publishes STATUS" for those processes, in the script's waits too, and prints `ready`.

exit codes: 0 done (or ended by Ctrl-C), 1 a process failed or was not ready in time, 2 wrong sheet or usage;
with --until-exit the exit code of that command."""


def main(arguments=None):
    options = _parse(arguments)
    sheet = read_sheet(options.file)
    for note in sheet.notes:
        print(f"sheet: note: {note}", file=sys.stderr)
    plan = make_plan(sheet, _script(sheet, options.script))
    environment = launch.sheet_environment(options.set)
    launches = _launches(plan, environment, "/proc/HOLDER/ns/net")
    targets = ready.find_targets(options.wait_for, launches)
    if options.until_exit and options.until_exit not in launches:
        raise InputError(f"--until-exit {options.until_exit}: no such command in what is started; expected one of "
                         + ", ".join(launches))
    if options.dry_run:
        _print_plan(plan, launches)
        return 0
    logs = options.logs or os.path.join("out", "sheet", os.path.splitext(os.path.basename(options.file))[0])
    log_path = _log_paths(logs, plan.commands)

    namespace.adopt_orphans()
    network = namespace.hold(options.namespace)
    loop = Loop()
    view = View(loop, os.path.join(logs, "events.txt"), [command.id for command in plan.commands])
    try:
        _say_where(view, network, options.namespace)
        limits = Limits(options.until_exit, options.duration, options.timeout)
        outcome = Run(loop, sheet, plan, lambda network: _launches(plan, environment, network.path), network, view,
                      log_path, targets, limits).run()
    finally:
        view.close()
        network.release()
    for error in outcome.errors:
        print(f"sheet: {error}", file=sys.stderr)
    return outcome.exit_code


def _parse(arguments):
    parser = argparse.ArgumentParser(prog="sheet", description=DESCRIPTION, epilog=EPILOG,
                                     usage="sheet FILE.procman [start SCRIPT] [--wait-for PROC,...] [options]",
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="FILE.procman", help="the sheet")
    parser.add_argument("script", nargs="*", metavar="start SCRIPT", help="run this script; default: start everything")
    parser.add_argument("--wait-for", default="", metavar="PROC,...",
                        help="command ids, or PROCESS/ROBOT such as dpgo/3: wait until these publish STATUS")
    parser.add_argument("--timeout", type=_positive, default=60.0, metavar="S", help="for --wait-for (default 60)")
    parser.add_argument("--logs", default="", metavar="DIR",
                        help="one log per command and events.txt (default out/sheet/<name of the sheet>)")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE",
                        help="a variable for the commands; repeatable")
    parser.add_argument("--until-exit", default="", metavar="CMD",
                        help="end when this command ends, with its exit code")
    parser.add_argument("--duration", type=_positive, default=0.0, metavar="S", help="end after this time")
    parser.add_argument("--namespace", choices=["auto", "private", "in-place"], default="auto",
                        help="private: fail where no private network can be had (default auto)")
    parser.add_argument("--dry-run", action="store_true", help="check, print what would run, start nothing")
    options = parser.parse_intermixed_args(arguments)
    options.wait_for = [name for name in options.wait_for.split(",") if name]
    return options


def _positive(text):
    value = float(text)
    if not 0 < value < 1e9:
        raise argparse.ArgumentTypeError(f"{text} is not a positive number of seconds")
    return value


def _script(sheet, words):
    if not words:
        return ""
    if words[0] != "start" or len(words) != 2:
        raise InputError(f"'{' '.join(words)}' after the sheet; expected: start SCRIPT")
    if words[1] not in sheet.scripts:
        names = ", ".join(f'"{name}"' for name in sheet.scripts) or "none: the sheet has none"
        raise InputError(f'{sheet.file}: no script "{words[1]}"; expected one of {names}')
    return words[1]


def _launches(plan, environment, netns):
    return {command.id: launch.prepare(command, environment, netns) for command in plan.commands}


def _log_paths(folder, commands):
    """Command -> path of its log, emptied, in an existing folder."""
    paths, taken = {}, {"events"}
    for command in commands:
        stem = name = re.sub(r"[^\w.-]", "_", command.id)
        count = 1
        while name in taken:
            count += 1
            name = f"{stem}-{count}"
        taken.add(name)
        paths[command.id] = os.path.join(folder, f"{name}.log")
    try:
        os.makedirs(folder, exist_ok=True)
        for path in paths.values():
            open(path, "wb").close()
    except OSError as error:
        raise InputError(f"--logs {folder}: {error.strerror.lower()}; expected a folder to write in") from None
    return lambda command: paths[command.id]


def _print_plan(plan, launches):
    for action in plan.actions:
        print(f"# {action}")
    for command in plan.commands:
        ready_launch = launches[command.id]
        own = [f"{name}={shlex.quote(value)}" for name, value in ready_launch.environment.items()
               if name not in ("PATH", "COVEY_ROOT", "COVEY_BUILD")]
        side = " (starts outside the private network)" if ready_launch.outside else ""
        group = f"{command.group}/" if command.group else ""
        print(f"{group}{command.id}{side}: {' '.join([*own, shlex.join(ready_launch.arguments)])}")


def _say_where(view, network, mode):
    if network.pid is not None:
        view.event("sheet", f"private network of process {network.pid}; "
                            f"look inside: bin/rates --join {network.pid} --robot 0")
    elif mode == "in-place":
        view.event("sheet", "in place: the buses are in this network")
    else:
        view.event("sheet", f"warning: {net_checks.in_place_warning(network.reasons)}")
