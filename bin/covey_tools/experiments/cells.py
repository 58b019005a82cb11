# SPDX-License-Identifier: BSD-3-Clause
"""Runs of pgo, two at a time, and a flat row for each."""

import concurrent.futures
import json
import os
import subprocess
import time
from dataclasses import dataclass

from covey_tools import places
from covey_tools.errors import Failure
from covey_tools.experiments.journal import Journal

AT_ONCE = 2
_LONGEST_S = 1800
# What a row takes over from pgo's report; None where the report has none.
MEASURED = ("poses", "edges", "cost", "gap", "ate_m", "precision", "recall", "loops", "kept_loops", "shared_loops",
            "kept_shared_loops", "iterations", "block_updates", "rounds", "seconds", "wall_seconds", "bytes_sent",
            "certified_gap", "decisions")


@dataclass
class Cell:
    keys: dict  # what tells this row from the others
    arguments: list  # of pgo


def run(cells, path, resume, say):
    """(A row per cell that could be measured, in order: keys and MEASURED; of each other cell why not).

    path: a journal that is there while this runs, and after an interruption; with resume, what it holds is not run again.
    """
    pgo = os.path.join(places.build_folder(), "bin", "pgo")
    if not os.path.exists(pgo):
        raise Failure(f"{pgo} is not there; bin/build makes it")
    journal = Journal(path, pgo, resume)
    running = set()
    begin, rows, notes = time.monotonic(), [], []
    with concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
        futures = [None if journal.find(cell.arguments) else pool.submit(_solve, pgo, cell, running) for cell in cells]
        due, made = len(cells) - futures.count(None), 0
        try:
            for done, (cell, future) in enumerate(zip(cells, futures), 1):
                found, complaint = future.result() if future else (journal.find(cell.arguments), None)
                if found:
                    rows.append({**cell.keys, **{key: found.get(key) for key in MEASURED}})
                else:
                    notes.append(f"{_name(cell)}: {complaint}")
                if not future:
                    continue
                if found:
                    journal.add(cell.arguments, found)
                made += 1
                seconds = time.monotonic() - begin
                say(f"[{done}/{len(cells)}] {seconds:.0f} s, about {seconds / made * (due - made):.0f} s to go: {_name(cell)}")
        except BaseException:  # Ctrl-C too: nothing is left running
            pool.shutdown(wait=False, cancel_futures=True)
            for process in tuple(running):
                process.kill()
            raise
    journal.remove()
    return rows, notes


def _name(cell):
    return " ".join(f"{key} {value}" for key, value in cell.keys.items() if value is not None)


def _solve(pgo, cell, running):
    """(pgo's report, None), or (None, why there is none)"""
    process = subprocess.Popen([pgo, *map(str, cell.arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    running.add(process)
    try:
        out, complaint = process.communicate(timeout=_LONGEST_S)
    except subprocess.TimeoutExpired:
        process.kill()
        out, complaint = "", f"not done after {_LONGEST_S} s"
        process.communicate()
    finally:
        running.discard(process)
    try:  # a gap that was missed is exit code 1 with a whole report
        return json.loads(out), None
    except ValueError:
        return None, complaint.strip().splitlines()[-1] if complaint.strip() else f"pgo ended with {process.returncode}"
