# SPDX-License-Identifier: BSD-3-Clause
"""A sheet's command made ready to run: arguments, environment, which side of the private network it starts on.

Everything that can be wrong with it is found here, before anything runs.
"""

import os
import shutil
from dataclasses import dataclass

from covey_tools import bus, places
from covey_tools.errors import InputError
from covey_tools.grammar import SheetError
from covey_tools.sheet import Place
from covey_tools.words import WordError, split_exec

NETWORK_VARIABLE = "COVEY_NETNS"  # a command that mentions it starts outside and enters by itself (radio_bridge)


@dataclass
class Launch:
    arguments: list
    environment: dict  # beyond this process's own
    outside: bool = False


def sheet_environment(settings):
    """The variables that sheets may use: this process's, --set NAME=VALUE, and where Covey is."""
    build = places.build_folder()
    environment = dict(os.environ)
    environment.setdefault("COVEY_ROOT", places.ROOT)
    environment.setdefault("COVEY_BUILD", build)
    environment["PATH"] = os.path.join(build, "bin") + os.pathsep + environment.get("PATH", os.defpath)
    for setting in settings:
        name, equals, value = setting.partition("=")
        if not equals or not name.isidentifier():
            raise InputError(f"--set {setting}: expected NAME=VALUE")
        environment[name] = value
    return environment


def prepare(command, environment, netns):
    """The Launch of `command`; `netns` is what ${COVEY_NETNS} stands for ("" in place)."""
    try:
        words = split_exec(command.exec, {**environment, NETWORK_VARIABLE: netns})
    except WordError as error:
        raise SheetError(_place(command, error.offset),
                         f'command "{command.id}": {error}; expected a command line') from None
    if words.missing:
        offset, name = words.missing[0]
        raise SheetError(_place(command, offset), f'command "{command.id}": ${{{name}}} has no value; '
                         f"expected it in the environment or from --set {name}=VALUE")
    own = {name: environment[name] for name in environment if os.environ.get(name) != environment[name]}
    own.update(words.environment)
    if NETWORK_VARIABLE in words.variables:
        own[NETWORK_VARIABLE] = netns
    program = words.arguments[0]
    search = {**environment, **words.environment}.get("PATH", os.defpath)
    found = shutil.which(program, path=search)
    if not found:
        raise SheetError(_place(command, 0), f'command "{command.id}": no program "{program}"; expected one in '
                         + (f"{search.split(os.pathsep)[0]} (bin/build makes it) or the PATH" if "/" not in program else
                            "that place, executable"))
    # A relative path from PATH would depend on where the program looks from.
    return Launch([os.path.abspath(found) if os.sep in found else found, *words.arguments[1:]], own,
                  NETWORK_VARIABLE in words.variables)


def identity(launch):
    """(process, robot, (group, port)): who its STATUS will say it is, and on which bus.

    robot is -1 without --robot; the bus is None where neither --robot nor --url tells it. `nice -n 5 lcd` is lcd.
    """
    arguments = launch.arguments
    if os.path.basename(arguments[0]) == "nice" and arguments[1:2] == ["-n"] and len(arguments) > 3:
        arguments = arguments[3:]
    process, robot, address = os.path.basename(arguments[0]), -1, None
    for index, argument in enumerate(arguments):
        name, equals, value = argument.partition("=")
        value = value if equals else (arguments[index + 1] if index + 1 < len(arguments) else "")
        if name == "--robot" and value.isdigit():
            robot = int(value)
        elif name == "--url" and value.startswith("udpm://"):
            address = bus.parse_url(value)
    return process, robot, address or (bus.robot_bus(robot) if robot >= 0 else None)


def _place(command, offset):
    """Where the exec string's character `offset` stands; exact unless escapes come before it."""
    return Place(command.exec_place.file, command.exec_place.line, command.exec_place.column + 1 + offset)
