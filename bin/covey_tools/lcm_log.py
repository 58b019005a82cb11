# SPDX-License-Identifier: BSD-3-Clause
"""LCM log files, event by event.

An event is big endian: u32 0xEDA1DA01, i64 number, i64 microseconds when it was logged, i32 bytes of the channel's
name, i32 bytes of the message, name, message. Format: LCM's log-file-format.
"""

import struct
from dataclasses import dataclass

from covey_tools.errors import InputError

_SYNC = 0xEDA1DA01
_SYNC_BYTES = struct.pack(">I", _SYNC)
_HEAD = struct.Struct(">IqqiI")
_MAX_BYTES = 1 << 28


@dataclass
class Event:
    number: int
    utime: int  # us
    channel: str
    data: bytes


class Log:
    """Iterate over the Events; `skipped_bytes` counts what was no event (a torn end, a damaged stretch)."""

    def __init__(self, path):
        try:
            self._file = open(path, "rb")
        except OSError as error:
            raise InputError(f"{path}: {error.strerror.lower()}; expected an LCM log") from None
        self.skipped_bytes = 0

    def __iter__(self):
        with self._file as file:
            while True:
                at = file.tell()
                head = file.read(_HEAD.size)
                if len(head) < _HEAD.size:
                    self.skipped_bytes += len(head)
                    return
                sync, number, utime, channel_bytes, data_bytes = _HEAD.unpack(head)
                if sync != _SYNC or not 0 <= channel_bytes <= 1024 or data_bytes > _MAX_BYTES:
                    if not self._resync(at + 1):
                        return
                    continue
                body = file.read(channel_bytes + data_bytes)
                end, following = file.tell(), file.read(4)
                torn = len(body) < channel_bytes + data_bytes
                if torn or (following not in (b"", _SYNC_BYTES) and _SYNC_BYTES in body):  # it ran into the next event
                    if not self._resync(at + 1):
                        return
                    continue
                file.seek(end)
                yield Event(number, utime, body[:channel_bytes].decode("ascii", "replace"), body[channel_bytes:])

    def _resync(self, start):
        """Go to the next sync word at or after `start`."""
        file, at, tail = self._file, start, b""
        file.seek(start)
        while block := file.read(1 << 16):
            found = (tail + block).find(_SYNC_BYTES)
            if found >= 0:
                position = at - len(tail) + found
                self.skipped_bytes += position - start + 1
                file.seek(position)
                return True
            tail = (tail + block)[-3:]
            at += len(block)
        self.skipped_bytes += at - start + 1
        return False


class Writer:
    """A new log, event by event."""

    def __init__(self, path):
        self._file = open(path, "wb")  # noqa: closed by close()
        self._number = 0

    def write(self, channel, data, utime):
        name = channel.encode("ascii")
        self._file.write(_HEAD.pack(_SYNC, self._number, utime, len(name), len(data)) + name + data)
        self._number += 1

    def close(self):
        self._file.close()
