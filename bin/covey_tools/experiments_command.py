# SPDX-License-Identifier: BSD-3-Clause
"""bin/experiments' command line."""

import argparse
import json
import os
import platform
import subprocess
import sys
import time

from covey_tools import experiments, places, recordings
from covey_tools.errors import Failure, InputError

DESCRIPTION = """Measures what the paper's figures and tables show, with the programs of this tree, and says whether what is claimed holds.

Builds first. Every run is made anew, unless --resume takes over what an interrupted call had finished; of a call that came to its end
nothing is kept but sensor data, in --cache."""

EPILOG = """output, in --out
  NAME.json       {"rows": [one flat object per run], "commit", "seed", "machine"}
  NAME.md         medians, figures, and for each claim whether it holds
  NAME*.png       plots
  NAME.runs       the runs so far, for --resume; gone when all are done

exit codes: 0 done, whatever the claims came to; 1 something could not be measured (the report and stderr say what);
2 wrong usage or input"""


_SPECIAL = {"graph": [], "motion": None, "sequences": [], "seconds": None, "cache": recordings.DEFAULT_CACHE,
            "light": False, "resume": False}  # and unset
_last_said = 0.0  # s, of a line of progress


def main(arguments=None):
    options = _parse(arguments)
    experiment = experiments.load(options.name)
    _check(options, experiment)
    if not options.no_build:
        _build(experiment.PROGRAMS)
    out = options.out = _output_folder(options.out)
    begin = time.monotonic()
    rows, notes = experiment.run(options, _say)
    facts = {"rows": rows, "commit": _commit(), "seed": options.seed, "machine": _machine()}
    page = os.path.join(out, f"{options.name}.md")
    _write(os.path.join(out, f"{options.name}.json"), json.dumps(facts, indent=1) + "\n")
    if not rows:
        raise Failure(f"nothing could be measured: {notes[0] if notes else 'no runs'}")
    _write(page, experiment.report(rows, notes, out) + _origin(options, facts, time.monotonic() - begin))
    for note in notes:
        print(f"experiments: not measured: {note}", file=sys.stderr)
    print(page)
    return 1 if notes else 0


def _check(options, experiment):
    for option, unset in _SPECIAL.items():
        if getattr(options, option) != unset and option not in experiment.OPTIONS:
            takers = [name for name in experiments.NAMES if option in experiments.load(name).OPTIONS]
            raise InputError(f"--{option} is for {', '.join(takers)}, not for {options.name}")
    if not options.motion and not os.path.isdir(options.data):
        raise InputError(f"--data {options.data}: no such folder; expected one with pose_graphs/, kitti_loops/ and euroc/")


def _parse(arguments):
    names = "\n".join(f"  {name:12} {experiments.load(name).SUMMARY}" for name in experiments.NAMES)
    parser = argparse.ArgumentParser(prog="experiments", description=f"{DESCRIPTION}\n\nexperiments\n{names}", epilog=EPILOG,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("name", metavar="NAME", choices=experiments.NAMES, help=" | ".join(experiments.NAMES))
    add("--quick", action="store_true", help="fewer seeds, thresholds and graphs, or 20 s of each sequence: under 3 minutes")
    add("--data", default=os.environ.get("COVEY_DATA", os.path.join(places.ROOT, "..", "shared", "data")), metavar="DIR",
        help="recorded data (default $COVEY_DATA, else ../shared/data); what is not there is left out, with a word")
    add("--out", default=os.path.join("out", "experiments"), metavar="DIR", help="default out/experiments")
    add("--graph", action="append", metavar="G", default=[], help="only the runs on this graph (loops: on town, rooms, 7-scenes, aliases, queries); may be repeated")
    add("--sequences", type=lambda text: text.split(","), metavar="A,B", default=[],
        help="vio: only these; what a name begins with will do")
    add("--motion", metavar="DIR", help="vio: fly what is in this folder, SEQUENCE/{imu0,groundtruth}.csv.gz (default DATA/euroc/motion)")
    add("--light", action="store_true", help="vio: rendered with a vignette and brightness that wanders (configs/robots/euroc_light.yaml)")
    add("--seconds", type=_positive, metavar="S", help="vio: of each sequence at most (default: all); loops: of town and rooms (default 300, with --quick 45); consistency: of town (default 65, with --quick 20)")
    add("--cache", default=recordings.DEFAULT_CACHE, metavar="DIR", help="vio, consistency, loops: keeps sensor data, 15 MB a second, or 2 MB with loops (default out/cache)")
    add("--seed", type=int, default=1, help="the first of the seeds (default 1)")
    add("--resume", action="store_true", help="robustness: go on where an interrupted call with the same --out and the same pgo had come to")
    add("--no-build", action="store_true", help="take what bin/build made before")
    return parser.parse_args(arguments)


def _positive(text):
    value = float(text)
    if not 2 <= value < 1e6:
        raise argparse.ArgumentTypeError(f"{text} is not a number from 2 on")
    return value


def _say(line):
    """Each line on a terminal over the one before; elsewhere one every ten seconds."""
    global _last_said
    if sys.stderr.isatty():
        print(f"\r\x1b[K{line[:110]}", end="", file=sys.stderr, flush=True)
    elif time.monotonic() - _last_said >= 10.0:
        _last_said = time.monotonic()
        print(f"experiments: {line}", file=sys.stderr, flush=True)


def _build(programs):
    code = subprocess.run([os.path.join(places.ROOT, "bin", "build"), "release", *programs], stdout=sys.stderr).returncode
    if code:
        raise Failure(f"bin/build ended with {code}")


def _output_folder(out):
    try:
        os.makedirs(out, exist_ok=True)
    except OSError as error:
        raise InputError(f"--out {error.filename}: {error.strerror.lower()}; expected a folder to write in") from None
    return os.path.abspath(out)


def _write(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def _commit():
    def git(*words):
        done = subprocess.run(["git", "-C", places.ROOT, *words], capture_output=True, text=True)
        return done.stdout.strip() if done.returncode == 0 else ""
    commit = git("rev-parse", "--short", "HEAD")
    return commit + "+changes" if commit and git("status", "--porcelain", "-uno") else commit


def _machine():
    model = platform.machine()
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        model = next((line.split(":", 1)[1].strip() for line in file if line.startswith("model name")), model)
    return f"{len(os.sched_getaffinity(0))} x {model}"


def _origin(options, facts, seconds):
    words = ["bin/experiments", options.name, *(["--quick"] if options.quick else []), *(f"--graph {name}" for name in options.graph)]
    words += [f"--sequences {','.join(options.sequences)}"] if options.sequences else []
    words += ["--light"] if options.light else []
    words += [f"--seconds {options.seconds:g}"] if options.seconds else []
    what = " ".join(words)
    return (f"\nMeasured by `{what}` at commit {facts['commit'] or 'unknown'} on {facts['machine']}: {len(facts['rows'])} rows in "
            f"{seconds:.0f} s.\n")
