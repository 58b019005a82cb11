# SPDX-License-Identifier: BSD-3-Clause
"""bin/experiments faults: what becomes of visual-inertial odometry when sensors fail in flight, a fault at a time (covey_tools/sensor_faults.py).

The first minute of V1_01 (or of --sequences), with each fault from two fifths of it on, against the run without any.

Rows: "sequence", "fault", "seconds" (of the fault; None: to the end), "words", "new_segments", "jump_m" (the largest step of STATE that its velocity does
not explain, unless it says before or after that it coasts, or opens a segment), "flagged_jump_m" (of those that do), "ate_m" (each segment aligned by
itself), "after_m" (of the poses later than SETTLE_S after the fault; None where it does not end), "clean_after_m" (of the run without a fault then), "largest_m", "completion", "coasting_s",
"counted" (reasons in STATUS beyond the clean run's: how often), "ms_p99".
"""

import json
import math
import os

from covey_tools import evaluation, figures, lcm_log, messages, motion, recordings, sensor_faults
from covey_tools.errors import Failure, InputError
from covey_tools.experiments import tables, vio

SUMMARY = "odometry when sensors fail in flight, a fault at a time: segments, jumps, error afterwards"
PROGRAMS = vio.PROGRAMS
OPTIONS = ("motion", "sequences", "seconds", "cache")

SECONDS, QUICK_SECONDS = 60.0, 30.0
SEQUENCE = "V1_01"
BEGIN = 0.4  # of the run
SETTLE_S = 1.0
LARGEST_JUMP_M, LARGEST_RATIO, SHORT_S = 0.2, 2.0, 1.0
_QUICK = ("missing_1s", "black_1s", "imu_gap_1s", "stamps", "right_stops")


def run(options, say):
    options.sequences = options.sequences or ([] if options.motion else [SEQUENCE])
    seconds = options.seconds or (QUICK_SECONDS if options.quick else SECONDS)
    flights, _ = vio.find(options)
    recorded, complaints = recordings.prepare_flights(flights, seconds, options.seed, vio.CONFIG, options.cache, say)
    rows, notes = [], [f"{os.path.basename(folder)}: {why}" for folder, why in complaints.items()]
    faults = [fault for fault in sensor_faults.FAULTS if not options.quick or fault.name in _QUICK]
    for flight, recording in recorded.items():
        with recording.lock:
            _fly(os.path.basename(flight), recording, faults, BEGIN * seconds, options, say, rows, notes)
    return rows, notes


def _fly(sequence, recording, faults, begin_s, options, say, rows, notes):
    folder = os.path.join(options.out, "faults", sequence)
    truth = motion.read_tum(recording.truth("robot0.tum"))
    clean = _measure(recording.log(0), recording, truth, os.path.join(folder, "clean"))
    for number, fault in enumerate(faults, 1):
        say(f"[{number}/{len(faults)}] {sequence}: {fault.name}")
        at = os.path.join(folder, fault.name)
        os.makedirs(at, exist_ok=True)
        log = os.path.join(at, "sensors.lcm")
        try:
            sensor_faults.inject(recording.log(0), log, fault, begin_s, options.seed)
            run_ = _measure(log, recording, truth, at)
        except (Failure, InputError) as reason:
            notes.append(f"{sequence}, {fault.name}: {reason}")
            continue
        finally:
            if os.path.exists(log):
                os.remove(log)
        begin = clean["errors"][0][0] + begin_s
        rows.append(_row(sequence, fault, run_, clean, begin + fault.seconds + SETTLE_S))
        with open(os.path.join(at, "errors.json"), "w", encoding="utf-8") as file:
            json.dump({"begin": begin_s, "errors": [[stamp - clean["errors"][0][0], error] for stamp, error in run_["errors"]]}, file)


def _row(sequence, fault, found, clean, recovered):
    counted = {reason: count - clean["counts"].get(reason, 0) for reason, count in found["counts"].items()}
    return {"sequence": sequence, "fault": fault.name, "seconds": fault.seconds if math.isfinite(fault.seconds) else None, "words": fault.words,
            "new_segments": found["segments"] - clean["segments"], "jump_m": found["jump_m"], "flagged_jump_m": found["flagged_jump_m"],
            "ate_m": _rms(found["errors"]), "after_m": _rms(found["errors"], recovered), "clean_after_m": _rms(clean["errors"], recovered),
            "largest_m": max(error for _, error in found["errors"]), "completion": found["completion"], "coasting_s": found["coasting_s"],
            "counted": {reason: count for reason, count in counted.items() if count > 0}, "ms_p99": found["ms_p99"]}


def _rms(errors, since=-math.inf):
    some = [error for stamp, error in errors if stamp >= since]
    return math.sqrt(sum(error * error for error in some) / len(some)) if some else None


def _measure(log, recording, truth, folder):
    os.makedirs(folder, exist_ok=True)
    tum, frames, out = (os.path.join(folder, file) for file in ("vio.tum", "frames.csv", "vio.lcm"))
    vio.run_vio(log, out, tum, frames)
    found = {"counts": {}, **_continuity(out)}
    poses = motion.read_tum(tum)
    found["errors"] = [each for segment in _split(poses, found.pop("names"))
                       for each in _errors(segment, os.path.join(folder, "segment.tum"), recording.truth("robot0.tum"), truth)]
    if not found["errors"]:
        raise Failure("vio told no pose")
    figures_ = vio.frame_figures(frames, tum)
    return {**found, "completion": figures_["completion"], "ms_p99": figures_["ms_p99"]}


def _continuity(log):
    """What STATE and STATUS say: segments, how far a state is from where the one before was going, coasting, drops by reason."""
    names, jump, flagged_jump, coasting_us, last, counts = [], 0.0, 0.0, 0, None, {}
    for event in lcm_log.Log(log):
        if event.channel == "STATUS":
            status = messages.decode("status_t", event.data)
            counts = {name: count for name, count in zip(status.counter_names, status.counter_values) if name.startswith("dropped/")}
        if event.channel != "STATE":
            continue
        state = messages.decode("state_t", event.data)
        if not names or names[-1] != state.segment:
            names.append(state.segment)
            last = None
        if last is not None:
            step_s = (state.utime - last.utime) / 1e6
            off = math.dist(state.t_O_B, [p + step_s * 0.5 * (v + w) for p, v, w in zip(last.t_O_B, last.v_O, state.v_O)])
            coasting_us += (state.utime - last.utime) * state.coasting
            if state.coasting or last.coasting:
                flagged_jump = max(flagged_jump, off)
            else:
                jump = max(jump, off)
        last = state
    return {"names": names, "segments": len(names), "jump_m": jump, "flagged_jump_m": flagged_jump, "coasting_s": coasting_us / 1e6, "counts": counts}


def _split(poses, names):
    """By segment: a segment's name is the stamp of its first pose."""
    bounds = [name / 1e6 - 5e-7 for name in names[1:]] + [math.inf]
    segments, start = [], 0
    for bound in bounds:
        end = next((k for k in range(start, len(poses)) if poses[k][0] >= bound), len(poses))
        segments.append(poses[start:end])
        start = end
    return [segment for segment in segments if len(segment) > 2]


def _errors(poses, path, truth_path, truth):
    """[(stamp, m from truth)] of a segment."""
    motion.write_tum(path, poses)
    estimate = motion.moved(poses, evaluation.alignment(evaluation.evaluate_trajectories([path], [truth_path])))
    true = motion.at(truth, [stamp for stamp, _ in estimate])
    return [(stamp, math.dist(pose[1], there[1])) for (stamp, pose), there in zip(estimate, true) if there]


def report(rows, notes, folder):
    parts = ["# Odometry when sensors fail\n", _claims(rows), _table(rows), _plots(rows, folder)]
    if notes:
        parts.append("## Not measured\n\n" + "".join(f"- {note}\n" for note in notes))
    return "\n".join(part for part in parts if part)


def _claims(rows):
    def claim(words, bad, evidence):
        return tables.verdict(words, not bad if rows else None, f"{len(rows)} faults." if not bad else
                              "Not so: " + ", ".join(f"{row['fault']} {evidence(row)}" for row in bad) + ".")
    short = [row for row in rows if row["seconds"] is not None and row["seconds"] <= SHORT_S]
    return "## Claims\n\n" + "".join((
        claim(f"no step of more than {LARGEST_JUMP_M} m that is not flagged", [row for row in rows if row["jump_m"] > LARGEST_JUMP_M],
              lambda row: f"{row['jump_m']:.2f} m"),
        claim("at most one new segment for a fault", [row for row in rows if row["new_segments"] > 1], lambda row: row["new_segments"]),
        claim(f"none for one of up to {SHORT_S:g} s", [row for row in short if row["new_segments"] > 0], lambda row: row["new_segments"]),
        claim(f"afterwards at most {LARGEST_RATIO:g} times the error without fault",
              [row for row in rows if row["seconds"] is not None and (row["after_m"] is None or row["after_m"] > LARGEST_RATIO * row["clean_after_m"])],
              lambda row: "nothing" if row["after_m"] is None else f"{1e3 * row['after_m']:.1f} mm of {1e3 * row['clean_after_m']:.1f}")))


def _table(rows):
    head = ["fault", "s", "what happens", "new segments", "jump (m)", "flagged jump (m)", "error afterwards (mm)", "without fault", "ATE (mm)",
            "largest (mm)", "coasting s", "completion", "counted"]
    return "## Faults\n\n" + tables.table(head, [
        [row["fault"], "-" if row["seconds"] is None else f"{row['seconds']:g}", row["words"], row["new_segments"], f"{row['jump_m']:.3f}",
         f"{row['flagged_jump_m']:.3f}", *(tables.number(row[key] and 1e3 * row[key]) for key in ("after_m", "clean_after_m", "ate_m", "largest_m")),
         f"{row['coasting_s']:.1f}", tables.number(row["completion"]), ", ".join(f"{reason} {count}" for reason, count in row["counted"].items())]
        for row in rows])


def _plots(rows, folder):
    if not rows:
        return ""
    figure, axes = figures.grid(len(rows), 2.1, sharex=True)
    for axis, row in zip(axes.flat, rows):
        with open(os.path.join(folder, "faults", row["sequence"], row["fault"], "errors.json"), encoding="utf-8") as file:
            found = json.load(file)
        stamps, errors = zip(*found["errors"])
        axis.axvspan(found["begin"], stamps[-1] if row["seconds"] is None else found["begin"] + row["seconds"], color="#e3e3e3")
        axis.plot(stamps, [1e3 * error for error in errors], color=figures.colour(0), linewidth=0.9)
        axis.set_ylim(bottom=0)
        axis.set_title(row["fault"], fontsize=9, loc="left")
    for axis in axes[:, 0]:
        axis.set_ylabel("mm")
    for axis in axes[-1]:
        axis.set_xlabel("s")
    figure.tight_layout()
    figure.savefig(os.path.join(folder, "faults.png"), bbox_inches="tight")
    figures.plt.close(figure)
    return "\n![Distance from truth by time, the fault in grey](faults.png)\n"
