# SPDX-License-Identifier: BSD-3-Clause
"""The plots of a demo's report, by matplotlib, as PNG."""

from dataclasses import dataclass

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.collections import LineCollection  # noqa: E402

COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f3b08", "#4d4d4d", "#b2182b", "#5e4fa2"]
_KEPT, _REJECTED, _TRUTH = "#2a9d3a", "#e03131", "#b8b8b8"
_MODULES = ("place_recognition", "geometric_verification", "dpgo", "control")

plt.rcParams.update({"font.family": "sans-serif", "font.size": 9, "axes.spines.top": False, "axes.spines.right": False,
                     "axes.grid": True, "grid.color": "#e6e6e6", "axes.axisbelow": True, "figure.dpi": 110})


@dataclass
class Closure:
    x0: float
    y0: float
    x1: float
    y1: float
    kept: bool


@dataclass
class Panel:
    title: str
    ways: dict  # robot -> trajectory
    closures: list


def colour(robot):
    return COLOURS[robot % len(COLOURS)]


def plan(path, panels, truths):
    """The panels side by side, seen from above, in one scale; truths: {robot: trajectory}, grey below, or {}."""
    size = (5.2 * len(panels), 5.2)
    figure, axes = plt.subplots(1, len(panels), figsize=size, sharex=True, sharey=True, squeeze=False)
    for axis, panel in zip(axes[0], panels):
        for robot, way in truths.items():
            axis.plot(*_xy(way), color=_TRUTH, linewidth=3.0, label="truth" if robot == 0 else None)
        _draw_closures(axis, panel.closures)
        for robot, way in panel.ways.items():
            x, y = _xy(way)
            axis.plot(x, y, color=colour(robot), linewidth=1.3, label=f"robot {robot}", zorder=3)
            axis.plot(x[0], y[0], "o", color=colour(robot), markersize=5, markeredgecolor="white", zorder=4)
        axis.set_title(panel.title, fontsize=10, loc="left")
        axis.set_aspect("equal")
        axis.set_xlabel("x (m)")
    axes[0][0].set_ylabel("y (m)")
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=min(9, len(labels)), frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    _save(figure, path)


def _draw_closures(axis, closures):
    """Fainter where there are thousands of them, so that the robots' ways stay visible."""
    for kept, colour_of, strongest in ((False, _REJECTED, 0.3), (True, _KEPT, 0.7)):
        lines = [((each.x0, each.y0), (each.x1, each.y1)) for each in closures if each.kept == kept]
        alpha = max(0.1, min(strongest, 60.0 * strongest / max(1, len(lines))))
        axis.add_collection(LineCollection(lines, colors=colour_of, linewidths=0.7, alpha=alpha, zorder=2))


def cost_by_round(path, rounds, central_cost):
    """rounds: [(s, cost)]; the central solver's cost as a line where it is known."""
    figure, axis = plt.subplots(figsize=(5.2, 2.8))
    seconds, costs = zip(*rounds)
    axis.plot(seconds, costs, "o-", color=COLOURS[0], markersize=4, linewidth=1.2, label="team, end of each round")
    if central_cost is not None:
        axis.axhline(central_cost, color=COLOURS[1], linewidth=1.0, linestyle="--", label="central, all data")
    axis.set_xlabel("s since the data began")
    axis.set_ylabel("robust cost")
    axis.set_xlim(left=0)
    axis.set_ylim(bottom=0)
    axis.legend(frameon=False, fontsize=8, loc="lower right")
    figure.tight_layout()
    _save(figure, path)


def errors(path, before, after):
    """{robot: [(s, m)]}, before and after the team's solution."""
    figure, axis = plt.subplots(figsize=(5.2, 2.8))
    for robot, rows in before.items():
        axis.plot(*zip(*rows), color=colour(robot), linewidth=0.8, alpha=0.7)
    for robot, rows in after.items():
        axis.plot(*zip(*rows), color=colour(robot), linewidth=2.0, label=f"robot {robot}")
    axis.set_xlabel("s since the robot's first keyframe")
    axis.set_ylabel("m from truth")
    axis.set_ylim(bottom=0)
    axis.legend(frameon=False, fontsize=8)
    figure.tight_layout()
    _save(figure, path)


def bytes_by_module(path, sums):
    """sums: module -> bytes."""
    names = [name for name in _MODULES if sums.get(name)] or ["dpgo"]
    kilobytes = [sums.get(name, 0) / 1e3 for name in names]
    figure, axis = plt.subplots(figsize=(5.2, 1.1 + 0.4 * len(names)))
    axis.barh([name.replace("_", " ") for name in names], kilobytes, color=COLOURS[2], height=0.6)
    for index, value in enumerate(kilobytes):
        axis.text(value, index, f" {value:,.0f} kB", va="center", fontsize=8)
    axis.set_xlim(0, max(kilobytes) * 1.2 + 1)
    axis.invert_yaxis()
    axis.grid(axis="y", visible=False)
    axis.set_xlabel("kB sent over the radio, all robots")
    figure.tight_layout()
    _save(figure, path)


def grid(count, height, **options):
    """(figure, axes) of `count` small plots in rows of four; options as plt.subplots has them."""
    columns = min(4, count)
    lines = -(-count // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(3.4 * columns, height * lines), squeeze=False, **options)
    for axis in axes.flat[count:]:
        axis.set_visible(False)
    return figure, axes


def _xy(way):
    return [t[0] for _, (_, t) in way], [t[1] for _, (_, t) in way]


def _save(figure, path):
    figure.savefig(path, bbox_inches="tight")
    plt.close(figure)


def camera_views(path, left, depth_m, labels, names):
    """Left image, depth and, where there are any, labels side by side; names: label -> word."""
    panels = 2 if labels is None else 3
    figure, axes = plt.subplots(1, panels, figsize=(4.6 * panels, 3.4))
    axes[0].imshow(left, cmap="gray", vmin=0, vmax=255)
    axes[0].set_title("left camera", fontsize=10, loc="left")
    shown = axes[1].imshow(depth_m, cmap="viridis")
    axes[1].set_title("depth (m)", fontsize=10, loc="left")
    figure.colorbar(shown, ax=axes[1], fraction=0.03)
    if labels is not None:
        _draw_labels(axes[2], labels, names)
    for axis in axes:
        axis.set_xticks([])
        axis.set_yticks([])
        axis.grid(visible=False)
    figure.tight_layout()
    _save(figure, path)


def _draw_labels(axis, labels, names):
    palette = plt.get_cmap("tab20")
    picture = palette(labels % 20)
    picture[labels == 255] = (1.0, 1.0, 1.0, 1.0)  # unknown
    axis.imshow(picture)
    axis.set_title("labels", fontsize=10, loc="left")
    for label in sorted({int(each) for each in labels.flat} - {255}):
        axis.plot([], [], "s", color=palette(label % 20), label=names.get(label, str(label)))
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.02), ncol=4, frameon=False, fontsize=8)
