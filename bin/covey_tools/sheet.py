# SPDX-License-Identifier: BSD-3-Clause
"""A process sheet: the commands, their groups, and the scripts that start and stop them.

Plain data, as procman's sheriff knows it. grammar.py reads it from a file. A command's group is its path from the
root ("team/robot0"; "" at the root); naming a group means its subgroups too.
"""

from dataclasses import dataclass, field

DEFAULT_STOP_SIGNAL = 2
DEFAULT_STOP_TIME_ALLOWED_S = 7


@dataclass(frozen=True)
class Place:
    """Where in a sheet something stands; line and column count from 1."""

    file: str
    line: int
    column: int

    def __str__(self):
        return f"{self.file}:{self.line}:{self.column}"


@dataclass
class Command:
    id: str
    group: str
    exec: str
    place: Place
    exec_place: Place
    deputy: str = ""
    auto_respawn: bool = False
    stop_signal: int = DEFAULT_STOP_SIGNAL
    stop_time_allowed_s: int = DEFAULT_STOP_TIME_ALLOWED_S


@dataclass
class Action:
    """One step of a script.

    kind        start | stop | restart | wait | wait_ms | run_script
    target      everything | cmd | group (start, stop, restart, wait)
    name        of the command, the group or the other script
    status      running | stopped: the state to wait for, or "" to go on at once
    """

    kind: str
    place: Place
    target: str = ""
    name: str = ""
    status: str = ""
    delay_ms: int = 0

    def __str__(self):
        if self.kind == "wait_ms":
            return f"wait ms {self.delay_ms}"
        if self.kind == "run_script":
            return f'run_script "{self.name}"'
        target = self.target if self.target == "everything" else f'{self.target} "{self.name}"'
        if self.kind == "wait":
            return f'wait {target} status "{self.status}"'
        return f"{self.kind} {target}" + (f' wait "{self.status}"' if self.status else "")


@dataclass
class Script:
    name: str
    place: Place
    actions: list = field(default_factory=list)


@dataclass
class Sheet:
    file: str
    commands: list = field(default_factory=list)  # in the file's order
    groups: set = field(default_factory=set)
    scripts: dict = field(default_factory=dict)
    notes: list = field(default_factory=list)  # sentences: accepted here, but the sheriff would mind

    def command(self, command_id):
        """The command of that id, or None."""
        return next((command for command in self.commands if command.id == command_id), None)

    def select(self, target, name=""):
        """The commands that an action means, in the file's order."""
        if target == "everything":
            return list(self.commands)
        if target == "cmd":
            return [command for command in self.commands if command.id == name]
        group = normalize_group(name)
        return [command for command in self.commands
                if command.group == group or command.group.startswith(group + "/")]

    def flatten(self, script_name):
        """A script's actions with every run_script replaced by what it runs."""
        actions = []
        for action in self.scripts[script_name].actions:
            actions += self.flatten(action.name) if action.kind == "run_script" else [action]
        return actions


def normalize_group(name):
    """"/a//b/" and "a/b" name the same group."""
    return "/".join(part for part in name.split("/") if part)
