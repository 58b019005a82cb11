# SPDX-License-Identifier: BSD-3-Clause
"""The experiments that bin/experiments knows: name -> module in this package.

An experiment's module offers

    SUMMARY                        a line for --help
    PROGRAMS                       what bin/build has to make for it
    OPTIONS                        which of the command line's special options it takes
    run(options, say)              (flat rows, sentences about what could not be measured); say takes a line of progress
    report(rows, notes, folder)    Markdown about them; writes PNGs into the folder, named like the experiment

options: quick (bool), data (folder), seed (int, the first of the seeds to take), out (folder), and of the special ones those that it takes:
graph (names; only the runs on these, [] for all), resume (bool), motion (folder or None), sequences (names, [] for all), seconds (or None), cache (folder).
"""

import importlib

from covey_tools.errors import InputError

NAMES = ("robustness", "graphs", "vio", "faults", "consistency", "loops")


def load(name):
    return importlib.import_module(f"covey_tools.experiments.{name}")


def check_graphs(wanted, known):
    """InputError where a graph is wanted on which there is no run."""
    for name in wanted:
        if name not in known:
            raise InputError(f"--graph {name}: no run is on such a graph; there are {', '.join(known) or 'none'}")
