"""The report of a study, readable as it is: the question, what was run, tables with standard errors, a figure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from studies.design import Plan, Study, factor_names
from studies.figures import MANY_LABELS, MOST_SERIES, house_style, measure_over_factor, new_figure, save, series_of
from studies.summary import Row, Summary, error_of, ranking
from studies.texts import escaped

MOST_LINES = 60
DASH = "–"
LETTER_MM, HANDLE_MM = 1.15, 9.0
"""about what a letter of a legend, and the line before it, take"""


def write(summed: Summary, plan: Plan, folder: Path) -> list[Path]:
    """Write report.md and the figure. Raises OSError."""
    figures = _draw(summed, plan, folder)
    path = folder / "report.md"
    path.write_bytes(page(summed, plan, [f for f in figures if f.suffix == ".svg"]).encode())
    return [path, *figures]


def page(summed: Summary, plan: Plan, figures: Sequence[Path] = ()) -> str:
    """The report in Markdown."""
    study = plan.study
    lines = [f"# {escaped(study.name)}", "", escaped(study.study.question.strip()), ""]
    lines += [what_was_run(summed, plan), ""]
    for figure in figures:
        lines += [f"![{escaped(', '.join(study.report.measures))}]({figure.name})", ""]
    lines += ranked(summed, plan)
    for _, heading, table_lines in by_measure(summed, plan):
        lines += [f"## {heading}", "", *table_lines, ""]
    lines += differences(summed, plan)
    lines += [line for note in summed.notes for line in (f"{escaped(note[:1].upper() + note[1:])}.", "")]
    if summed.failures:
        lines += ["## Failures", "", *(f"- {escaped(line)}" for line in summed.failures), ""]
    return "\n".join(lines)


def by_measure(summed: Summary, plan: Plan) -> Iterator[tuple[str, str, Iterator[str]]]:
    """Every measure of the report that has rows: its name, its heading and the lines of its table."""
    names = [*factor_names(plan.study), *plan.study.methods]
    for measure in plan.study.report.measures:
        chosen = [row for row in summed.rows if row["measure"] == measure]
        if chosen:
            unit = "" if chosen[0]["unit"] == "1" else f", {chosen[0]['unit']}"
            yield measure, f"{escaped(measure)}{unit}", table(chosen, names)


def differences(summed: Summary, plan: Plan) -> Iterator[str]:
    """The differences between methods in the measures of the report, with a heading; nothing if there are none."""
    compared = [row for row in summed.differences if row["measure"] in plan.study.report.measures]
    if compared:
        together = max(Counter((row["condition"], row["measure"]) for row in compared).values())
        bound = ranking.largest_by_chance(together)
        yield "## Differences between methods, in pairs on the same trials"
        yield ""
        if together > 1:
            yield (
                f"Of a measure {together} differences stand beside each other in a condition. Where there are none, "
                f"one of them is beyond {bound:.2f} standard errors in one study of twenty (Sidak); those beyond have "
                "a star."
            )
            yield ""
        yield from table(compared, [*factor_names(plan.study), "method", "against", "measure", "unit"], bound)
        yield ""


def ranked(summed: Summary, plan: Plan) -> Iterator[str]:
    """A ranking for each condition, under its factors; nothing if the study asks for none."""
    report = plan.study.report
    if not report.rank_by:
        return
    yield f"## Ranked by {escaped(report.rank_by)}"
    yield ""
    yield (
        "In brackets the ranks that the trials leave possible: two methods are told apart where they differ by more "
        "than the largest difference of all pairs does by chance in one condition of twenty."
    )
    yield ""
    for condition in plan.firsts:
        yield f"### {escaped(condition.said)}"
        yield ""
        own = [row for row in summed.rows if row["condition"] == condition.id]
        yield from ranking.tables(own, summed.differences, report.measures, report.rank_by)


def what_was_run(summed: Summary, plan: Plan) -> str:
    """Conditions, methods, trials and how figures are to be read, in Markdown."""
    study = plan.study
    ran = sorted({row["n"] + row["failures"] for row in summed.rows})
    trials = f"{ran[0]}" if len(ran) == 1 else f"{ran[0]} to {ran[-1]}" if ran else "0"
    worlds = study.trials.geometries
    each = "each" if worlds == 1 else f"of each condition in {worlds} geometries together"
    error = (
        "the Monte-Carlo standard error of the one geometry that each condition has: with other seeds its field, "
        "flight and points, and with them these figures, differ by several of it"
        if worlds == 1
        else "the standard error over geometries and trials (geometry_se; mcse is that of the trials alone)"
    )
    return (
        f"{_counted(len(plan.firsts), 'condition')}, {_counted(len(plan.methods), 'method')}, {trials} trials "
        f"{each}, seed {study.study.seed}. Behind ± stands {error}. All methods of a condition see the same trials. "
        f"{_early(study)}Every figure is in summary.csv, the study itself in study.toml."
    )


def _early(study: Study) -> str:
    """What an early stop does to intervals."""
    if not study.trials.target_mcse:
        return ""
    return (
        "Conditions stop when standard errors are small enough, and stop too early where they happen to be: 95 % "
        "intervals of estimate and error hold in 92 to 94 %. "
    )


def _counted(number: int, thing: str) -> str:
    return f"{number} {thing}" + ("" if number == 1 else "s")


def table(rows: Sequence[Row], names: Sequence[str], bound: float = np.inf) -> Iterator[str]:
    """Rows in Markdown: the named columns, estimate ± standard error, n, failures; a star beyond `bound` errors."""
    yield "| " + " | ".join([*map(escaped, names), "estimate", "n", "failures"]) + " |"
    yield "| " + " | ".join(["---"] * len(names) + ["---:"] * 3) + " |"
    for row in rows[:MOST_LINES]:
        cells = [escaped(plain(row.get(name, ""))) for name in names]
        star = " \\*" if abs(row["estimate"]) > bound * error_of(row) else ""
        yield "| " + " | ".join([*cells, with_error(row) + star, str(row["n"]), str(row["failures"])]) + " |"
    if len(rows) > MOST_LINES:
        yield ""
        yield f"The first {MOST_LINES} of {len(rows)} lines; all are in summary.csv and differences.csv."


def with_error(row: Mapping[str, Any]) -> str:
    """Estimate ± standard error, over geometries where there are several, with digits that the error bears; a dash
    where there is nothing.
    """
    estimate, mcse = row["estimate"], error_of(row)
    if not np.isfinite(estimate):
        return DASH
    if not np.isfinite(mcse):
        return f"{estimate:.4g} ± {DASH}"
    if mcse <= 0.0:
        return f"{estimate:.4g}"
    power = int(np.floor(np.log10(mcse)))
    if -6 <= power <= 3:
        digits = max(0, 1 - power)
        return f"{estimate:.{digits}f} ± {mcse:.{digits}f}"
    return f"{estimate:.5g} ± {mcse:.2g}"


def plain(value: Any) -> str:
    """A level of a factor as text."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)


def side_by_side(labels: Sequence[str], width_mm: float) -> int:
    """How many columns of a legend fit beside each other, three at most."""
    return int(np.clip(width_mm // (LETTER_MM * max(map(len, labels)) + HANDLE_MM), 1, 3))


def _draw(summed: Summary, plan: Plan, folder: Path) -> list[Path]:
    """The measures of the report over its factor x, one axes each."""
    study = plan.study
    names = [*factor_names(study), *study.methods]
    x = study.report.x or (names[0] if names else "")
    measures = [
        m for m in study.report.measures if any(r["measure"] == m and np.isfinite(r["estimate"]) for r in summed.rows)
    ]
    if not measures or not x:
        return []
    with house_style():
        rows, columns = -(-len(measures) // 2), min(2, len(measures))
        many = len({str(row.get(x)) for row in summed.rows}) > MANY_LABELS
        figure = new_figure(90.0 * columns, (88.0 if many else 66.0) * rows + 22.0)
        grid: Any = figure.subplots(rows, columns, squeeze=False)
        units = {row["measure"]: row["unit"] for row in summed.rows}
        for axes, measure in zip(grid.ravel(), measures, strict=False):
            series, labels = series_of(summed.rows, measure, x, study.report.series or names)
            measure_over_factor(axes, series, labels, x, measure, units[measure])
        for axes in grid.ravel()[len(measures) :]:
            axes.set_visible(False)
        handles, said = grid[0, 0].get_legend_handles_labels()
        if len(said) > 1:
            shown = said[:MOST_SERIES]
            side = side_by_side(shown, 90.0 * columns)
            figure.legend(handles[:MOST_SERIES], shown, loc="outside lower center", ncols=side, fontsize=6.5)
        title = f"{study.name}: {', '.join(measures)}"
        return save(figure, folder / "figure", title, f"Each over {x}, with 95 % Monte-Carlo intervals.")
