# SPDX-License-Identifier: BSD-3-Clause
"""Private networks: a network namespace in which the buses hear nothing from outside, and nothing outside hears them.

liblcm binds every interface, so a host on the same wire can inject into a robot's private bus, by multicast and by
unicast. In a network namespace with nothing but a loop-back that cannot happen, and two teams on one computer (two
tests, two demos) cannot hear each other either. A ladder, since machines differ in what they allow:

    rung 1  "user"      a user namespace with a network namespace in it (unshare -rn): any user, where it is allowed
    rung 2  "root"      a network namespace alone (unshare -n): root in a container or chroot, where rung 1 is not
    rung 3  "in place"  this host's own network; the buses can be heard and reached through its interfaces

A namespace lives as long as a process in it. `hold()` makes one with a child that does nothing but live there, so that
others can join by its process id: /proc/<pid>/ns/net, and /proc/<pid>/ns/user beside it. When its parent dies without
a word (kill -9), the holder kills whatever is left inside, so that no process goes on for nobody.
"""

import ctypes
import errno
import os
import shutil
import signal
import socket
import subprocess
import time

from covey_tools.errors import Failure

CLONE_NEWUSER = 0x10000000
CLONE_NEWNET = 0x40000000
_PR_SET_PDEATHSIG = 1
_PR_SET_NAME = 15
_PR_SET_CHILD_SUBREAPER = 36

_libc = ctypes.CDLL(None, use_errno=True)

HOLDER_NAME = "covey-netns"  # what ps shows for a holder
# To type where rung 3 hears nothing.
MULTICAST_ROUTE = "ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo"
ALLOW_USER_NAMESPACES = "sysctl -w kernel.unprivileged_userns_clone=1 user.max_user_namespaces=10000"
RUNGS = ("user", "root")


def _call(name, *arguments):
    if getattr(_libc, name)(*arguments) != 0:
        code = ctypes.get_errno()
        raise OSError(code, os.strerror(code))


def die_with_parent(parent_pid, signal_number=signal.SIGKILL):
    """Ask the kernel to signal this process when its parent dies (Linux forgets this at a change of credentials)."""
    _call("prctl", _PR_SET_PDEATHSIG, signal_number, 0, 0, 0)
    if os.getppid() != parent_pid:
        os.kill(os.getpid(), signal_number)


def adopt_orphans():
    """Grandchildren that lose their parent become this process's children instead of init's."""
    _call("prctl", _PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def enter_new(rung):
    """Put this process into a new private network by the given rung; OSError says why it cannot be."""
    if rung == "user":
        uid, gid = os.geteuid(), os.getegid()
        _call("unshare", CLONE_NEWUSER | CLONE_NEWNET)
        for name, text in (("setgroups", "deny"), ("uid_map", f"0 {uid} 1"), ("gid_map", f"0 {gid} 1")):
            with open(f"/proc/self/{name}", "w", encoding="ascii") as file:
                file.write(text)
    else:
        _call("unshare", CLONE_NEWNET)
    _bring_up_loopback()


def try_enter(rung):
    """Move this process into a new private network; returns "" or why it could not, with nothing changed."""
    # A step that fails halfway cannot be taken back, so a child takes it first.
    pid, reason = _start_holder(lambda: enter_new(rung))
    if pid is None:
        return reason
    os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)
    enter_new(rung)
    return ""


def _bring_up_loopback():
    ip = shutil.which("ip") or "/usr/sbin/ip"  # an ordinary user's PATH has no sbin
    for arguments in (["link", "set", "lo", "up", "multicast", "on"], ["route", "add", "224.0.0.0/4", "dev", "lo"]):
        try:
            subprocess.run([ip, *arguments], check=True, capture_output=True, text=True)
        except FileNotFoundError:
            raise OSError(f"{ip} is missing; install iproute2 (bin/setup)") from None
        except subprocess.CalledProcessError as error:
            raise OSError(f"ip {' '.join(arguments)}: {error.stderr.strip()}") from None


class Network:
    """Where a sheet's commands run: a held private namespace, or this host's network (`pid` None)."""

    def __init__(self, rung, pid=None, reasons=()):
        self.rung = rung  # "user" | "root" | "in place"
        self.pid = pid  # of the holder
        self.reasons = list(reasons)  # why each rung above this one did not work
        self._files = []
        if pid is not None:
            names = ["user", "net"] if rung == "user" else ["net"]
            self._files = [os.open(f"/proc/{pid}/ns/{name}", os.O_RDONLY | os.O_CLOEXEC) for name in names]

    @property
    def path(self):
        """What setns() takes; radio_bridge's --netns. Empty in place."""
        return "" if self.pid is None else f"/proc/{self.pid}/ns/net"

    def join(self):
        """Move this process inside (for good: call it in a child)."""
        for file in self._files:
            _call("setns", file, 0)

    def open_sockets(self, make):
        """The sockets that make() -> [socket] opens inside, for this process: a socket stays where it was opened."""
        if self.pid is None:
            return make()
        here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        child = os.fork()
        if child == 0:
            try:
                self.join()
                sockets = make()
                for first in range(0, len(sockets), 100):  # SCM_RIGHTS carries at most 253
                    batch = sockets[first:first + 100]
                    socket.send_fds(there, [b"s"], [each.fileno() for each in batch])
                there.send(b"e")
            except BaseException as error:  # noqa: the parent must hear of it, whatever it is
                there.send(b"x" + str(error).encode()[:1000])
            os._exit(0)
        there.close()
        sockets = []
        while True:
            data, files, _, _ = socket.recv_fds(here, 1100, 100)
            if data != b"s":
                break
            sockets += [socket.socket(fileno=file) for file in files]
        here.close()
        os.waitpid(child, 0)
        if data != b"e":
            raise Failure(f"no socket inside the private network: {data[1:].decode() or 'its helper died'}")
        return sockets

    def hold_again(self):
        """The holder was killed and collected: another takes its place in the namespace, which our files kept."""
        self.pid, reason = _start_holder(self.join)
        if self.pid is None:
            raise Failure(f"the private network is lost: {reason}")

    def release(self):
        """Let go of the namespace; it ends with the last process in it."""
        for file in self._files:
            os.close(file)
        self._files = []
        if self.pid is not None:
            os.kill(self.pid, signal.SIGKILL)
            os.waitpid(self.pid, 0)
            self.pid = None


def hold(mode="auto", rungs=RUNGS):
    """The best Network there is. mode "auto" climbs down the ladder, "private" fails rather than be in place."""
    if mode == "in-place":
        return Network("in place", reasons=["in place was asked for"])
    reasons = []
    for rung in rungs:
        pid, reason = _start_holder(lambda rung=rung: enter_new(rung))
        if pid is not None:
            return Network(rung, pid, reasons)
        reasons.append(f"{'unshare -rn' if rung == 'user' else 'unshare -n'}: {reason}")
    if mode == "private":
        raise Failure(no_private_network(reasons))
    return Network("in place", reasons=reasons)


def no_private_network(reasons):
    """The sentence for a machine that allows neither rung."""
    return (f"no private network here ({'; '.join(reasons)}); run as root, or allow user namespaces: "
            + ALLOW_USER_NAMESPACES)


def _start_holder(enter):
    """(pid, "") of a child that lives where enter() took it, or (None, why it could not)."""
    parent = os.getpid()
    read_end, write_end = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(read_end)
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                signal.signal(number, signal.SIG_IGN)  # a terminal's Ctrl-C is for the sheet to handle
            signal.set_wakeup_fd(-1)
            enter()
            signal.signal(signal.SIGUSR1, lambda *_: _clear_and_exit())
            die_with_parent(parent, signal.SIGUSR1)
            _call("prctl", _PR_SET_NAME, HOLDER_NAME.encode(), 0, 0, 0)
            null = os.open("/dev/null", os.O_RDWR)
            for stream in (0, 1, 2):  # nobody's pipe stays open for the holder's sake
                os.dup2(null, stream)
            os.write(write_end, b"ok")
            os.close(write_end)
            os.closerange(3, 1024)
            while True:
                signal.pause()
        except OSError as error:
            full = error.errno == errno.ENOSPC  # what the kernel says at its limit on namespaces, which may be 0
            text = "no more namespaces are allowed" if full else (error.strerror or "").lower() or str(error)
            os.write(write_end, text.encode())
        except BaseException as error:  # noqa: the parent must hear of it, whatever it is
            os.write(write_end, repr(error).encode())
        os._exit(1)
    os.close(write_end)
    with os.fdopen(read_end, "rb") as pipe:
        answer = pipe.read()
    if answer == b"ok":
        return child, ""
    os.waitpid(child, 0)
    return None, answer.decode() or "died"


def _clear_and_exit():
    """In a holder whose parent is dead: end every process of this network, this one last."""
    network = os.stat("/proc/self/ns/net").st_ino
    found = True
    while found:  # again, for what was being started meanwhile
        time.sleep(0.01)
        found = False
        for pid in filter(str.isdigit, os.listdir("/proc")):
            try:
                if int(pid) != os.getpid() and os.stat(f"/proc/{pid}/ns/net").st_ino == network:
                    os.kill(int(pid), signal.SIGKILL)
                    found = True
            except OSError:
                pass  # it ended, or is not ours to see
    os._exit(0)


def network_of(pid):
    """The Network that process `pid` is in, which stays that process's own (do not release it)."""
    try:
        own, other = (os.stat(f"/proc/{who}/ns/user").st_ino for who in ("self", pid))
        return Network("root" if own == other else "user", pid)
    except OSError as error:
        raise Failure(f"cannot see the network of process {pid}: {error.strerror.lower()}") from None


def join_network_of(pid):
    """Move this process into the network of process `pid`."""
    try:
        network_of(pid).join()
    except OSError as error:
        raise Failure(f"cannot enter the network of process {pid}: {error.strerror.lower()}") from None


def holders():
    """Process ids of the private networks that running sheets hold (as far as this user can see)."""
    found = []
    for name in os.listdir("/proc"):
        if name.isdigit():
            try:
                with open(f"/proc/{name}/comm", encoding="ascii", errors="replace") as file:
                    is_holder = file.read().strip() == HOLDER_NAME
                os.stat(f"/proc/{name}/ns/net")  # not one that has ended and was not collected
                if is_holder:
                    found.append(int(name))
            except OSError:
                pass  # it ended meanwhile
    return sorted(found)
