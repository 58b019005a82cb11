# SPDX-License-Identifier: BSD-3-Clause
"""STATUS messages, decoded by the module that lcm-gen makes of lcmtypes/status_t.lcm, so that it cannot go stale."""

import importlib
import os
import sys

from covey_tools import places
from covey_tools.errors import InputError

CHANNEL = "STATUS"


def status_type():
    """The generated class; bin/build puts it into build/<preset>/python/covey."""
    folder = os.path.join(places.build_folder(), "python")
    if folder not in sys.path:
        sys.path.insert(0, folder)
    try:
        return importlib.import_module("covey.status_t").status_t
    except ImportError:
        raise InputError(f"{folder}/covey/status_t.py is missing; run bin/build first") from None


def decode(payload):
    """A status_t, or None when these bytes are not one."""
    try:
        return status_type().decode(payload)
    except InputError:
        raise
    except Exception:  # noqa: struct.error, ValueError, UnicodeDecodeError, MemoryError ...: bytes from the network
        return None
