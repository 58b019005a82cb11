# SPDX-License-Identifier: BSD-3-Clause
"""bin/experiments loops: what distributed place recognition finds, how exactly, for how many bytes and how quickly, against the truth.

town: three robots' keyframes in the simulated streets, rendered once and kept in out/cache; rooms: the same in rooms off a corridor. 7-scenes: a
real sequence with depth, its halves as two robots'. aliases: pairs of places in different rooms that are furnished alike, as one drives past them; all
that joins two is false. queries: how long a query takes among so many keyframes, made from those of town, and what memory a keyframe takes.

Rows: "set", "robots", "keyframes", "accepted", "true", "episodes", "recall" (of overlap episodes; tests/bench/place/score.h), "median_m",
"median_deg", "nees_median" (squared error over covariance; 5.35 would be honest), "bytes_pr", "bytes_gv" (messages of the whole run, without
the radio's heads), "metres", "query_ms", "extract_ms", "exchange_ms" (CPU per keyframe), "curve" (of the most similar keyframe of each other robot, by words
alone: precision and recall among keyframes with an overlap), and "seconds", "seed" of a simulated world. The row of set "aliases" has "pairs", "similar"
(so many would be asked for), "accepted", "true" (none) and "refused" (by word); rows of set "queries" have "keyframes" and "query_ms" alone, the row of
set "memory" has "keyframes", "own_kb" and "other_kb" (kB per keyframe of the robot's own, and of others').
"""

import json
import os

from covey_tools import experiments, figures, programs, recordings, worlds
from covey_tools.experiments import tables
from covey_tools.report import IMAGES_BYTES, KEYPOINTS_BYTES

SUMMARY = "place recognition in a simulated town, in simulated rooms, some alike, and in a real room: closures, their truth, bytes, time"
PROGRAMS = ("bench_place", "sim")  # sim: its hash says whether kept pictures are still what it would draw
OPTIONS = ("graph", "seconds", "cache")
SETS = ("town", "rooms", "7-scenes", "aliases", "queries")

_MEASURED = ("keyframes", "accepted", "true", "episodes", "recall", "median_m", "median_deg", "nees_median", "bytes_pr", "bytes_gv", "metres",
             "query_ms", "extract_ms", "exchange_ms", "curve", "pairs", "similar", "refused", "own_kb", "other_kb")
_CLOSED = ("town", "rooms", "7-scenes")  # sets with closures to be found
_KEYS = ("set", "robots", "seconds", "seed", *_MEASURED)
_ROBOTS = 3
_QUERIES = (1000, 5000, 20000)
_MEMORY = 2000  # keyframes of either kind, of which memory is measured
_ALIASES = 240
_PAPER_BYTES = 22_000  # per keyframe: Machine Hall, place recognition and verification (Kimera-Multi, T-RO 2022, table V)
_CHI_SQUARE_MEDIAN = 5.35  # of 6 degrees of freedom


def run(options, say):
    experiments.check_graphs(options.graph, SETS)
    wanted = options.graph or SETS
    rows, notes = [], []
    if "town" in wanted or "queries" in wanted:
        rows += [row for row in _town(options, say) if row["set"] in (*wanted, *(["memory"] if "queries" in wanted else []))]
    if "rooms" in wanted or "aliases" in wanted:
        rows += [row for row in _rooms(options, say) if row["set"] in wanted]
    if "7-scenes" in wanted:
        scenes = os.path.join(options.data, "rgbd", "seven_scenes")
        if os.path.isdir(scenes):
            say("7-scenes")
            rows.append(_row(_measure("--config", worlds.load("town").file, "--scenes", scenes), set="7-scenes", robots=2))
        else:
            notes.append(f"{scenes} is not there")
    return rows, notes


def _town(options, say):
    found, keys = _simulated("town", options, say, "--queries", *map(str, _QUERIES), "--memory", str(_MEMORY))
    yield _row(found, **keys)
    for query in found["queries"]:
        yield _row(query, set="queries")
    yield _row(found["memory"], set="memory")


def _rooms(options, say):
    found, keys = _simulated("rooms", options, say, "--aliases", str(_ALIASES))
    yield _row(found, **keys)
    yield {**_row({}, **keys), **found["aliases"], "true": 0, "set": "aliases"}


def _simulated(name, options, say, *more):
    """What bench_place says of three robots in a world, and the keys of its row."""
    world = worlds.load(name)
    world.robots = _ROBOTS
    world.seconds = options.seconds or (45.0 if options.quick else 300.0)
    say(f"{name}, {world.robots} robots, {world.seconds:g} s")
    with recordings.keyframe_pictures(world, options.seed, options.data, options.cache) as pictures:
        found = _measure("--config", world.file, "--world", world.name, "--robots", str(world.robots), "--seconds", f"{world.seconds:g}",
                         "--seed", str(options.seed), "--images", pictures, *more)
    return found, {"set": name, "robots": world.robots, "seconds": world.seconds, "seed": options.seed}


def _measure(*arguments):
    return json.loads(programs.run("bench_place", arguments))


def _row(found, **keys):
    return {**dict.fromkeys(_KEYS), **keys, **{key: found[key] for key in _MEASURED if key in found and key != "pairs"}}


def report(rows, notes, folder):
    parts = ["# Distributed place recognition\n", _claims(rows), _closures(rows, folder), _aliases(rows), _bytes(rows, folder), _times(rows)]
    if notes:
        parts.append("## Not measured\n\n" + "".join(f"- {note}\n" for note in notes))
    return "\n".join(part for part in parts if part)


def _claims(rows):
    town, rooms, room, aliases, memory = (next(iter(tables.select(rows, set=name)), None)
                                          for name in ("town", "rooms", "7-scenes", "aliases", "memory"))
    lines = []

    def claim(row, words, holds, evidence):
        lines.append(tables.verdict(words, holds(row) if row else None, evidence(row) if row else ""))

    claim(town, "Of the closures that town accepts at least 90 % are true", lambda row: row["true"] >= 0.9 * row["accepted"],
          lambda row: f"{row['true']} of {row['accepted']}.")
    claim(town, "At least 80 % of the overlap episodes in town get a true closure", lambda row: row["recall"] >= 0.8,
          lambda row: f"{100 * row['recall']:.1f} % of {row['episodes']}.")
    claim(town, "The true ones' median error is at most 0.05 m and 0.6 deg", lambda row: row["median_m"] <= 0.05 and row["median_deg"] <= 0.6,
          lambda row: f"{row['median_m']:.3f} m, {row['median_deg']:.2f} deg.")
    claim(town, "Their covariance is honest within a factor of 2",
          lambda row: 0.5 <= row["nees_median"] / _CHI_SQUARE_MEDIAN <= 2.0,
          lambda row: f"Median of squared error over covariance {row['nees_median']:.2f}, chi-square's {_CHI_SQUARE_MEDIAN}.")
    claim(rooms, "Of the closures that rooms accepts at least 90 % are true", lambda row: row["true"] >= 0.9 * row["accepted"],
          lambda row: f"{row['true']} of {row['accepted']}.")
    claim(aliases, "At most one pair of a hundred in rooms that are alike is accepted", lambda row: 100 * row["accepted"] <= row["pairs"],
          lambda row: f"{row['accepted']} of {row['pairs']}.")
    claim(room, "7-scenes accepts at least 25 closures, at least 95 % of them true",
          lambda row: row["accepted"] >= 25 and row["true"] >= 0.95 * row["accepted"], lambda row: f"{row['true']} of {row['accepted']}.")
    claim(town, "Words, features and closures cost at most 2.9 kB per keyframe of the team", lambda row: _per_keyframe(row) <= 2900,
          lambda row: f"{_per_keyframe(row) / 1e3:.2f} kB.")
    for keyframes, limit in ((5000, 3.0), (20000, 10.0)):
        query = next(iter(tables.select(rows, set="queries", keyframes=keyframes)), None)
        claim(query, f"A query among {keyframes} keyframes takes at most {limit:g} ms", lambda row: row["query_ms"] <= limit,
              lambda row: f"{row['query_ms']:.2f} ms.")
    claim(town, "Features take at most 12 ms of CPU a keyframe", lambda row: row["extract_ms"] <= 12.0, lambda row: f"{row['extract_ms']:.1f} ms.")
    claim(memory, "A keyframe takes at most 40 kB of memory", lambda row: max(row["own_kb"], row["other_kb"]) <= 40.0,
          lambda row: f"{row['own_kb']:.1f} kB of the robot's own, {row['other_kb']:.1f} kB of others'.")
    return "## Claims\n\n" + "".join(lines)


def _closures(rows, folder):
    lines = [[row["set"], row["robots"], row["keyframes"], f"{row['true']} of {row['accepted']}", f"{100 * row['recall']:.1f} % of {row['episodes']}",
              tables.number(row["median_m"]), tables.number(row["median_deg"]), tables.number(row["nees_median"])]
             for row in tables.select(rows, set=_CLOSED)]
    picture = os.path.join(folder, "loops_curve.png")
    drawn = [row for row in tables.select(rows, set=_CLOSED) if row["curve"]]
    if drawn:
        _draw_curves(picture, drawn)
    curve = f"\n![Precision and recall]({os.path.basename(picture)})\n" if drawn else ""
    return "## Closures\n\n" + tables.table(["set", "robots", "keyframes", "true", "recall of episodes", "median error (m)", "(deg)",
                                             "squared error over covariance, median"], lines) + curve if lines else ""


def _aliases(rows):
    row = next(iter(tables.select(rows, set="aliases")), None)
    if row is None:
        return ""
    words = sorted(row["refused"].items(), key=lambda item: -item[1])
    return ("## Places that look alike\n\n"
            f"{row['pairs']} pairs of the same place in two rooms that are furnished alike. {row['similar']} are so similar by their words that features "
            f"would be asked for. Verification, given all features, accepts {row['accepted']} and refuses "
            f"{row['pairs'] - row['accepted']}: {', '.join(f'{count} {word}' for word, count in words)}.\n")


def _bytes(rows, folder):
    found = tables.select(rows, set=_CLOSED)
    if not found:
        return ""
    lines = [[row["set"], f"{row['bytes_pr'] / row['keyframes']:,.0f}", f"{row['bytes_gv'] / row['keyframes']:,.0f}",
              f"{_per_keyframe(row):,.0f}", f"{(row['bytes_pr'] + row['bytes_gv']) / row['metres']:,.0f}",
              f"{row['bytes_gv'] / max(1, row['accepted']):,.0f}"] for row in found]
    picture = os.path.join(folder, "loops_bytes.png")
    bars = {row["set"]: _per_keyframe(row) for row in found}
    _draw(picture, {**bars, "the paper": _PAPER_BYTES, "all keypoints": KEYPOINTS_BYTES, "images": IMAGES_BYTES})
    return ("## Bytes\n\n" + tables.table(["set", "words, per keyframe", "verification, per keyframe", "both", "both, per metre driven",
                                           "verification, per closure"], lines)
            + f"\n![Bytes per keyframe]({os.path.basename(picture)})\n")


def _per_keyframe(row):
    return (row["bytes_pr"] + row["bytes_gv"]) / row["keyframes"]


def _times(rows):
    lines = [[row["set"], row["keyframes"], tables.number(row["query_ms"]), tables.number(row["extract_ms"]), tables.number(row["exchange_ms"])]
             for row in tables.select(rows, set=(*_CLOSED, "queries"))]
    return "## CPU, ms\n\n" + tables.table(["set", "keyframes", "a query", "features of a keyframe", "all else of a keyframe"], lines)


def _draw_curves(path, rows):
    figure, axis = figures.plt.subplots(figsize=(6.0, 4.2))
    for number, row in enumerate(rows):
        points = row["curve"]
        axis.plot([point["recall"] for point in points], [point["precision"] for point in points], color=figures.colour(number),
                  label=f"{row['set']}: most similar by words, of keyframes")
        axis.plot(row["recall"], row["true"] / max(1, row["accepted"]), "o", color=figures.colour(number),
                  label=f"{row['set']}: verified closures, of episodes")
    axis.set_xlabel("recall")
    axis.set_ylabel("precision")
    axis.set_xlim(0, 1.02)
    axis.set_ylim(0, 1.02)
    axis.legend(fontsize=8, frameon=False, loc="lower left")
    figure.tight_layout()
    figure.savefig(path, bbox_inches="tight")
    figures.plt.close(figure)


def _draw(path, bars):
    figure, axis = figures.plt.subplots(figsize=(6.0, 0.4 * len(bars) + 0.9))
    names = list(bars)
    axis.barh(names, list(bars.values()), color=[figures.colour(0 if name in SETS else 7) for name in names])
    for place, name in enumerate(names):
        axis.text(bars[name] * 1.05, place, f"{bars[name] / 1e3:.1f} kB", va="center", fontsize=8)
    axis.set_xscale("log")
    axis.set_xlim(300, 4e6)
    axis.invert_yaxis()
    axis.set_xlabel("bytes per keyframe")
    figure.tight_layout()
    figure.savefig(path, bbox_inches="tight")
    figures.plt.close(figure)
