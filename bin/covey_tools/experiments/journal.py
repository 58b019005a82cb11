# SPDX-License-Identifier: BSD-3-Clause
"""What runs of pgo reported, in a file that outlives an interrupted call: the pgo's digest, then a line for each run."""

import hashlib
import json
import os


class Journal:
    def __init__(self, path, pgo, resume):
        """resume: what the file holds counts on, if it was this pgo that ran."""
        self._path = path
        with open(pgo, "rb") as file:
            digest = hashlib.sha256(file.read()).hexdigest()
        self._reports = self._read(digest) if resume else {}
        with open(path, "w", encoding="utf-8") as file:
            file.writelines(f"{line}\n" for line in (digest, *map(json.dumps, self._reports.items())))

    def _read(self, digest):
        try:
            with open(self._path, encoding="utf-8") as file:
                lines = file.read().split("\n")[:-1]  # what follows the last newline was still being written
        except FileNotFoundError:
            return {}
        return dict(map(json.loads, lines[1:])) if lines[:1] == [digest] else {}

    def find(self, arguments):
        """The report of the run with these arguments, or None."""
        return self._reports.get(_name(arguments))

    def add(self, arguments, report):
        with open(self._path, "a", encoding="utf-8") as file:
            file.write(json.dumps((_name(arguments), report)) + "\n")

    def remove(self):
        os.remove(self._path)


def _name(arguments):
    return " ".join(map(str, arguments))
