# SPDX-License-Identifier: BSD-3-Clause
"""The plots of a demo's report, by matplotlib, as PNG."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f3b08", "#4d4d4d", "#b2182b", "#5e4fa2"]
MODULES = ("place_recognition", "geometric_verification", "dpgo", "control")

plt.rcParams.update({"font.family": "sans-serif", "font.size": 9, "axes.spines.top": False, "axes.spines.right": False,
                     "axes.grid": True, "grid.color": "#e6e6e6", "axes.axisbelow": True, "figure.dpi": 110})


def colour(robot):
    return COLOURS[robot % len(COLOURS)]


def trajectories(path, panels, truths):
    """Plan views side by side. panels: [(title, {robot: trajectory}, closures or [])], in one frame and one scale; truths:
    {robot: trajectory}, drawn in grey below, or {}. Closures: (x0, y0, x1, y1, accepted)."""
    figure, axes = plt.subplots(1, len(panels), figsize=(5.2 * len(panels), 5.2), sharex=True, sharey=True, squeeze=False)
    for axis, (title, robots, closures) in zip(axes[0], panels):
        for robot, trajectory in truths.items():
            axis.plot(*_plan(trajectory), color="#b8b8b8", linewidth=3.0, solid_capstyle="round", label="truth" if robot == 0 else None)
        for x0, y0, x1, y1, accepted in closures:
            axis.plot([x0, x1], [y0, y1], color="#2a9d3a" if accepted else "#e03131", linewidth=0.6, alpha=0.6 if accepted else 0.25,
                      zorder=2)
        for robot, trajectory in robots.items():
            x, y = _plan(trajectory)
            axis.plot(x, y, color=colour(robot), linewidth=1.3, label=f"robot {robot}", zorder=3)
            axis.plot(x[0], y[0], "o", color=colour(robot), markersize=5, markeredgecolor="white", zorder=4)
        axis.set_title(title, fontsize=10, loc="left")
        axis.set_aspect("equal")
        axis.set_xlabel("x (m)")
    axes[0][0].set_ylabel("y (m)")
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=min(9, len(labels)), frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    _save(figure, path)


def cost_by_round(path, rounds, reference_cost):
    """rounds: [(s, cost)] of finished rounds; the central solver's cost as a line where it is known."""
    figure, axis = plt.subplots(figsize=(5.2, 2.8))
    if rounds:
        axis.plot([each[0] for each in rounds], [each[1] for each in rounds], "o-", color=COLOURS[0], markersize=4, linewidth=1.2,
                  label="distributed, end of each round")
    if reference_cost is not None:
        axis.axhline(reference_cost, color=COLOURS[1], linewidth=1.0, linestyle="--", label="central, all data")
    axis.set_xlabel("s since the data began")
    axis.set_ylabel("robust cost")
    axis.set_ylim(bottom=0)
    axis.legend(frameon=False, fontsize=8)
    figure.tight_layout()
    _save(figure, path)


def bytes_by_module(path, sums):
    """sums: module -> bytes."""
    figure, axis = plt.subplots(figsize=(5.2, 1.9))
    names = [name for name in MODULES if sums.get(name)] or ["dpgo"]
    kilobytes = [sums.get(name, 0) / 1e3 for name in names]
    axis.barh([name.replace("_", " ") for name in names], kilobytes, color=COLOURS[2], height=0.6)
    for index, value in enumerate(kilobytes):
        axis.text(value, index, f" {value:,.0f} kB", va="center", fontsize=8)
    axis.set_xlim(0, max(kilobytes) * 1.2 + 1)
    axis.invert_yaxis()
    axis.grid(axis="y", visible=False)
    axis.set_xlabel("kB sent over the radio, all robots")
    figure.tight_layout()
    _save(figure, path)


def _plan(trajectory):
    return [pose[1][0] for _, pose in trajectory], [pose[1][1] for _, pose in trajectory]


def _save(figure, path):
    figure.savefig(path, bbox_inches="tight")
    plt.close(figure)
