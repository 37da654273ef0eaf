"""The figures of a study's full report: its world, its measures, and what many trials say about single unknowns."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from simfield import Truth, build_world
from simfield.block import Block, Floats
from studies import figures
from studies.comparison import block_views
from studies.design import Condition, Plan, factor_names
from studies.figures import (
    MANY_LABELS,
    MOST_SERIES,
    house_style,
    literal,
    measure_over_factor,
    new_figure,
    series_of,
    svg,
    with_unit,
)
from studies.pages.study_report import plain
from studies.summary import Row, Summary, error_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH_MM = 100.0
"""of a figure: 1:1 on a phone, two side by side on a desk"""
LETTER_MM = 1.3
"""of the names that stand upright below an axis"""
MOST_PANELS = 6
MOST_COMBINATIONS, LEAST_COMBINATIONS = 216, 6
MOST_PARAMETERS = 16
RADIUS_EDGES_MM = np.arange(0.0, 171.0, 10.0)
FOLLOWED = "edge.Z"
"""the unknown of the zip plots: the height of the point farthest from the centre"""


@dataclass(frozen=True)
class Drawn:
    """A figure as an SVG file with its title; the title is plain text."""

    name: str
    title: str
    svg: str


@dataclass(frozen=True, eq=False)
class TrialErrors:
    """Errors and claimed standard errors (n) of one unknown under a method, and Student's t for its intervals."""

    method: str
    error: Floats
    std: Floats
    t: float


def world(condition: Condition) -> Iterator[Drawn]:
    """Plan, rays per point and radius histogram of a condition. Raises ArithmeticError, ValueError if it cannot be."""
    block, truth = build_world(condition.scenario, condition.seed).observe(0)
    # where everything was: the block itself may leave orientations and tie points open
    images, points = (
        replace(block.images, exterior=truth.exterior),
        replace(block.points, coordinates=truth.coordinates),
    )
    block = replace(block, images=images, points=points)

    def plan(figure: Figure) -> None:
        figures.field_plan(figure.subplots(), block, block_views.footprints(block))

    def rays(figure: Figure) -> None:
        axes = figure.subplots()
        marks = figures.rays_per_point(axes, block.points.coordinates[:, :2], block.rays)
        figures.rays_bar(figure, axes, marks)

    def radii(figure: Figure) -> None:
        figures.radius_histogram(figure.subplots(), _radii(block, truth), RADIUS_EDGES_MM)

    counted = f"{len(block.points)} points in {len(block.images)} images"
    yield _drawn("plan", "Plan of the field with the footprints of the images", f"A map of {counted}.", 108, plan)
    said = f"Every point is measured in {block.rays.min()} to {block.rays.max()} images."
    yield _drawn("rays", "Rays per point", said, 84, rays)
    said = f"{len(block.observations)} image points by their distance from the image centre."
    yield _drawn("radii", "Image points by radius", said, 76, radii)


def _radii(block: Block, truth: Truth) -> dict[str, Floats]:
    o = block.observations
    main = np.isin(block.points.ids, truth.main_points)[o.point]
    parts = {"all": np.full(len(o), True)} if main.all() else {"with auxiliary points": main | True, "without": main}
    return {k: np.histogram(np.hypot(*o.xy[v].T), RADIUS_EDGES_MM)[0].astype(float) for k, v in parts.items()}


def measures(summed: Summary, plan: Plan) -> Iterator[tuple[str, Drawn]]:
    """For each measure of the report its figures: over the factor x, and nested where there are many factors."""
    report, names = plan.study.report, [*factor_names(plan.study), *plan.study.methods]
    x = report.x or (names[0] if names else "")
    for number, measure in enumerate(report.measures):
        rows = [row for row in summed.rows if row["measure"] == measure and np.isfinite(row["estimate"])]
        if not rows:
            continue
        unit = rows[0]["unit"]
        if x:
            yield measure, _over_factor(f"measure-{number}", summed.rows, measure, unit, x, report.series or names)
        if nested := _nested(f"nested-{number}", rows, measure, unit, names):
            yield measure, nested


def _over_factor(name: str, rows: Sequence[Row], measure: str, unit: str, x: str, names: Sequence[str]) -> Drawn:
    series, labels = series_of(rows, measure, x, names)
    shown = min(len(series), MOST_SERIES)

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        measure_over_factor(axes, series, labels, x, measure, unit)
        if len(series) > 1:
            handles, said = axes.get_legend_handles_labels()
            figure.legend(
                handles[:MOST_SERIES], said[:MOST_SERIES], loc="outside lower center",
                ncols=2 if max(map(len, said)) < 28 else 1, fontsize=7.5,
            )  # fmt: skip

    ends = [float(part[1][i]) for part in series.values() for i in (np.argmin(part[1]), np.argmax(part[1]))]
    said = (
        f"{shown} series over {x}, with 95 % Monte-Carlo intervals; the values lie between {min(ends):.4g} and "
        f"{max(ends):.4g}{'' if unit == '1' else f' {unit}'}."
    )
    left = f"; {MOST_SERIES} of {len(series)} series" if len(series) > MOST_SERIES else ""
    legend = 4.2 * (-(-shown // (2 if max(map(len, series)) < 28 else 1))) if len(series) > 1 else 0.0
    upright = LETTER_MM * max(map(len, labels)) if len(labels) > MANY_LABELS else 0.0
    height = 68.0 + upright + legend
    return _drawn(name, f"{measure} over {x}{left}", said, height, draw)


def _nested(name: str, rows: Sequence[Row], measure: str, unit: str, names: Sequence[str]) -> Drawn | None:
    """A nested-loop plot, if two factors or more are left beside the one that makes the series."""
    levels = {n: list(dict.fromkeys(plain(row[n]) for row in rows)) for n in names}
    varying = [n for n in names if len(levels[n]) > 1]
    by = "ap" if "ap" in varying and len(levels["ap"]) <= 6 else ""
    factors = [n for n in varying if n != by]
    keys = sorted(
        {tuple(plain(row[n]) for n in factors) for row in rows},
        key=lambda key: [levels[n].index(level) for n, level in zip(factors, key, strict=True)],
    )
    if len(factors) < 2 or not LEAST_COMBINATIONS <= len(keys) <= MOST_COMBINATIONS:
        return None
    place = {key: number for number, key in enumerate(keys)}
    series: dict[str, Floats] = {}
    for row in rows:
        values = series.setdefault(str(row[by]) if by else measure, np.full(len(keys), np.nan))
        values[place[tuple(plain(row[n]) for n in factors)]] = row["estimate"]
    traces = {n: [key[i] for key in keys] for i, n in enumerate(factors)}

    def draw(figure: Figure) -> None:
        figures.nested_loop(figure.subplots(), traces, series, with_unit(measure, unit))

    said = f"Steps over {len(keys)} combinations of {', '.join(factors)}; the levels stand below the curves."
    return _drawn(name, f"{measure}, nested loop over {', '.join(factors)}", said, 70.0 + 5.0 * len(factors), draw)


def chosen_methods(plan: Plan) -> list[str]:
    """One method for each AP set: of all other keys the last level. At most MOST_PANELS."""
    last: dict[str, str] = {}
    for method in plan.methods:
        last[str(method.columns["ap"])] = method.key
    return list(last.values())[:MOST_PANELS]


def biases(summed: Summary, plan: Plan, condition: str) -> Iterator[Drawn]:
    """A lollipop plot for each chosen method: bias of every unknown in its standard deviations over trials."""
    for number, method in enumerate(chosen_methods(plan)):
        own = [row for row in summed.rows if row["condition"] == condition and row["method"] == method]
        values = {row["measure"]: row for row in own}
        unknowns = [m.removeprefix("bias ") for m in values if m.startswith("bias ")]
        usable = [u for u in unknowns if values.get(f"emp_se {u}", {}).get("estimate", 0.0) > 0.0]
        if not usable:
            continue
        spread = np.array([values[f"emp_se {u}"]["estimate"] for u in usable])
        bias = np.array([values[f"bias {u}"]["estimate"] for u in usable]) / spread
        mcse = np.array([error_of(values[f"bias {u}"]) for u in usable]) / spread
        away = int(np.sum(np.abs(bias) > figures.INTERVAL * np.nan_to_num(mcse)))
        said = f"Bias of {len(usable)} unknowns; for {away} of them zero lies outside the 95 % Monte-Carlo interval."

        def draw(figure: Figure, u: Sequence[str] = usable, b: Floats = bias, m: Floats = mcse) -> None:
            figures.lollipops(figure.subplots(), u, b, m, "bias / standard deviation over trials")

        yield _drawn(f"bias-{number}", f"Biases: {method}", said, 30.0 + 3.6 * len(usable), draw)


def zips(trials: Sequence[TrialErrors]) -> Iterator[Drawn]:
    """A zip plot for each method."""
    for number, each in enumerate(trials):
        covered = 100.0 * float(np.mean(np.abs(each.error) <= each.t * each.std))

        def draw(figure: Figure, e: TrialErrors = each) -> None:
            figures.zip_plot(figure.subplots(), e.error, e.std, e.t)

        said = f"Intervals of {len(each.error)} trials, the farthest from the truth on top; {covered:.1f} % cover it."
        yield _drawn(f"zip-{number}", f"Zip plot of {FOLLOWED}: {each.method}", said, 96.0, draw)


def correlations(summed: Summary, plan: Plan, condition: str) -> Iterator[Drawn]:
    """A heat map for each chosen method and camera: formal correlations above the diagonal, over trials below."""
    drawn = 0
    for method in chosen_methods(plan):
        own = {
            row["measure"]: float(row["estimate"])
            for row in summed.rows
            if row["condition"] == condition and row["method"] == method and "correlation " in row["measure"]
        }
        pairs = [m.removeprefix("formal_correlation ") for m in own if m.startswith("formal_correlation ")]
        unknowns = list(dict.fromkeys(name for pair in pairs for name in pair.split("~")))
        for camera in dict.fromkeys(name.split(".")[0] for name in unknowns):
            names = _in_order([name for name in unknowns if name.startswith(f"{camera}.")])
            if 2 <= len(names) <= MOST_PARAMETERS and drawn < MOST_PANELS:
                drawn += 1
                yield _heat_map(f"correlation-{drawn}", own, names, f"{camera}: {method}")


def _in_order(names: Sequence[str]) -> list[str]:
    """a2 before a10, Z0 last."""

    def key(name: str) -> tuple[bool, str, int]:
        text = name.split(".", 1)[1]
        digits = "".join(c for c in text if c.isdigit())
        return text == "Z0", text.rstrip("0123456789"), int(digits or 0)

    return sorted(names, key=key)


def _heat_map(name: str, own: Mapping[str, float], names: Sequence[str], title: str) -> Drawn:
    def matrix(kind: str) -> Floats:
        r = np.zeros((len(names), len(names)))
        for i, first in enumerate(names):
            for j, second in enumerate(names):
                r[i, j] = own.get(f"{kind} {first}~{second}", own.get(f"{kind} {second}~{first}", 0.0))
        return np.nan_to_num(r)

    formal = matrix("formal_correlation")

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        mesh = figures.correlation_matrix(
            axes, formal, matrix("correlation"), [literal(n.split(".", 1)[1]) for n in names]
        )
        figure.colorbar(mesh, ax=axes, shrink=0.8, label="correlation")

    said = (
        f"{len(names)} unknowns, formal above the diagonal, over trials below it, empty where small; the largest is "
        f"{np.abs(formal).max():.2f} in amount."
    )
    return _drawn(name, f"Correlations, {title}", said, min(92.0, 38.0 + 6.0 * len(names)), draw)


def _drawn(name: str, title: str, says: str, height_mm: float, draw: Callable[[Figure], Any]) -> Drawn:
    with house_style():
        figure = new_figure(WIDTH_MM, height_mm)
        draw(figure)
        return Drawn(name, title, svg(figure, title, says))
