# SPDX-License-Identifier: BSD-3-Clause
"""One beginning of the contact plan for all bridges of a team.

Contacts count from `epoch_utime`. Where a radio configuration leaves it at 0, every bridge counts from the first
datagram that it hears, and a bridge that is started again counts anew: the bridges of a team would disagree.
"""

import re

from covey_tools.errors import InputError

_SECTION = re.compile(r"radio_bridge\s*:.*")
_KEY = re.compile(r"(\s+)(\w+)\s*:\s*(.*)")


def with_epoch(file, epoch_utime):
    """The text of a radio configuration with that epoch; None where it has no contacts, or an epoch of its own."""
    try:
        with open(file, encoding="utf-8") as opened:
            lines = opened.read().splitlines()
    except (OSError, UnicodeDecodeError):
        raise InputError(f"{file}: cannot be read; expected a file like those in configs/radio") from None
    begin, keys = _section(lines)
    if begin is not None and "contacts" in lines[begin].split("#")[0]:
        raise InputError(f"{file}:{begin + 1}: contacts within braces; give each key of radio_bridge a line of its own")
    if "contacts" not in keys:
        return None
    indent, at, value = keys.get("epoch_utime", (keys["contacts"][0], None, "0"))
    if value != "0":
        return None
    if at is not None:
        del lines[at]
    lines.insert(begin + 1, f"{indent}epoch_utime: {epoch_utime}  # set by bin/demo: its start")
    return "\n".join(lines) + "\n"


def _section(lines):
    """Where section radio_bridge begins, and its {key: (indent, line, value)}."""
    begin, indent, keys = None, None, {}
    for number, line in enumerate(line.split("#")[0].rstrip() for line in lines):
        key = _KEY.fullmatch(line)
        if begin is None:
            begin = number if _SECTION.fullmatch(line) else None
        elif line and not line[0].isspace():
            break
        elif key and (indent or key[1]) == key[1]:  # what is further in belongs to a contact
            indent = key[1]
            keys[key[2]] = (indent, number, key[3])
    return begin, keys
