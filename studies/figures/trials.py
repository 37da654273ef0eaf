"""Figures of many trials: coverage as a zip plot, biases as lollipops, many factors as a nested loop.

Sources: Morris, White & Crowther 2019 (zip plot and lollipops), Ruecker & Schwarzer 2014 (nested-loop plot).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from simfield.block import Floats
from studies.figures.canvas import BLACK, BLUE, COLOURS, GREY, VERMILION, literal
from studies.figures.images import DASHES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_INTERVALS = 250
"""that are drawn in a zip plot; with more trials every k-th stands for its neighbours"""
INTERVAL = 1.96
LINEAR_UNTIL, LINEAR_WITHIN = 1.5, 0.1
"""the axis of a lollipop plot is linear up to the first, else between plus and minus the second"""
MOST_LEVELS = 44
"""characters of the levels of a factor that are named one by one"""
TRACE_SHARE = 0.34
"""of the height of a nested-loop plot, for the levels of the factors below the curves"""


def zip_plot(axes: Axes, error: Floats, std: Floats, t: float, level: float = 0.95) -> None:
    """The intervals error +- t std of n trials, the worst on top; those that miss the truth (0) in another colour.

    error and std (n) are in the same unit; the axis is in mean standard errors. If standard errors are true, the upper
    5 % miss: the dotted line.
    """
    order = np.argsort(np.abs(error) / std)
    rank = 100.0 * (np.arange(len(order)) + 0.5) / len(order)
    chosen = np.unique(np.linspace(0, len(order) - 1, min(len(order), MOST_INTERVALS)).round().astype(int))
    unit = float(np.sqrt(np.mean(std**2)))
    middle, half = error[order][chosen] / unit, t * std[order][chosen] / unit
    misses = np.abs(middle) > half
    for part, colour, label in ((~misses, BLUE, "contains the truth"), (misses, VERMILION, "misses it")):
        axes.hlines(
            rank[chosen][part], (middle - half)[part], (middle + half)[part], color=colour, linewidth=0.8, label=label
        )
    covered = float(np.mean(np.abs(error) <= t * std))
    mcse = float(np.sqrt(covered * (1.0 - covered) / len(error)))
    axes.axvline(0.0, color=BLACK, linewidth=0.8)
    axes.axhline(100.0 * level, color=BLACK, linewidth=0.8, linestyle=(0, (1.5, 1.5)))
    axes.axhspan(*(100.0 * (covered + sign * INTERVAL * mcse) for sign in (-1.0, 1.0)), color=GREY, alpha=0.35, lw=0)
    axes.set(ylim=(0, 100), yticks=(0, 25, 50, 75, 95), ylabel="trials, % (worst on top)")
    axes.set_xlabel(f"estimate − truth, standard errors\ncovered: {100 * covered:.1f} % ± {100 * mcse:.1f} %")
    axes.legend(loc="lower right", fontsize=7.5, frameon=True, framealpha=0.9, edgecolor="none")


def lollipops(axes: Axes, labels: Sequence[str], values: Floats, mcse: Floats, xlabel: str) -> None:
    """A stem from zero to each value (n), with its 95 % Monte-Carlo interval; blue where zero lies inside it."""
    places = np.arange(len(labels), dtype=float)
    half = INTERVAL * np.nan_to_num(mcse)
    away = np.abs(values) > half
    for part, colour, marker, label in (
        (~away, BLUE, "o", "0 lies inside the Monte-Carlo interval"),
        (away, VERMILION, "D", "0 lies outside"),
    ):
        if part.any():
            axes.hlines(places[part], 0.0, values[part], color=colour, linewidth=1.4, alpha=0.6)
            axes.errorbar(
                values[part], places[part], xerr=half[part], linestyle="none", marker=marker, markersize=4.2,
                color=colour, capsize=2.0, elinewidth=0.9, label=label,
            )  # fmt: skip
    axes.axvline(0.0, color=BLACK, linewidth=0.8)
    axes.set_yticks(places, [literal(name) for name in labels], fontsize=7.5)
    axes.set(ylim=(len(labels) - 0.5, -0.5), xlabel=xlabel)
    _readable_scale(axes, float(np.abs(values).max(initial=0.0)))
    axes.tick_params(axis="y", length=0)
    axes.grid(True, axis="x")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), fontsize=7.5, ncols=2)


def _readable_scale(axes: Axes, largest: float) -> None:
    """Linear up to LINEAR_UNTIL; beyond it logarithmic outside of it, so that one large value hides no other."""
    if largest <= LINEAR_UNTIL:
        axes.locator_params(axis="x", nbins=6)
        return
    axes.set_xscale("symlog", linthresh=LINEAR_WITHIN, linscale=0.6)
    places = [place for place in (0.1, 1.0, 10.0, 100.0, 1000.0) if place <= 1.6 * largest]
    ticks = [*(-place for place in reversed(places)), 0.0, *places]
    axes.set_xticks(ticks, [f"{tick:g}".replace("-", "−") for tick in ticks])
    axes.set_xlim(-1.6 * largest, 1.6 * largest)
    axes.minorticks_off()


def nested_loop(
    axes: Axes, factors: Mapping[str, Sequence[str]], series: Mapping[str, Floats], ylabel: str, *, log: bool = False
) -> None:
    """Curves over all combinations of many factors, side by side; below them steps say which level each factor has.

    factors: the level of each of n combinations, by name, the slowest first. series: values (n) by label. log: the
    scale of the curves is logarithmic.
    """
    combinations = len(next(iter(factors.values())))
    edges = np.arange(combinations + 1, dtype=np.float64) - 0.5
    for number, (label, values) in enumerate(series.items()):
        shown = np.log10(values) if log else np.asarray(values, dtype=float)
        # the first ones thicker, so that equal curves show below each other
        width = 1.5 if len(series) == 1 else max(1.0, 2.6 - 0.5 * number)
        axes.stairs(
            shown, edges, baseline=None, color=COLOURS[number % len(COLOURS)], label=literal(label),
            linewidth=width, linestyle=DASHES[number % len(DASHES)],
        )  # fmt: skip
    every = np.concatenate([np.asarray(v, dtype=float) for v in series.values()])
    every = np.log10(every) if log else every
    low, high = float(np.nanmin(every)), float(np.nanmax(every))
    span = (high - low) or max(abs(high), 1.0)
    room = span * TRACE_SHARE / (1.0 - TRACE_SHARE) * max(1.0, len(factors) / 3.0)
    _traces(axes, factors, edges, low - 0.08 * span, room)
    axes.set(xlim=(edges[0], edges[-1]), ylim=(low - 0.08 * span - room, high + 0.05 * span), ylabel=ylabel)
    ticks = _ticks(low, high, log=log)
    axes.set_yticks(ticks, [f"{10**tick:.3g}" if log else f"{tick:.4g}" for tick in ticks])
    axes.set_xticks([])
    axes.set_xlabel(f"{combinations} combinations, each a step")
    axes.grid(True, axis="y")
    axes.set_axisbelow(True)
    if len(series) > 1:
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), fontsize=7.5, ncols=3)


def _ticks(low: float, high: float, *, log: bool) -> list[float]:
    from matplotlib.ticker import MaxNLocator

    if not log:
        return [tick for tick in MaxNLocator(5).tick_values(low, high) if low <= tick <= high]
    decades = np.arange(np.floor(low), np.ceil(high) + 1.0)
    some = [decade + np.log10(m) for decade in decades for m in (1.0, 2.0, 5.0)]
    return [float(tick) for tick in some if low - 0.02 <= tick <= high + 0.02]


def _traces(axes: Axes, factors: Mapping[str, Sequence[str]], edges: Floats, top: float, room: float) -> None:
    """A row of steps for each factor, with the name above it and the levels where they first stand."""
    height = room / len(factors)
    for row, (name, levels) in enumerate(factors.items()):
        distinct = list(dict.fromkeys(levels))
        base, rise = top - (row + 0.92) * height, 0.42 * height / max(1, len(distinct) - 1)
        steps = base + rise * np.array([distinct.index(level) for level in levels])
        axes.stairs(steps, edges, baseline=None, color=BLACK, linewidth=0.9)
        levels_said = ", ".join(distinct)
        if len(levels_said) > MOST_LEVELS:
            levels_said = f"{len(distinct)} levels, {distinct[0]} to {distinct[-1]}"
        said = literal(f"{name}: {levels_said}")
        where = (edges[0] + 0.01 * len(levels), base + 0.5 * height)
        axes.text(*where, said, fontsize=7.5, va="bottom", clip_on=True, in_layout=False)
