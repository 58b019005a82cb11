# SPDX-License-Identifier: BSD-3-Clause
"""What can be wrong with this host's network for LCM: each check returns findings with the fix to type.

level  "ok"       as it should be
       "note"     works, and worth knowing
       "problem"  messages will be lost or heard by the wrong readers
"""

import fcntl
import os
import re
import select
import shutil
import socket
import struct
import time
from dataclasses import dataclass

from covey_tools import bus, namespace

_SIOCGIFFLAGS = 0x8913
_IFF_UP, _IFF_MULTICAST = 0x1, 0x1000
_COVEY_PROCESSES = {"vio", "mesher", "lcd", "dpgo", "lmo", "radio_bridge", "sim", "player", "viewer_offscreen",
                    "lcm-logger"}
_LARGE_BYTES = 60000  # a band of an image


@dataclass
class Finding:
    name: str
    level: str
    text: str
    fix: str = ""


def all_findings():
    """Every check, in the order in which one would repair."""
    findings = []
    for check in (check_loopback, check_route, check_multicast, check_buffers, check_ports, check_firewall,
                  check_private):
        findings += check()
    return findings


def check_loopback():
    flags = _interface_flags("lo")
    if not flags & _IFF_UP:
        return [Finding("loopback", "problem", "the interface lo is down: nothing on this host hears anything",
                        "ip link set lo up")]
    if _outgoing_interface() == "lo" and not flags & _IFF_MULTICAST:
        return [Finding("loopback", "note", "lo carries the multicast route but not the MULTICAST flag; Linux delivers "
                        "all the same, other LCM programs may complain", "ip link set lo multicast on")]
    return [Finding("loopback", "ok", "lo is up")]


def check_route():
    interface = _outgoing_interface()
    if not interface:
        return [Finding("route", "problem", f"no route to {bus.GROUP} and no default route: LCM cannot send",
                        namespace.MULTICAST_ROUTE)]
    if interface != "lo":
        return [Finding("route", "note", f"multicast leaves by {interface}: with ttl=0 it stays on this host, but goes "
                        f"silent when {interface} goes down; no matter in a private network (bin/sheet's default)",
                        namespace.MULTICAST_ROUTE)]
    return [Finding("route", "ok", "multicast is routed to lo")]


def check_multicast():
    for size, what in ((100, "a small packet"), (_LARGE_BYTES, f"a packet of {_LARGE_BYTES} bytes")):
        error = multicast_error(size)
        if error:
            return [Finding("multicast", "problem", f"{what} sent to {bus.GROUP} does not come back: {error}",
                            namespace.MULTICAST_ROUTE)]
    return [Finding("multicast", "ok", f"packets of 100 and of {_LARGE_BYTES} bytes come back by multicast")]


def check_buffers():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        default = probe.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, bus.RECEIVE_BUFFER_BYTES)
        got = probe.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) // 2  # the kernel doubles what it grants
    if got < bus.RECEIVE_BUFFER_BYTES:
        return [Finding("buffers", "problem", f"a receive buffer may have {got:,} bytes where the buses ask for "
                        f"{bus.RECEIVE_BUFFER_BYTES:,} (net.core.rmem_max): bursts above that are lost, so images "
                        "only arrive in bands and logs have holes under load",
                        f"sysctl -w net.core.rmem_max={bus.RECEIVE_BUFFER_BYTES}")]
    return [Finding("buffers", "ok", f"receive buffers of {got:,} bytes are granted (by default {default:,})")]


def check_ports():
    findings = []
    last = bus.ROBOT_PORT + 59
    ports = {**{port: "a robot's bus" for port in range(bus.ROBOT_PORT, last + 1)}, bus.RADIO_PORT: "the radio"}
    owners = None
    for port, inode, drops in _udp_sockets():
        if port not in ports:
            continue
        owners = _socket_owners() if owners is None else owners
        pid, name = owners.get(inode, (0, "a process of another user"))
        who = f"{name} (process {pid})" if pid else name
        lost = f"; the kernel dropped {drops:,} packets there, its reader is too slow" if drops else ""
        if name not in _COVEY_PROCESSES:
            findings.append(Finding("ports", "problem", f"port {port} ({ports[port]}) is open in {who}{lost}",
                                    f"kill {pid}" if pid else f"ss -ulpn 'sport = :{port}'"))
        else:
            findings.append(Finding("ports", "problem" if drops else "note", f"port {port} is open in {who}: a second "
                                    f"team in this network would hear it{lost}"))
    return findings or [Finding("ports", "ok", f"nobody uses ports {bus.ROBOT_PORT} to {last} and {bus.RADIO_PORT}")]


def check_firewall():
    tables = []
    for name in ("ip_tables_names", "ip6_tables_names"):
        try:
            with open(f"/proc/net/{name}", encoding="ascii") as file:
                tables += file.read().split()
        except OSError:
            pass  # not loaded, or not for this user to see
    tools = [tool for tool in ("nft", "iptables", "ufw", "firewall-cmd")
             if shutil.which(tool) or os.path.exists(f"/usr/sbin/{tool}")]
    if tables:
        return [Finding("firewall", "note", f"packet filter tables are loaded ({', '.join(sorted(set(tables)))}); if "
                        "multicast fails, let 224.0.0.0/4 through", "iptables -I INPUT -d 224.0.0.0/4 -j ACCEPT")]
    if tools:
        return [Finding("firewall", "ok", f"no packet filter is loaded ({', '.join(tools)} installed)")]
    return [Finding("firewall", "ok", "no packet filter here")]


def check_private():
    network = namespace.hold()
    rung, reasons = network.rung, network.reasons
    network.release()
    if rung == "in place":
        return [Finding("private network", "note", "sheets run in place, their buses within reach of this host's "
                        "interfaces: " + "; ".join(reasons), namespace.ALLOW_USER_NAMESPACES)]
    how = {"user": "a user namespace", "root": "a network namespace made by root"}[rung]
    return [Finding("private network", "ok", f"sheets run in a network of their own ({how})")]


def in_place_warning(reasons):
    """What to tell somebody whose buses run in this host's own network."""
    text = (f"no private network ({'; '.join(reasons)}): the buses are visible on, and can be reached through, "
            "this host's network interfaces")
    error = multicast_error(100)
    return text + (f". Multicast does not work here ({error}); type: {namespace.MULTICAST_ROUTE}" if error else "")


def multicast_error(size, wait_s=1.0):
    """"" when a multicast of `size` bytes comes back on a free port, else what happened."""
    try:
        with bus.open_bus(bus.GROUP, 0) as receiver, bus.open_sender() as sender:
            port = receiver.getsockname()[1]
            nonce = os.urandom(16)
            sender.sendto(nonce.ljust(size, b"\0"), (bus.GROUP, port))
            deadline = time.monotonic() + wait_s
            while time.monotonic() < deadline:
                if select.select([receiver], [], [], max(0.0, deadline - time.monotonic()))[0]:
                    if any(data[:16] == nonce and len(data) == size for data, _ in bus.drain(receiver)):
                        return ""
    except OSError as error:
        return error.strerror.lower()
    return f"nothing heard for {wait_s:g} s"


def _interface_flags(name):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            answer = fcntl.ioctl(probe, _SIOCGIFFLAGS, struct.pack("16sH14x", name.encode(), 0))
        except OSError:
            return 0
    return struct.unpack_from("16sH", answer)[1]


def _outgoing_interface():
    """The interface by which a multicast leaves, by the kernel's routing table: longest prefix, then lowest metric."""
    target = struct.unpack(">I", socket.inet_aton(bus.GROUP))[0]
    best = None
    with open("/proc/net/route", encoding="ascii") as file:
        for line in file.read().splitlines()[1:]:
            field = line.split()
            destination, mask = (struct.unpack("<I", struct.pack(">I", int(field[i], 16)))[0] for i in (1, 7))
            if target & mask == destination and int(field[3], 16) & 1:
                rank = (mask, -int(field[6]))
                if best is None or rank > best[0]:
                    best = (rank, field[0])
    return best[1] if best else ""


def _udp_sockets():
    """(port, inode, kernel drops) of every IPv4 UDP socket in this network."""
    sockets = []
    with open("/proc/net/udp", encoding="ascii") as file:
        for line in file.read().splitlines()[1:]:
            field = line.split()
            sockets.append((int(field[1].split(":")[1], 16), int(field[9]), int(field[12])))
    return sockets


def _socket_owners():
    """inode -> (pid, name), for the processes whose files this user may see."""
    owners = {}
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            for file in os.listdir(f"/proc/{pid}/fd"):
                match = re.fullmatch(r"socket:\[(\d+)\]", os.readlink(f"/proc/{pid}/fd/{file}"))
                if match:
                    with open(f"/proc/{pid}/comm", encoding="utf-8", errors="replace") as comm:
                        owners[int(match.group(1))] = (int(pid), comm.read().strip())
        except OSError:
            continue  # it ended, or is another user's
    return owners
