# SPDX-License-Identifier: BSD-3-Clause
"""Who has published STATUS yet: a process that runs is not yet subscribed, so "running" is too early to feed it."""

from dataclasses import dataclass

from covey_tools import bus, launch, status
from covey_tools.errors import InputError


@dataclass
class Target:
    label: str  # as the user wrote it
    process: str
    robot: int
    address: tuple  # (group, port) of the bus it speaks on
    command_id: str = ""  # of the sheet, where there is one
    heard: bool = False

    def __str__(self):
        group, port = self.address
        return f"{self.label} ({self.process} of robot {self.robot} on udpm://{group}:{port})"


def find_targets(names, launches):
    """The Targets that `names` mean: command ids of the sheet, or "process/robot" such as "dpgo/3".

    launches: command id -> Launch.
    """
    identities = {command_id: launch.identity(each) for command_id, each in launches.items()}
    targets = []
    for name in names:
        process, slash, robot = name.partition("/")
        if name in identities:
            process, robot, address = identities[name]
            if address is None:
                raise InputError(f"--wait-for {name}: its command line has neither --robot nor --url, so its bus is "
                                 "unknown; expected one of them, or PROCESS/ROBOT")
            targets.append(Target(name, process, robot, address, name))
        elif slash and process and robot.isdigit():
            ids = [command_id for command_id, each in identities.items() if each[:2] == (process, int(robot))]
            address = identities[ids[0]][2] if ids else bus.robot_bus(int(robot))
            targets.append(Target(name, process, int(robot), address, ids[0] if ids else ""))
        else:
            raise InputError(f"--wait-for {name}: no such command in what is started; expected PROCESS/ROBOT (dpgo/3) "
                             f"or one of {', '.join(identities)}")
    return targets


class Ready:
    """Listens until every target has been heard; `on_heard(target)` hears of each."""

    def __init__(self, loop, network, targets, on_heard):
        self.targets = targets
        self._loop = loop
        self._on_heard = on_heard
        self._sockets = []
        if targets:
            status.status_type()  # missing: better said now
            addresses = sorted({target.address for target in targets})
            self._sockets = network.open_sockets(lambda: [bus.open_bus(*address) for address in addresses])
            for address, each in zip(addresses, self._sockets):
                each.setblocking(False)
                loop.on_readable(each, self._reader(address, each, bus.Receiver()))

    @property
    def missing(self):
        return [target for target in self.targets if not target.heard]

    def is_ready(self, command_id):
        """Whether nothing is to be waited for from this command any more."""
        return all(target.heard for target in self.targets if target.command_id == command_id)

    def close(self):
        for each in self._sockets:
            self._loop.forget(each)
            each.close()
        self._sockets = []

    def _reader(self, address, source, receiver):
        def read():
            for packet, sender in bus.drain(source):
                message = receiver.take(packet, sender)
                if message and message.channel == status.CHANNEL:
                    self._take(address, status.decode(message.payload))
            if not self.missing:
                self.close()
        return read

    def _take(self, address, said):
        for target in self.missing:
            if said and (target.address, target.process, target.robot) == (address, said.process, said.robot):
                target.heard = True
                self._on_heard(target)
