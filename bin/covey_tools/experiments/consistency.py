# SPDX-License-Identifier: BSD-3-Clause
"""bin/experiments consistency: whether odometry knows how wrong it is.

The robots of the simulated town drive once, as in bin/demo; each run sees the pictures of one of them with an IMU whose noise and biases are of another
seed. Normalised estimation error squared, over its degrees of freedom (core/eval/consistency.h): 1 where errors are as large as covariances say.

Rows: "imu_seed", "robot", "seconds", "ate_m", "position_nees", "yaw_nees", "nees" (both together) of STATE against the start, and "edge_nees_1s", "_10s",
"_60s" of chains of KEYFRAMEs that last so long, also of position and rotation alone.

Errors within a run hang together, so a run counts as one draw: the mean over N runs of a quantity with n degrees of freedom is held against the 95 % band of
chi-square with N n of them. Source: Bar-Shalom, Li, Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001, section 5.4.
"""

import json
import os
import statistics

from covey_tools import lcm_log, programs, recordings, worlds
from covey_tools.errors import Failure, InputError
from covey_tools.experiments import tables

SUMMARY = "whether odometry knows how wrong it is: many seeds of a simulated IMU in the town"
PROGRAMS = ("sim", "vio", "evaluate")
OPTIONS = ("seconds", "cache")

SEEDS, QUICK_SEEDS = 20, 5
SECONDS, QUICK_SECONDS = 65.0, 20.0  # a chain of 60 s and the start fit in
_FREEDOM = {"position_nees": 3, "yaw_nees": 1}
_SPANS_S = (1, 10, 60)
_EDGES = [f"edge_{part}nees_{span}s" for span in _SPANS_S for part in ("", "position_", "rotation_")]


def run(options, say):
    world = worlds.load("town")
    world.seconds = options.seconds or (QUICK_SECONDS if options.quick else SECONDS)
    recording = recordings.prepare(world, options.seed, options.data, options.cache, say)
    folder = os.path.join(options.out, "consistency")
    os.makedirs(folder, exist_ok=True)
    rows, notes = [], []
    seeds = [options.seed + k for k in range(QUICK_SEEDS if options.quick else SEEDS)]
    with recording.lock:
        for number, seed in enumerate(seeds):
            say(f"[{number + 1}/{len(seeds)}] IMU of seed {seed}")
            try:
                rows.append(_measure(world, recording, options.seed, seed, number % world.robots, folder))
            except (Failure, InputError) as error:
                notes.append(f"IMU of seed {seed}: {error}")
    return rows, notes


def _measure(world, recording, seed, imu_seed, robot, folder):
    imu, log, out, tum = (os.path.join(folder, name) for name in ("imu.lcm", "sensors.lcm", "vio.lcm", "vio.tum"))
    for path in (out, tum):
        if os.path.exists(path):
            os.remove(path)
    programs.run("sim", ["--world", world.name, "--robots", str(world.robots), "--robot", str(robot), "--seconds", f"{world.seconds:g}",
                         "--seed", str(seed), "--config", world.file, "--imu-only", "--imu-seed", str(imu_seed), "--log", imu])
    try:
        _exchange_imu(recording.log(robot), imu, log)
        programs.run("vio", ["--robot", str(robot), "--config", world.file, "--url", f"file://{log}", "--out", out, "--tum", tum])
    finally:
        os.remove(log)
    told = json.loads(programs.run("evaluate", ["odometry", "--estimate", tum, "--reference", recording.truth(f"robot{robot}.tum"), "--log", out]))
    measures = ("ate_m", *_FREEDOM, "nees", *_EDGES)
    return {"imu_seed": imu_seed, "robot": robot, "seconds": world.seconds, **{key: told.get(key) for key in measures}}


def _exchange_imu(pictures, imu, path):
    """A log with the pictures of one log and, sample by sample, the IMU of another."""
    samples = iter(lcm_log.Log(imu))
    out = lcm_log.Writer(path)
    for event in lcm_log.Log(pictures):
        if event.channel == "DEPTH":
            continue
        if event.channel == "IMU":
            event = next(samples)
        out.write(event.channel, event.data, event.utime)
    out.close()


def band(freedom):
    """95 % of the means of so many squared normal deviates lie in it (Wilson and Hilferty, 1931; 0.1 % exact from 20 on)."""
    deviation = (2.0 / (9.0 * freedom))**0.5
    return tuple((1.0 - 2.0 / (9.0 * freedom) + z * deviation)**3 for z in (-1.96, 1.96))


def report(rows, notes, folder):
    parts = [_claims(rows), _table(rows)]
    if notes:
        parts.append("## Not measured\n\n" + "".join(f"- {note}\n" for note in notes))
    return "# Consistency of odometry in the town, with simulated IMUs\n\n" + "\n".join(parts)


def _claims(rows):
    lines = []
    for measure, freedom in _FREEDOM.items():
        low, high = band(freedom * len(rows))
        mean = statistics.fmean(row[measure] for row in rows)
        lines.append(tables.verdict(f"{measure.replace('_nees', '')}: the mean NEES is in the 95 % band, {low:.2f} to {high:.2f}", low <= mean <= high,
                                    f"{mean:.2f} over {len(rows)} runs."))
    for span in _SPANS_S:
        found = tables.values(rows, f"edge_nees_{span}s")
        mean = statistics.fmean(found) if found else None
        lines.append(tables.verdict(f"NEES of KEYFRAME edges over {span} s is between 0.5 and 2", None if mean is None else 0.5 <= mean <= 2.0,
                                    f"{tables.number(mean)} in the mean."))
    return "## Claims\n\n" + "".join(lines)


def _table(rows):
    head = ["IMU", "robot", "ATE (m)", "position", "yaw", "edges 1 s", "position", "rotation", "10 s", "position", "rotation", "60 s", "position", "rotation"]
    keys = ("position_nees", "yaw_nees", *_EDGES)
    lines = [[row["imu_seed"], row["robot"], f"{row['ate_m']:.4f}", *(tables.number(row[key]) for key in keys)] for row in rows]
    return "## Runs\n\n" + tables.table(head, lines)
