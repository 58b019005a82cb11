# SPDX-License-Identifier: BSD-3-Clause
"""The message types of lcmtypes/ as lcm-gen's Python makes them, so that they cannot go stale."""

import importlib
import os
import sys

from covey_tools import places
from covey_tools.errors import InputError


def message_type(name):
    """The generated class of that name, such as "status_t"; bin/build puts it into build/<preset>/python/covey."""
    folder = os.path.join(places.build_folder(), "python")
    if folder not in sys.path:
        sys.path.insert(0, folder)
    try:
        return getattr(importlib.import_module(f"covey.{name}"), name)
    except ImportError:
        raise InputError(f"{folder}/covey/{name}.py is missing; run bin/build first") from None


def decode(name, payload):
    """A message of that type, or None when these bytes are not one."""
    kind = message_type(name)
    try:
        return kind.decode(payload)
    except Exception:  # noqa: struct.error, ValueError, UnicodeDecodeError, MemoryError ...: bytes from the network
        return None
