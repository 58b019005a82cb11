# SPDX-License-Identifier: BSD-3-Clause
"""STATUS, what every process says of itself once a second."""

from covey_tools import messages

CHANNEL = "STATUS"


def status_type():
    """The generated class; InputError where it was not built."""
    return messages.message_type("status_t")


def decode(payload):
    """A status_t, or None when these bytes are not one."""
    return messages.decode("status_t", payload)
