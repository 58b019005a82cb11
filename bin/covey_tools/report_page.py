# SPDX-License-Identifier: BSD-3-Clause
"""report.html: one page that needs nothing beside it."""

import base64
import html
import os

from covey_tools import funnels
from covey_tools.report_words import against_central, metres, milliseconds, other_ates, share, truth_of_loops

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1d2733; background: #f6f7f9; margin: 0; }
main { max-width: 1080px; margin: 0 auto; padding: 32px 24px 64px; }
h1 { font-size: 26px; margin: 0; }
h2 { font-size: 17px; margin: 36px 0 10px; }
.sub { color: #5d6b7a; margin: 4px 0 24px; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(190px, 1fr)); gap: 12px; }
.tile { background: #fff; border: 1px solid #e1e5ea; border-radius: 8px; padding: 12px 16px; }
.tile b { display: block; font-size: 24px; font-weight: 600; font-variant-numeric: tabular-nums; }
.tile span { color: #5d6b7a; font-size: 13px; }
.bad { border-left: 4px solid #c92a2a; background: #fff; padding: 8px 14px; margin: 16px 0; }
figure { margin: 0 0 12px; background: #fff; border: 1px solid #e1e5ea; border-radius: 8px; padding: 10px; }
figure img { display: block; max-width: 100%; margin: 0 auto; }
figcaption { color: #5d6b7a; font-size: 13px; padding: 6px 4px 0; }
.pair { display: grid; grid-template-columns: 1fr 1fr; gap: 12px; }
table { border-collapse: collapse; background: #fff; border: 1px solid #e1e5ea; font-variant-numeric: tabular-nums; }
th, td { padding: 4px 12px; text-align: right; border-bottom: 1px solid #eef0f3; }
th { color: #5d6b7a; font-weight: 500; }
code { background: #eceff3; padding: 1px 4px; border-radius: 3px; }
@media (max-width: 720px) { .pair { grid-template-columns: 1fr; } }
"""

_LAST_WORD = ("<p class='sub'>All figures of this page, and more, are in <code>report.json</code>; trajectories are in "
              "<code>traj/</code>, meshes in <code>mesh/</code>, logs of every bus in <code>logs/</code>.</p>")


def write(out, facts):
    """`facts`: what report.make() returned."""
    with open(os.path.join(out, "report.html"), "w", encoding="utf-8") as file:
        file.write(_page(out, facts))


def _page(out, facts):
    title = html.escape(f"Covey: {len(facts['robots'])} robots in {facts['world']}")
    parts = [f"<h1>{title}</h1>", f"<p class='sub'>{_subtitle(facts)}</p>", *_warnings(facts), _tiles(facts)]
    parts += _figures(out, facts["figures"])
    parts += ["<h2>Robots</h2>", _robots(facts)]
    if "mesh" in facts:
        parts += ["<h2>Meshes</h2>", _meshes(facts), *(f"<p>{html.escape(each)}.</p>" for each in facts["remarks"])]
    if "loops" in facts["team"]:
        parts += ["<h2>Loop closures by pair of robots</h2>", _pairs(facts)]
    if "place_recognition" in facts:
        parts += ["<h2>From words to closures, by pair of robots</h2>", _funnels(facts)]
    parts += ["<h2>Radio</h2>", _radio(facts), _LAST_WORD]
    head = f"<meta charset='utf-8'><meta name='viewport' content='width=device-width'><title>{title}</title>"
    body = "\n".join(parts)
    return (f"<!doctype html>\n<html lang='en'><head>{head}<style>{_STYLE}</style></head>\n"
            f"<body><main>\n{body}\n</main></body></html>\n")


def _subtitle(facts):
    words = [f"{facts['seconds']:.0f} s of data in {facts['wall_seconds']:.1f} s",
             f"radio <code>{html.escape(facts['radio'])}</code>", f"seed {facts['seed']}"]
    if facts["commit"]:
        words.append(f"commit <code>{facts['commit']}</code>")
    return " &middot; ".join(words)


def _warnings(facts):
    sentences = [f"Not everything was solved: {sentence}" for sentence in facts["missing"]] + facts["notes"]
    return [f"<div class='bad'>{html.escape(sentence)}</div>" for sentence in sentences]


def _tiles(facts):
    cells = "".join(f"<div class='tile'><b>{html.escape(value)}</b><span>{html.escape(what)}</span></div>"
                    for value, what in _headlines(facts))
    return f"<div class='tiles'>{cells}</div>"


def _headlines(facts):
    team = facts["team"]
    if "ate_m" in team:
        yield metres(team["ate_m"]), f"team ATE; {other_ates(facts)}"
    if "cost" in team:
        yield f"{team['cost']:,.1f}", "; ".join(filter(None, ["robust cost", against_central(team)]))
        yield (f"{team['loops_accepted']:,} of {team['loops_total']:,}",
               "; ".join(filter(None, ["loop closures kept", truth_of_loops(team)])))
    merged = next((each for each in facts.get("mesh", []) if each["robot"] == "merged"), None)
    if merged:
        yield metres(merged["error_after_m"]), f"error of the mesh; {metres(merged['error_before_m'])} before"
        yield share(merged["labels_after"]), f"of its labels right; {share(merged['labels_before'])} before"
    yield f"{facts['communication_bytes']['total'] / 1e6:.2f} MB", "sent over the radio by all robots together"
    common = team.get("time_to_common_frame_s")
    yield f"{common:.1f} s" if common is not None else "never", "until all robots stood in one frame"
    if facts["realtime_factor"]:
        yield f"{facts['realtime_factor']:.1f} x", "real time, from the first data to the last solution"


def _figures(out, shown):
    """The first picture at full width, the others two by two."""
    if not shown:
        return []
    figures = [_figure(os.path.join(out, "snapshots", name), caption) for name, caption in shown]
    pairs = [f"<div class='pair'>{''.join(figures[k:k + 2])}</div>" for k in range(1, len(figures), 2)]
    return ["<h2>Pictures</h2>", figures[0], *pairs]


def _figure(path, caption):
    with open(path, "rb") as file:
        data = base64.b64encode(file.read()).decode("ascii")
    caption = html.escape(caption)
    return (f"<figure><img alt='{caption}' src='data:image/png;base64,{data}'>"
            f"<figcaption>{caption}</figcaption></figure>")


def _table(heads, rows):
    head = "".join(f"<th>{html.escape(each)}</th>" for each in heads)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{head}</tr>{body}</table>"


def _robots(facts):
    heads = ["robot", "keyframes", "closures", "length"]
    rows = [[robot["id"], robot["keyframes"], robot["loops"], f"{robot.get('length_m', 0.0):.0f} m"]
            for robot in facts["robots"]]
    if "ate_m" in facts["team"]:
        heads += ["ATE odometry", "ATE team"]
        for row, robot in zip(rows, facts["robots"]):
            row += [metres(robot.get("ate_vio_m")), metres(robot.get("ate_team_m"))]
    if "frames" in facts["robots"][0]:
        heads += ["image sets", "dropped", "vio mean", "vio p99"]
        for row, robot in zip(rows, facts["robots"]):
            row += [robot["frames"], robot["frames_dropped"], milliseconds(robot["vio_ms_mean"]),
                    milliseconds(robot["vio_ms_p99"])]
    return _table(heads, rows)


def _meshes(facts):
    heads = ["robot", "error before", "after", "completeness", "labels right before", "after"]
    rows = [[each["robot"], metres(each["error_before_m"]), metres(each["error_after_m"]),
             metres(each["completeness_after_m"]), share(each["labels_before"]), share(each["labels_after"])]
            for each in facts["mesh"]]
    return _table(heads, rows)


def _pairs(facts):
    heads = ["robots", "met", "found", "kept"]
    rows = [[f"{pair['a']} - {pair['b']}", "yes" if pair["met"] else "no", pair["total"], pair["accepted"]]
            for pair in facts["team"]["loops"]]
    if "precision" in facts["team"]:
        heads += ["kept and right", "right"]
        for row, pair in zip(rows, facts["team"]["loops"]):
            row += [pair["true"], pair["true_total"]]
    return _table(heads, rows)


def _funnels(facts):
    kept = {(pair["a"], pair["b"]): pair["accepted"] for pair in facts["team"].get("loops", [])}
    rows = [[f"{pair['a']} - {pair['b']}", *(pair[step] for step in funnels.STEPS), kept.get((pair["a"], pair["b"]), "-"),
             funnels.in_words(pair)] for pair in facts["place_recognition"]]
    return _table(["robots", *(step.replace("_", " ") for step in funnels.STEPS), "kept", "refused"], rows)


def _radio(facts):
    sent = facts["communication_bytes"]
    names = [name for name in ("dpgo", "control", "place_recognition", "geometric_verification") if sent[name]]
    rows = [[name.replace("_", " "), f"{sent[name] / 1e3:,.1f} kB"] for name in names]
    rows += [["all", f"{sent['total'] / 1e3:,.1f} kB"],
             ["a server would need, keypoints", f"{sent['centralized_keypoints'] / 1e3:,.0f} kB"],
             ["a server would need, images", f"{sent['centralized_images'] / 1e3:,.0f} kB"]]
    return _table(["module", "sent"], rows)
