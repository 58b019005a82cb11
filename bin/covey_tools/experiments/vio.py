# SPDX-License-Identifier: BSD-3-Clause
"""bin/experiments vio: visual-inertial odometry on recorded flights: their real IMU, and pictures that are rendered along their motion.

Rows: "sequence", "seconds", "length_m", "ate_m" (causal, SE(3), no loop closures), "max_m", "rpe_percent", "completion" (frames with a state /
frames from the first state on), "first_state_s", "segments", "ms_mean", "ms_p50", "ms_p99" (CPU of a frame, from the picture to the estimate, one
core), "front_end_ms", "rss_mb" (the most), "nees" (position and yaw), "edge_nees_1s", "edge_nees_10s", "edge_nees_60s" (1: as it should be).

vio runs from a log, in the log's time: no frame is lost however busy the machine is. A folder of DATA/euroc in EuRoC's own layout, with real
pictures, is measured when --sequences names it.
"""

import csv
import json
import os
import statistics
import subprocess

from covey_tools import evaluation, figures, lcm_log, messages, motion, places, programs, recordings
from covey_tools.errors import Failure, InputError
from covey_tools.experiments import tables

SUMMARY = "odometry on recorded flights, rendered: ATE, drift, completion, CPU, memory, consistency"
PROGRAMS = ("sim", "player", "vio", "evaluate", "lcmtypes_python")
OPTIONS = ("motion", "sequences", "light", "seconds", "cache")

QUICK_SECONDS = 20.0
CONFIG = os.path.join(places.ROOT, "configs", "robots", "euroc.yaml")  # one for all
LIGHT_CONFIG = os.path.join(places.ROOT, "configs", "robots", "euroc_light.yaml")  # the simulator's alone, with --light
# m; wanted of whole flights.
ATE_LIMITS = {"V1_01": 0.04, "V1_02": 0.04, "V1_03": 0.06, "MH_01": 0.05, "MH_03": 0.07, "MH_04": 0.10, "MH_05": 0.10, "mh01_clip": 0.006}
MEAN_LIMIT = 0.055
_FLOWN = ("imu0.csv.gz", "groundtruth.csv.gz")
_FIGURES = ("ate_m", "max_m", "rpe_percent", "rpe_deg_per_m", "nees", "edge_nees_1s", "edge_nees_10s", "edge_nees_60s")


def run(options, say):
    seconds = options.seconds or (QUICK_SECONDS if options.quick else None)
    flights, clips = find(options)
    rows, notes = [], []
    recorded, complaints = recordings.prepare_flights(flights, seconds, options.seed, LIGHT_CONFIG if options.light else CONFIG, options.cache, say)
    notes += [f"{os.path.basename(folder)}: {why}" for folder, why in complaints.items()]
    folder = os.path.join(options.out, "vio")
    sources = [(os.path.basename(flight), recording.log(0), recording.truth("robot0.tum")) for flight, recording in recorded.items()]
    for number, (name, log, truth) in enumerate(sources, 1):
        say(f"[{number}/{len(sources)}] {name}: vio")
        _measure(name, log, truth, os.path.join(folder, name), rows, notes)
    for clip in clips:
        name = os.path.basename(clip)
        say(f"{name}: reading its pictures")
        _measure_clip(clip, name, os.path.join(folder, name), rows, notes)
    for recording in recorded.values():
        recording.lock.close()
    return rows, notes


def find(options):
    """(folders of flights, folders with pictures of their own) that are wanted, by name."""
    root = os.path.abspath(options.motion or os.path.join(options.data, "euroc", "motion"))
    if not os.path.isdir(root):
        raise InputError(f"{root}: no such folder; expected recorded flights, SEQUENCE/{{{','.join(_FLOWN)}}}")
    flights = [root] if _is_flight(root) else [os.path.join(root, name) for name in sorted(os.listdir(root))]
    flights = [folder for folder in flights if _is_flight(folder)]
    if not flights:
        raise InputError(f"{root}: no flight in it; expected SEQUENCE/{{{','.join(_FLOWN)}}}")
    beside = os.path.join(options.data, "euroc")
    clips = [os.path.join(beside, name) for name in sorted(os.listdir(beside))] if os.path.isdir(beside) else []
    clips = [os.path.abspath(folder) for folder in clips if os.path.isdir(os.path.join(folder, "mav0", "cam0"))]
    if not options.sequences:
        return flights, []
    for wanted in options.sequences:
        if not any(_is_named(folder, wanted) for folder in flights + clips):
            names = ", ".join(os.path.basename(folder) for folder in flights + clips)
            raise InputError(f"--sequences {wanted}: no such sequence; there are {names}")
    return tuple([folder for folder in folders if any(_is_named(folder, wanted) for wanted in options.sequences)]
                 for folders in (flights, clips))


def _is_flight(folder):
    return all(os.path.isfile(os.path.join(folder, name)) for name in _FLOWN)


def _is_named(folder, wanted):
    return bool(wanted) and os.path.basename(folder).startswith(wanted)


def _measure_clip(clip, name, folder, rows, notes):
    """Real pictures: the log is made anew, which costs less than to look after it."""
    os.makedirs(folder, exist_ok=True)
    log, truth = os.path.join(folder, "sensors.lcm"), os.path.join(folder, "truth.tum")
    try:
        programs.run("player", ["--asl", clip, "--out", log])
        _write_truth(os.path.join(clip, "mav0", "state_groundtruth_estimate0", "data.csv"), truth)
        _measure(name, log, truth, folder, rows, notes)
    except (Failure, InputError) as error:
        notes.append(f"{name}: {error}")
    finally:
        if os.path.exists(log):
            os.remove(log)


def _write_truth(path, out):
    """EuRoC's ground truth (ns, p, q as w x y z) as TUM."""
    trajectory = []
    try:
        with open(path, encoding="ascii", newline="") as file:
            for row in csv.reader(line for line in file if not line.startswith("#")):
                x, y, z, *q = map(float, row[1:8])
                trajectory.append((round(int(row[0]) / 1000) / 1e6, (tuple(q), (x, y, z))))
    except (OSError, ValueError) as error:
        raise Failure(f"{path}: {error}") from None
    motion.write_tum(out, trajectory)


def _measure(name, log, truth, folder, rows, notes):
    """A row, or a note why there is none."""
    os.makedirs(folder, exist_ok=True)
    tum, frames, out = (os.path.join(folder, file) for file in ("vio.tum", "frames.csv", "vio.lcm"))
    try:
        run_vio(log, out, tum, frames)
        error = json.loads(programs.run("evaluate", ["odometry", "--estimate", tum, "--reference", truth, "--log", out]))
    except (Failure, InputError) as reason:
        notes.append(f"{name}: {reason}")
        return
    row = {"sequence": name, **frame_figures(frames, tum), **{key: error.get(key) for key in _FIGURES}, "rss_mb": _most_resident(out)}
    row["length_m"] = round(motion.length(motion.read_tum(truth)), 1)
    rows.append(row)
    with open(os.path.join(folder, "errors.json"), "w", encoding="utf-8") as file:
        json.dump(_errors(tum, truth, error), file)


def run_vio(log, out, tum, frames):
    """Failure where it ends otherwise than well."""
    program = os.path.join(places.build_folder(), "bin", "vio")
    arguments = [program, "--robot", "0", "--config", CONFIG, "--url", f"file://{log}", "--out", out, "--tum", tum, "--frames", frames]
    for path in (out, tum, frames):
        if os.path.exists(path):
            os.remove(path)
    complaint_path = f"{tum}.txt"
    with open(complaint_path, "w+", encoding="utf-8") as said:
        try:
            process = subprocess.Popen(arguments, stdout=said, stderr=said)
        except OSError as error:
            raise Failure(f"{program}: {error.strerror.lower()}; bin/build makes it") from None
        try:
            process.wait()
        except BaseException:  # Ctrl-C too: nothing is left running
            process.kill()
            process.wait()
            raise
        said.seek(0)
        words = said.read().strip().splitlines()
    if process.returncode or not os.path.exists(tum):
        raise Failure(words[-1] if words else f"vio ended with {process.returncode}")


def _most_resident(log):
    """MB, by vio's own word."""
    told = (messages.decode("status_t", event.data) for event in lcm_log.Log(log) if event.channel == "STATUS")
    return max((dict(zip(each.gauge_names, each.gauge_values)).get("rss_mb", 0.0) for each in told if each), default=None)


def frame_figures(frames, tum):
    with open(frames, encoding="ascii", newline="") as file:
        sets = list(csv.DictReader(file))
    worked = [each for each in sets if float(each["frame_ms"]) > 0.0]
    if not worked:
        raise Failure("vio worked on no frame")
    stamps = [round(stamp * 1e6) for stamp, _ in motion.read_tum(tum)]
    begin = int(sets[0]["utime_us"])
    first = next((int(each["utime_us"]) for each in sets if each["fate"] in ("tracking", "coasting")), None)
    after = [each for each in sets if first is not None and int(each["utime_us"]) >= first]
    with_state = set(stamps)
    starts = sum(a["fate"] not in ("tracking", "coasting") and b["fate"] in ("tracking", "coasting") for a, b in zip(sets, sets[1:]))
    ms = sorted(float(each["frame_ms"]) for each in worked)
    return {"seconds": round((int(sets[-1]["utime_us"]) - begin) / 1e6, 1), "frames": len(sets), "first_state_s":
            None if first is None else round((first - begin) / 1e6, 3), "segments": starts, "completion":
            sum(int(each["utime_us"]) in with_state for each in after) / len(after) if after else 0.0, "ms_mean": round(statistics.fmean(ms), 3),
            "ms_p50": ms[len(ms) // 2], "ms_p99": ms[int(0.99 * (len(ms) - 1))], "front_end_ms":
            round(statistics.fmean(float(each["front_end_ms"]) for each in worked), 3),
            "tracks_used": round(statistics.fmean(float(each["used"]) for each in worked), 1)}


def _errors(tum, truth, error):
    """For the plots: [s, m from truth] after alignment, and both ways from above."""
    estimate = motion.moved(motion.read_tum(tum), evaluation.alignment(error))
    true = motion.at(motion.read_tum(truth), [stamp for stamp, _ in estimate])
    pairs = [(stamp, a[1], b[1]) for (stamp, a), b in zip(estimate, true) if b]
    begin = pairs[0][0] if pairs else 0.0
    return [[stamp - begin, sum((u - v) ** 2 for u, v in zip(a, b)) ** 0.5, *a[:2], *b[:2]] for stamp, a, b in pairs]


def limit_of(sequence):
    return next((limit for name, limit in ATE_LIMITS.items() if sequence.startswith(name)), None)


def report(rows, notes, folder):
    parts = [_claims(rows), _table(rows), _plots(rows, folder)]
    if notes:
        parts.append("## Not measured\n\n" + "".join(f"- {note}\n" for note in notes))
    return "# Visual-inertial odometry on recorded flights\n\n" + "\n".join(part for part in parts if part)


def _claims(rows):
    lines = []
    judged = [row for row in rows if limit_of(row["sequence"])]
    over = [row for row in judged if row["ate_m"] > limit_of(row["sequence"])]
    lines.append(tables.verdict("ATE is at most what each sequence may have", not over if judged else None,
                                "Over it: " + ", ".join(f"{row['sequence']} {row['ate_m']:.4f} m of {limit_of(row['sequence'])}" for row in over)
                                if over else f"{len(judged)} sequences."))
    flights = [row for row in judged if "clip" not in row["sequence"]]
    if flights:
        mean = statistics.fmean(row["ate_m"] for row in flights)
        lines.append(tables.verdict(f"mean ATE is at most {MEAN_LIMIT} m", mean <= MEAN_LIMIT, f"{mean:.4f} m over {len(flights)} flights."))
    lines += [_all(rows, "first_state_s", 0.0, 2.0, "a state within 2 s"), _all(rows, "completion", 0.99, 1.0, "a state for 99 % of the frames from then on"),
              _all(rows, "ms_mean", 0.0, 10.0, "mean CPU of a frame at most 10 ms"), _all(rows, "ms_p99", 0.0, 25.0, "99th percentile at most 25 ms"),
              _all(rows, "rss_mb", 0.0, 150.0, "at most 150 MB resident")]
    lines += [_all(rows, f"edge_nees_{span}s", 0.5, 2.0, f"NEES of KEYFRAME edges over {span} s between 0.5 and 2") for span in (1, 10, 60)]
    return "## Claims\n\n" + "".join(lines)


def _all(rows, measure, low, high, claim):
    measured = [row for row in rows if row[measure] is not None]
    missing = [row["sequence"] for row in rows if measure == "first_state_s" and row[measure] is None]
    bad = [row for row in measured if not low <= row[measure] <= high]
    evidence = ", ".join(f"{row['sequence']} {tables.number(row[measure])}" for row in bad or measured)
    if missing:
        evidence += f"; none at all: {', '.join(missing)}"
    return tables.verdict(claim, None if not measured and not missing else not bad and not missing, evidence + ".")


def _table(rows):
    head = ["sequence", "s", "m", "ATE (m)", "may have", "largest (m)", "RPE %", "first state s", "completion", "segments", "ms mean", "p99", "front end",
            "MB", "NEES", "edges 1 s", "10 s", "60 s"]
    lines = [[row["sequence"], row["seconds"], row["length_m"], f"{row['ate_m']:.4f}", limit_of(row["sequence"]) or "-", f"{row['max_m']:.3f}",
              *(tables.number(row[key]) for key in ("rpe_percent", "first_state_s", "completion", "segments", "ms_mean", "ms_p99", "front_end_ms", "rss_mb",
                                                    "nees", "edge_nees_1s", "edge_nees_10s", "edge_nees_60s"))] for row in rows]
    return "## Sequences\n\n" + tables.table(head, lines)


def _plots(rows, folder):
    if not rows:
        return ""
    for path, draw in (("vio_ways.png", _draw_way), ("vio_errors.png", _draw_error), ("vio_ms.png", _draw_ms)):
        figure, axes = figures.grid(len(rows), 2.9)
        for axis, row in zip(axes.flat, rows):
            draw(axis, row, os.path.join(folder, "vio", row["sequence"]))
            axis.set_title(f"{row['sequence']}: {1e3 * row['ate_m']:.1f} mm", fontsize=9, loc="left")
        figure.tight_layout()
        figure.savefig(os.path.join(folder, path), bbox_inches="tight")
        figures.plt.close(figure)
    return ("\n![Ways from above, truth in grey](vio_ways.png)\n\n![Distance from truth by time](vio_errors.png)\n\n"
            "![CPU of each frame](vio_ms.png)\n")


def _points(folder):
    with open(os.path.join(folder, "errors.json"), encoding="utf-8") as file:
        return json.load(file)


def _draw_way(axis, _, folder):
    points = _points(folder)
    axis.plot([p[4] for p in points], [p[5] for p in points], color="#b8b8b8", linewidth=2.5)
    axis.plot([p[2] for p in points], [p[3] for p in points], color=figures.colour(0), linewidth=0.9)
    axis.set_aspect("equal")
    axis.set_xlabel("x (m)")


def _draw_error(axis, row, folder):
    points = _points(folder)
    axis.plot([p[0] for p in points], [p[1] for p in points], color=figures.colour(0), linewidth=0.9)
    if limit_of(row["sequence"]):
        axis.axhline(limit_of(row["sequence"]), color=figures.colour(1), linewidth=0.8, linestyle="--")
    axis.set_ylim(bottom=0)
    axis.set_xlabel("s")
    axis.set_ylabel("m")


def _draw_ms(axis, _, folder):
    with open(os.path.join(folder, "frames.csv"), encoding="ascii", newline="") as file:
        sets = [(int(each["utime_us"]) / 1e6, float(each["frame_ms"])) for each in csv.DictReader(file)]
    axis.plot([s - sets[0][0] for s, _ in sets], [ms for _, ms in sets], ".", color=figures.colour(2), markersize=1.5)
    axis.set_ylim(bottom=0)
    axis.set_xlabel("s")
    axis.set_ylabel("ms")
