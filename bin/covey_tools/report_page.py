# SPDX-License-Identifier: BSD-3-Clause
"""report.html: one page that needs nothing beside it."""

import base64
import html
import os

from covey_tools.report import metres

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1d2733; background: #f6f7f9; margin: 0; }
main { max-width: 1080px; margin: 0 auto; padding: 32px 24px 64px; }
h1 { font-size: 26px; margin: 0; } h2 { font-size: 17px; margin: 36px 0 10px; }
.sub { color: #5d6b7a; margin: 4px 0 24px; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(190px, 1fr)); gap: 12px; }
.tile { background: #fff; border: 1px solid #e1e5ea; border-radius: 8px; padding: 12px 16px; }
.tile b { display: block; font-size: 24px; font-weight: 600; font-variant-numeric: tabular-nums; }
.tile span { color: #5d6b7a; font-size: 13px; }
.bad { border-left: 4px solid #c92a2a; background: #fff; padding: 8px 14px; margin: 16px 0; }
figure { margin: 12px 0; background: #fff; border: 1px solid #e1e5ea; border-radius: 8px; padding: 10px; }
figure img { display: block; max-width: 100%; margin: 0 auto; }
figcaption { color: #5d6b7a; font-size: 13px; padding: 6px 4px 0; }
.pair { display: grid; grid-template-columns: 1fr 1fr; gap: 12px; } .pair figure { margin: 0; }
table { border-collapse: collapse; background: #fff; border: 1px solid #e1e5ea; font-variant-numeric: tabular-nums; }
th, td { padding: 4px 12px; text-align: right; border-bottom: 1px solid #eef0f3; } th { color: #5d6b7a; font-weight: 500; }
code { background: #eceff3; padding: 1px 4px; border-radius: 3px; }
@media (max-width: 720px) { .pair { grid-template-columns: 1fr; } }
"""


def write(out, facts):
    with open(os.path.join(out, "report.html"), "w", encoding="utf-8") as file:
        file.write(_page(out, facts))


def _page(out, facts):
    title = f"Covey: {len(facts['robots'])} robots in {facts['world']}"
    parts = [f"<h1>{html.escape(title)}</h1>", f"<p class='sub'>{_subtitle(facts)}</p>", *_warnings(facts), _tiles(facts)]
    parts += _figures(out, facts.get("figures", []))
    parts += ["<h2>Robots</h2>", _robots(facts)]
    if "loops" in facts["team"]:
        parts += ["<h2>Loop closures by pair of robots</h2>", _pairs(facts)]
    parts += ["<h2>Radio</h2>", _radio(facts)]
    parts.append("<p class='sub'>All figures of this page, and more, are in <code>report.json</code>; trajectories are in <code>traj/</code>, "
                 "logs of every bus in <code>logs/</code>.</p>")
    body = "\n".join(parts)
    return (f"<!doctype html>\n<html lang='en'><head><meta charset='utf-8'><title>{html.escape(title)}</title>\n"
            f"<meta name='viewport' content='width=device-width'><style>{_STYLE}</style></head>\n<body><main>\n{body}\n</main></body></html>\n")


def _subtitle(facts):
    words = [f"{facts['seconds']:.0f} s of data in {facts['wall_seconds']:.1f} s", f"radio <code>{html.escape(facts['radio'])}</code>",
             f"seed {facts['seed']}"]
    if facts["commit"]:
        words.append(f"commit <code>{facts['commit']}</code>")
    return " &middot; ".join(words)


def _warnings(facts):
    sentences = [f"Not everything was solved: {sentence}" for sentence in facts["missing"]] + facts["notes"]
    return [f"<div class='bad'>{html.escape(sentence)}</div>" for sentence in sentences]


def _tiles(facts):
    team, tiles = facts["team"], []
    if "ate_m" in team:
        tiles.append((metres(team["ate_m"]), f"team ATE; odometry alone {metres(team.get('ate_vio_m'))}, central solver "
                                             f"{metres(team.get('ate_centralized_m'))}"))
    if "cost" in team:
        central = team.get("cost_centralized")
        tiles.append((f"{team['cost']:,.1f}", "robust cost" + (f"; {100 * (team['cost'] / central - 1):+.2f} % against the central solver's "
                                                             f"{central:,.1f}" if central else "")))
        truth = f"; precision {team['precision']:.3f}, recall {team.get('recall', 0):.3f}" if "precision" in team else ""
        tiles.append((f"{team['loops_accepted']:,} of {team['loops_total']:,}", f"loop closures kept{truth}"))
    tiles.append((f"{facts['communication_bytes']['total'] / 1e6:.2f} MB", "sent over the radio by all robots together"))
    common = team.get("time_to_common_frame_s")
    tiles.append((f"{common:.1f} s" if common is not None else "never", "until all robots stood in one frame"))
    if facts["realtime_factor"]:
        tiles.append((f"{facts['realtime_factor']:.1f} x", "real time, data to last solution"))
    cells = "".join(f"<div class='tile'><b>{value}</b><span>{html.escape(what)}</span></div>" for value, what in tiles)
    return f"<div class='tiles'>{cells}</div>"


def _figures(out, shown):
    """Pictures embedded; what comes in before and after stands side by side."""
    parts, row = ["<h2>Pictures</h2>"] if shown else [], []
    for name, caption in shown:
        figure = _figure(os.path.join(out, "snapshots", name), caption)
        if name == "plan.png":
            parts.append(figure)
            continue
        row.append(figure)
        if len(row) == 2:
            parts.append(f"<div class='pair' style='margin-bottom:12px'>{''.join(row)}</div>")
            row = []
    return parts + row


def _figure(path, caption):
    with open(path, "rb") as file:
        data = base64.b64encode(file.read()).decode("ascii")
    return f"<figure><img alt='{html.escape(caption)}' src='data:image/png;base64,{data}'><figcaption>{html.escape(caption)}</figcaption></figure>"


def _table(heads, rows):
    head = "".join(f"<th>{html.escape(each)}</th>" for each in heads)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{head}</tr>{body}</table>"


def _robots(facts):
    with_truth = "ate_m" in facts["team"]
    heads = ["robot", "keyframes", "closures", "length"] + (["ATE odometry", "ATE team"] if with_truth else [])
    rows = [[robot["id"], robot["keyframes"], robot["loops"], f"{robot['length_m']:.0f} m"]
            + ([metres(robot.get("ate_vio_m")), metres(robot.get("ate_team_m"))] if with_truth else []) for robot in facts["robots"]]
    return _table(heads, rows)


def _pairs(facts):
    with_truth = "precision" in facts["team"]
    heads = ["robots", "solved together", "found", "kept"] + (["kept and right", "right"] if with_truth else [])
    rows = [[f"{pair['a']} - {pair['b']}", "yes" if pair["met"] else "no", pair["total"], pair["accepted"]]
            + ([pair.get("true"), pair.get("true_total")] if with_truth else []) for pair in facts["team"]["loops"]]
    return _table(heads, rows)


def _radio(facts):
    sent = facts["communication_bytes"]
    rows = [[name.replace("_", " "), f"{sent[name] / 1e3:,.1f} kB"] for name in ("dpgo", "control", "place_recognition", "geometric_verification")
            if sent[name]]
    rows += [["all", f"{sent['total'] / 1e3:,.1f} kB"],
             ["a server would need, keypoints", f"{sent['centralized_keypoints'] / 1e3:,.0f} kB"],
             ["a server would need, images", f"{sent['centralized_images'] / 1e3:,.0f} kB"]]
    return _table(["module", "sent"], rows)
