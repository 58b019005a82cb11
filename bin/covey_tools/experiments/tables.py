# SPDX-License-Identifier: BSD-3-Clause
"""Medians of rows, Markdown tables, verdicts and plots: what reports of experiments are made of."""

import os
import statistics

from covey_tools import figures


def select(rows, **keys):
    """The rows that have these values, or one of them where a tuple is given."""
    def fits(row):
        return all(row.get(key) in value if isinstance(value, tuple) else row.get(key) == value for key, value in keys.items())
    return [row for row in rows if fits(row)]


def values(rows, measure):
    return [row[measure] for row in rows if row[measure] is not None]


def median(rows, measure):
    """None where nothing was measured."""
    found = values(rows, measure)
    return statistics.median(found) if found else None


def distinct(rows, key):
    """The values of a key in the order in which they first stand in the rows, without None."""
    return list(dict.fromkeys(row[key] for row in rows if row.get(key) is not None))


def number(value, digits=3):
    return "-" if value is None else f"{value:.{digits}g}" if abs(value) < 1e4 else f"{value:,.0f}"


def percent(share):
    return f"{100 * share:g} %"


def table(head, lines):
    """Markdown."""
    rule = ["---"] * len(head)
    return "".join(f"| {' | '.join(str(cell) for cell in line)} |\n" for line in (head, rule, *lines))


def verdict(claim, holds, evidence):
    """A line of a list; holds: None where there is nothing to judge by."""
    word = "not measured" if holds is None else "holds" if holds else "DOES NOT HOLD"
    return f"- **{word}**: {claim}. {evidence}\n"


def boxes(path, title, panels, measure_name, groups, series, palette):
    """Box plots side by side on a logarithmic axis; whiskers reach to the extremes.

    panels: [(title, {(group, series): [values]})]; groups along the x axis, series by colour, that of their place in palette.
    """
    plt = figures.plt
    figure, axes = plt.subplots(1, len(panels), figsize=(max(4.0, 2.9 * len(panels)), 3.6), sharey=True, squeeze=False)
    width = 0.8 / len(series)
    for axis, (name, found) in zip(axes[0], panels):
        for s, one in enumerate(series):
            colour = figures.colour(palette.index(one))
            shown = [(g, found[group, one]) for g, group in enumerate(groups) if found.get((group, one))]
            if not shown:
                continue
            axis.boxplot([each for _, each in shown], positions=[g + (s - (len(series) - 1) / 2) * width for g, _ in shown],
                         widths=0.85 * width, patch_artist=True, manage_ticks=False, whis=(0, 100),
                         boxprops={"facecolor": colour, "edgecolor": colour, "alpha": 0.55},
                         medianprops={"color": colour, "linewidth": 1.6}, whiskerprops={"color": colour},
                         capprops={"color": colour})
        axis.set_yscale("log")
        axis.set_xticks(range(len(groups)), [str(group) for group in groups])
        axis.set_xlim(-0.5, len(groups) - 0.5)
        axis.set_title(name, fontsize=10, loc="left")
    axes[0][0].set_ylabel(measure_name)
    handles = [plt.Rectangle((0, 0), 1, 1, facecolor=figures.colour(palette.index(one)), alpha=0.55) for one in series]
    figure.legend(handles, series, loc="lower center", ncol=len(series), frameon=False, fontsize=8)
    figure.suptitle(title, fontsize=10, x=0.01, ha="left")
    figure.tight_layout(rect=(0, 0.07, 1, 1))
    figure.savefig(path, bbox_inches="tight")
    plt.close(figure)
    return os.path.basename(path)


def by_graph(path, graphs, series, panels):
    """A point for each graph and solver, on logarithmic axes.

    series: {solver: {key: [value or None, by graph]}}; panels: [(title, key, {solver: what it has to reach})].
    """
    plt = figures.plt
    figure, axes = plt.subplots(len(panels), 1, figsize=(max(5.0, 0.8 * len(graphs)), 2.1 * len(panels)), sharex=True, squeeze=False)
    for axis, (title, key, limits) in zip(axes[:, 0], panels):
        for s, (solver, found) in enumerate(series.items()):
            points = [(place, value) for place, value in enumerate(found[key]) if value]
            if points:
                axis.plot(*zip(*points), "o", color=figures.colour(s), markersize=5, label=solver)
            if solver in limits:
                axis.axhline(limits[solver], color=figures.colour(s), linewidth=0.8, linestyle="--")
        axis.set_yscale("log")
        axis.set_title(title, fontsize=10, loc="left")
    axes[-1, 0].set_xticks(range(len(graphs)), graphs, rotation=30, ha="right")
    handles = {label: handle for axis in axes[:, 0] for handle, label in zip(*axis.get_legend_handles_labels())}
    figure.legend(handles.values(), handles.keys(), loc="lower center", ncol=max(1, len(handles)), frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    figure.savefig(path, bbox_inches="tight")
    plt.close(figure)
