# SPDX-License-Identifier: BSD-3-Clause
"""Runs the programs that bin/build makes, as tools: arguments in, standard output out."""

import os
import subprocess

from covey_tools import places
from covey_tools.errors import Failure, InputError


def run(name, arguments):
    """Its standard output; its complaint becomes InputError where it exits with 2, else Failure."""
    path = os.path.join(places.build_folder(), "bin", name)
    try:
        done = subprocess.run([path, *arguments], capture_output=True, text=True)
    except OSError as error:
        raise Failure(f"{path}: {error.strerror.lower()}; bin/build makes it") from None
    if done.returncode == 2:
        raise InputError(done.stderr.strip().removeprefix(f"{name}: "))
    if done.returncode:
        raise Failure(f"{name} failed with {done.returncode}: {done.stderr.strip()}")
    return done.stdout
