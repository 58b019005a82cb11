# SPDX-License-Identifier: BSD-3-Clause
"""bin/experiments graphs: every published pose graph, solved by one robot and by teams of 2, 3, 5 and 8, Stata-like worlds, and a
ring with a planted local minimum.

Rows: "graph", "robots", "solver", "start" (None: the solver's own), "cost", "gap" (to the optimum; of robust solvers: to the best robust cost that the rows of this graph
and barc2 have), "block_updates", "rounds", "seconds", "wall_seconds", "bytes_sent", "certified_gap", "barc2" of robust solvers, and "outliers",
the share of random loops that were added for them. rbcd stops at a gap of 1e-4, schur at 1e-6, dgnc and elected at 1e-3, but
for Stata-like worlds (pgo --world stata, one for each seed), where "shared_loops" and "kept_shared_loops" count what is between robots.
"""

import json
import os
import subprocess
import tempfile
from dataclasses import dataclass

from covey_tools import experiments, places
from covey_tools.experiments import ring, tables

SUMMARY = "every published pose graph with 1, 2, 3, 5 and 8 robots: cost, gap, certificate, rounds, CPU, bytes"
PROGRAMS = ("pgo",)
OPTIONS = ("graph",)

# CONVENTIONS.md's cost, each with a certificate.
OPTIMA = {"intel": 393.652541, "m3500": 193.862258, "mit": 61.154116, "csail": 31.470332, "kitti_00": 125.680708,
          "sphere2500": 1687.005814, "torus3D": 24227.04556, "parking-garage": 1.262524, "cubicle": 717.125991,
          "smallGrid3D": 1025.398056, "tinyGrid3D": 18.519366}
# CPU seconds of SE-Sync's whole solve, certificate included, on two cores.
SE_SYNC_SECONDS = {"sphere2500": 0.56, "torus3D": 0.93, "cubicle": 1.36, "parking-garage": 0.47, "intel": 0.035}
ROBUST_SOLVERS = ("gnc", "dgnc", "elected")
STATA = {f"stata-{seed}": seed for seed in (1, 2, 3)}  # three robots with 2, 1 and 0 closures between them
GAPS = {"rbcd": 1e-4, "schur": 1e-6, "dgnc": 1e-3, "elected": 1e-3}
TEAMS = (1, 2, 3, 5, 8)
TIMEOUT_S = 600.0


@dataclass(frozen=True)
class Task:
    graph: str
    robots: int | None
    solver: str
    barc2: float | None = None
    outliers: float = 0.0
    start: str | None = None
    repeats: int = 1  # the run with the median of seconds counts


@dataclass(frozen=True)
class RobustCase:
    """On which the robust team solvers are compared."""
    graph: str
    robots: int | None  # None: as many as the files say
    barc2: float | None = None
    outliers: float = 0.0
    quick: bool = False

    @property
    def name(self):
        cut = f" in {self.robots}" if self.robots else ""
        return f"{self.graph}{cut}, {100 * self.outliers:g} % false" if self.outliers else f"{self.graph}{cut}"

    def row(self, rows, solver):
        return next((row for row in rows if row["graph"] == self.graph and row["solver"] == solver
                     and self.robots in (None, row["robots"]) and row["outliers"] == self.outliers), None)


ROBUST = (RobustCase("intel", 3, quick=True), RobustCase("intel", 3, outliers=0.3), RobustCase("intel", 3, outliers=0.7),
          RobustCase("tunnels", None, 100.0, quick=True), RobustCase("sphere2500", 3), RobustCase("sphere2500", 5))


def tasks(quick):
    """What is run; the central solver of a graph before the others."""
    teams = (1, 5) if quick else TEAMS
    for graph in OPTIMA:
        for robots in teams:
            if robots == 1:
                yield Task(graph, 1, "l2", repeats=3)
            else:
                yield from (Task(graph, robots, solver) for solver in ("rbcd", "schur"))
    yield from (Task("ring", 1, "l2"), Task("ring", 1, "l2", start="odometry"), Task("ring", ring.ROBOTS, "dgnc", ring.BARC2))
    for case in ROBUST:
        if case.quick or not quick:
            yield from (Task(case.graph, case.robots, solver, case.barc2, case.outliers) for solver in ROBUST_SOLVERS)
    if not quick:
        yield from (Task(graph, None, solver) for graph in STATA for solver in ("gnc", "dgnc"))


def run(options, say):
    """Measured rows and, of what could not be measured, sentences."""
    rows, notes = [], []
    wanted = list(tasks(options.quick))
    experiments.check_graphs(options.graph, list(dict.fromkeys(task.graph for task in wanted)))
    wanted = [task for task in wanted if not options.graph or task.graph in options.graph]
    for number, task in enumerate(wanted, 1):
        try:
            row = _measure(task, options.data, rows)
        except _NotMeasured as reason:
            notes.append(f"{task.graph}, {task.robots or 'all'} robots, {task.solver}: {reason}")
            say(f"[{number}/{len(wanted)}] {notes[-1]}")
            continue
        rows.append(row)
        say(f"[{number}/{len(wanted)}] {row['graph']:<15} {row['robots']} robots  {row['solver']:<8} "
            f"gap {_number(row['gap'], '.1e'):>8}  {row['seconds']:7.2f} s  {_number(row['certified_gap'], '.1e'):>8} certified")
    return rows, notes


class _NotMeasured(Exception):
    pass


def _source(task, data, folder):
    """The arguments of pgo that name the graph; what is made up is written into the folder."""
    if task.graph in STATA:
        return ["--world", "stata", "--seed", str(STATA[task.graph])]
    if task.graph == "ring":
        path = os.path.join(folder, "ring.g2o")
        ring.write(path)
        return ["--graph", path]
    path = os.path.join(data, "pose_graphs", "tunnels" if task.graph == "tunnels" else f"{task.graph}.g2o")
    if not os.path.exists(path):
        raise _NotMeasured(f"{path} is not there")
    return ["--graph", path]


def _measure(task, data, rows):
    found = sorted((_solve(task, data, rows) for _ in range(task.repeats)), key=lambda report: report["seconds"])
    report = found[len(found) // 2]
    row = {"graph": task.graph, "start": task.start}
    for key in ("robots", "solver", "cost", "gap", "block_updates", "rounds", "seconds", "wall_seconds", "bytes_sent",
                "certified_gap", "barc2", "shared_loops", "kept_shared_loops"):
        row[key] = report.get(key)
    return row | {"outliers": task.outliers}


def _solve(task, data, rows):
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "report.json")
        arguments = [*_source(task, data, folder), "--solver", task.solver, "--certify", "--json", out]
        if task.robots:
            arguments += ["--robots", str(task.robots)]
        if task.barc2:
            arguments += ["--barc2", str(task.barc2)]
        if task.outliers:
            arguments += ["--outliers", str(task.outliers)]
        if task.start:
            arguments += ["--start", task.start]
        optimum = _reference_cost(task, rows)
        if optimum:
            arguments += ["--optimum", repr(optimum)]
            if task.solver in GAPS and task.graph not in (*STATA, "ring"):
                arguments += ["--gap", str(GAPS[task.solver])]
        program = os.path.join(places.build_folder(), "bin", "pgo")
        try:
            done = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=TIMEOUT_S)
        except subprocess.TimeoutExpired:
            raise _NotMeasured(f"not done after {TIMEOUT_S:.0f} s") from None
        except OSError as error:
            raise _NotMeasured(f"{program}: {error.strerror.lower()}; bin/build pgo makes it") from None
        if not os.path.exists(out):  # a missed gap is exit code 1 with a report
            raise _NotMeasured(done.stderr.strip() or f"pgo ended with {done.returncode}")
        with open(out, encoding="utf-8") as file:
            return json.load(file)


def _reference_cost(task, rows):
    """The optimum, or for a robust solver the central one's cost."""
    if task.graph == "ring":
        optimum = _find(rows, "ring", "l2")
        return optimum["cost"] if optimum else None
    if task.solver not in ROBUST_SOLVERS:
        return OPTIMA[task.graph]
    central = RobustCase(task.graph, task.robots, task.barc2, task.outliers).row(rows, "gnc")
    return central["cost"] if central else None


def shows(rows):
    """What is wanted of these graphs: (sentence, figures, True, False or None where it was not measured)."""
    return [_optima(rows), _central_seconds(rows), _rbcd_gap(rows), _rbcd_updates(rows), _rbcd_seconds(rows), _schur(rows),
            _bytes(rows), _stata(rows), _central_certificates(rows), _team_certificates(rows), _planted_bound(rows), _planted_agreement(rows)]


def _find(rows, graph, solver, robots=None):
    return next((row for row in rows if row["graph"] == graph and row["solver"] == solver
                 and robots in (None, row["robots"])), None)


def _judge(sentence, figures, limit, wanted):
    """figures: {name: value}, each at most its limit (a number for all, or {name: number}); wanted: the names that belong to it."""
    limits = limit if isinstance(limit, dict) else dict.fromkeys(figures, limit)
    text = ", ".join(f"{name} {value:.3g}" for name, value in figures.items()) or "not measured"
    missing = [name for name in wanted if name not in figures]
    failed = any(value > limits[name] for name, value in figures.items())
    if missing and figures:
        text += f" (not measured: {', '.join(missing)})"
    return sentence, text, False if failed else None if missing else True


def _of(rows, names, solver, robots, value):
    """value(row) of each graph's row that has one."""
    found = {name: _find(rows, name, solver, robots) for name in names}
    figures = {name: value(row) for name, row in found.items() if row}
    return {name: figure for name, figure in figures.items() if figure is not None}


def _optima(rows):
    figures = _of(rows, OPTIMA, "l2", 1, lambda row: abs(row["gap"]))
    return _judge("central l2 within 1e-6 of the optimum on all eleven graphs", figures, 1e-6, OPTIMA)


def _central_seconds(rows):
    figures = _of(rows, SE_SYNC_SECONDS, "l2", 1, lambda row: row["seconds"])
    return _judge("seconds of central l2 at most SE-Sync's", figures, SE_SYNC_SECONDS, SE_SYNC_SECONDS)


def _rbcd_gap(rows):
    names = ("sphere2500", "torus3D", "intel", "cubicle")
    return _judge("five robots, rbcd reaches a gap of 1e-4", _of(rows, names, "rbcd", 5, lambda row: row["gap"]), 1e-4, names)


def _rbcd_updates(rows):
    names = ("sphere2500", "torus3D")
    figures = _of(rows, names, "rbcd", 5, lambda row: row["block_updates"])
    return _judge("... within 100 block updates", figures, 100, names)


def _rbcd_seconds(rows):
    names = ("sphere2500", "torus3D")

    def ratio(row):
        central = _find(rows, row["graph"], "l2", 1)
        return row["seconds"] / central["seconds"] if central else None

    return _judge("... in at most twice the central solver's CPU time", _of(rows, names, "rbcd", 5, ratio), 2.0, names)


def _schur(rows):
    names = ("sphere2500", "torus3D", "intel", "cubicle", "parking-garage")
    figures = _of(rows, names, "schur", 5, lambda row: row["rounds"] if row["gap"] <= 1e-6 else float("inf"))
    return _judge("five robots, schur reaches a gap of 1e-6 within 30 rounds (rounds)", figures, 30, names)


def _bytes_ratio(case, rows):
    """What dgnc sends over what elected does; infinite where it has not come to the gap, None where one was not measured."""
    dgnc, elected = (case.row(rows, solver) for solver in ("dgnc", "elected"))
    if not dgnc or not elected or dgnc["gap"] is None:
        return None
    return dgnc["bytes_sent"] / elected["bytes_sent"] if dgnc["gap"] <= GAPS["dgnc"] else float("inf")


def _bytes(rows):
    ratios = {case.name: _bytes_ratio(case, rows) for case in ROBUST}
    figures = {name: ratio for name, ratio in ratios.items() if ratio is not None}
    return _judge("dgnc sends at most three times what elected does, to a robust-cost gap of 1e-3", figures, 3.0, ratios)


def _stata(rows):
    def rounds(row):
        good = row["kept_shared_loops"] == row["shared_loops"] and row["gap"] <= 1e-3 and row["seconds"] <= 30.0
        return row["rounds"] if good else float("inf")

    figures = _of(rows, STATA, "dgnc", None, rounds)
    return _judge("Stata-like: dgnc keeps all closures between robots, at a cost within 1e-3 of central GNC's or below, in 30 s "
                  "and 50 rounds (rounds)", figures, 50, STATA)


def _central_certificates(rows):
    names = ("sphere2500", "torus3D", "intel", "cubicle")
    figures = _of(rows, names, "l2", 1, lambda row: row["certified_gap"])
    return _judge("certified gap of central optima at most 1e-6", figures, 1e-6, names)


def _team_certificates(rows):
    graphs = ("sphere2500", "torus3D", "intel", "cubicle")
    wanted = [f"{graph} {solver}" for graph in graphs for solver in ("rbcd", "schur")]
    figures = {}
    for row in rows:
        # Not dgnc, which stops at a gap of the robust cost, of which rejected loops are the larger part.
        if row["graph"] in graphs and row["solver"] in ("rbcd", "schur") and row["certified_gap"] is not None:
            name = f"{row['graph']} {row['solver']}"
            figures[name] = max(row["certified_gap"], figures.get(name, 0.0))
    return _judge("certified gap of what teams end with at most 1e-3 (the largest over team sizes)", figures, 1e-3, wanted)


def _planted(rows):
    """Of the ring's local minimum, as one robot and as a team found it: {name: (certified gap, true gap)}, both as parts of its cost."""
    found = {"central": next((row for row in rows if row["graph"] == "ring" and row["start"] == "odometry"), None),
             "team": _find(rows, "ring", "dgnc")}
    return {name: (row["certified_gap"], row["gap"] / (1.0 + row["gap"])) for name, row in found.items() if row and row["gap"] is not None}


def _planted_bound(rows):
    figures = {name: true / certified if true > 0.1 else float("inf") for name, (certified, true) in _planted(rows).items()}
    return _judge("at a planted local minimum the certified gap is at least the true one (true by certified)", figures, 1.0, ("central", "team"))


def _planted_agreement(rows):
    planted = _planted(rows)
    figures = {"apart": abs(planted["team"][0] / planted["central"][0] - 1.0)} if len(planted) == 2 else {}
    return _judge("... and the team's is within 5 % of the central one", figures, 0.05, ("apart",))


def _number(value, form):
    return "" if value is None else format(value, form)


def report(rows, notes, folder):
    """The page: the table, then what it shows, and the picture."""
    plot(os.path.join(folder, "graphs.png"), rows)
    return markdown(rows, notes) + "\n![Gap, bytes and CPU seconds of each graph](graphs.png)\n"


def markdown(rows, notes):
    lines = ["# Published pose graphs, by one robot and by teams", "",
             "CPU seconds are summed over the robots, start included; a certified gap is proven (core/pgo/certificate.h).", "",
             "| graph | robots | solver | cost | gap | block updates | rounds | CPU s | wall s | bytes sent | certified gap |",
             "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"]
    for row in rows:
        graph = f"{row['graph']}, {100 * row['outliers']:g} % false" if row["outliers"] else row["graph"]
        solver = f"{row['solver']} from {row['start']}" if row["start"] else row["solver"]
        cells = [graph, row["robots"], solver, f"{row['cost']:.9g}", _number(row["gap"], ".1e"),
                 _number(row["block_updates"], "d"), _number(row["rounds"], "d"), f"{row['seconds']:.3f}",
                 f"{row['wall_seconds']:.3f}", _number(row["bytes_sent"], ","), _number(row["certified_gap"], ".1e")]
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    lines += _bytes_table(rows)
    verdicts = {True: "yes", False: "**no**", None: "not measured in full"}
    lines += ["", "| wanted | measured | holds |", "| --- | --- | --- |"]
    lines += [f"| {sentence} | {text} | {verdicts[held]} |" for sentence, text, held in shows(rows)]
    if notes:
        lines += ["", "Not measured:", "", *(f"- {note}" for note in notes)]
    return "\n".join(lines) + "\n"


def _bytes_table(rows):
    lines = ["", f"Bytes to a robust cost within {GAPS['dgnc']:g} of central GNC's:", "",
             "| graph | central cost | dgnc | its gap | elected | ratio |", "| --- | --- | --- | --- | --- | --- |"]
    for case in ROBUST:
        ratio = _bytes_ratio(case, rows)
        if ratio is None:
            continue
        central, dgnc, elected = (case.row(rows, solver) for solver in ROBUST_SOLVERS)
        cells = [case.name, f"{central['cost']:.6g}", f"{dgnc['bytes_sent']:,}", _number(dgnc["gap"], ".1e"),
                 f"{elected['bytes_sent']:,}", _number(ratio, ".2f")]
        lines.append("| " + " | ".join(cells) + " |")
    return lines if len(lines) > 5 else []


def plot(path, rows):
    """Gap, bytes and CPU seconds of each graph, by solver; teams of five."""
    shown = [row for row in rows if row["solver"] in ("l2", "rbcd", "schur") and row["robots"] in (1, 5)]
    graphs = [name for name in OPTIMA if any(row["graph"] == name for row in shown)]
    panels = [("gap to the optimum", "gap", {"rbcd": GAPS["rbcd"], "schur": GAPS["schur"]}), ("bytes sent", "bytes_sent", {}),
              ("CPU seconds, all robots", "seconds", {})]
    series = {solver: {key: [_value(shown, graph, solver, key) for graph in graphs] for _, key, _ in panels}
              for solver in ("l2", "rbcd", "schur")}
    tables.by_graph(path, graphs, series, panels)


def _value(rows, graph, solver, key):
    row = _find(rows, graph, solver)
    value = row[key] if row else None
    return max(abs(value), 1e-12) if value is not None and key == "gap" else value
