"""The full report of a study in Markdown: question, world, design, methods, trials, results, provenance, again.

The parts that report.md has too are the same functions; nothing is said twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from studies.design import Plan, factor_named, factor_names, level_label, references
from studies.pages import study_drawings, study_report
from studies.pages.scenario_sheet import measuring_page, scenario_page
from studies.pages.study_drawings import Drawn, TrialErrors
from studies.summary import Summary
from studies.texts import escaped, fenced

Add = Callable[[Drawn], str]
"""keeps a figure and gives the line of Markdown that shows it"""
MOST_ROWS = 40


def page(summed: Summary, plan: Plan, manifest: Mapping[str, Any], trials: Sequence[TrialErrors], add: Add) -> str:
    """The report. trials: those of the zip plots, none if the store has no shards here."""
    parts = (
        _opening(summed, plan),
        _world(plan, add),
        _design(plan),
        _methods(plan),
        _counts(summed, plan),
        _results(summed, plan, add),
        _unknowns(summed, plan, trials, add),
        study_report.differences(summed, plan),
        _provenance(plan, manifest),
        _again(plan),
    )
    return "\n".join("\n".join(part) for part in parts)


def _opening(summed: Summary, plan: Plan) -> Iterator[str]:
    yield f"# {escaped(plan.study.name)}\n"
    yield "## Question\n"
    yield escaped(plan.study.study.question) + "\n"
    yield study_report.what_was_run(summed, plan) + "\n"


def _world(plan: Plan, add: Add) -> Iterator[str]:
    yield "## World\n"
    first = plan.conditions[0]
    if len(plan.conditions) > 1:
        yield f"Described and drawn is the first of {len(plan.firsts)} conditions: {escaped(str(first))}.\n"
    yield scenario_page(first.scenario)
    if first.measuring is not None:
        yield measuring_page(first.measuring)
    try:
        yield from (add(drawn) for drawn in study_drawings.world(first))
    except (ArithmeticError, ValueError) as error:
        yield f"It cannot be drawn: {escaped(str(error))}.\n"


def _design(plan: Plan) -> Iterator[str]:
    study = plan.study
    yield "## Design\n"
    names = factor_names(study)
    if not names:
        yield "One condition; nothing varies in the world.\n"
    else:
        yield "| factor | acts on | levels |\n| --- | --- | --- |"
        for name in names:
            paths = ", ".join(factor_named(name, study).paths) or "nothing, it labels"
            times = " (times)" if factor_named(name, study).times else ""
            yield f"| {escaped(name)} | {escaped(paths)}{times} | {_levels(plan, name)} |"
        yield ""
        yield f"{len(plan.firsts)} conditions: crossed factors, and rows of factors that move together.\n"
    stop = ", ".join(f"{escaped(k)} {v:g}" for k, v in study.trials.target_mcse.items())
    targets = f"; from {study.trials.min} on a condition stops when these standard errors are reached: {stop}"
    shared = f" Share their random numbers: {', '.join(map(escaped, study.paired.factors))}."
    yield (
        f"At most {plan.trials} trials a {'condition' if study.trials.geometries == 1 else 'geometry'}, in blocks of "
        f"{study.trials.block}{targets if stop else ''}. "
        f"Seed {study.study.seed}.{shared if study.paired.factors else ''}\n"
    )


def _levels(plan: Plan, name: str) -> str:
    labels = dict.fromkeys(str(level_label(condition.levels[name])) for condition in plan.firsts)
    return ", ".join(escaped(label) for label in labels)


def _methods(plan: Plan) -> Iterator[str]:
    yield "## Methods\n"
    keys = ["ap", "cameras", "aux_points", "image_um", "control_mm"]
    against = references(plan.study)
    yield "| method | parameters | compared with |\n| --- | ---: | --- |"
    for method in plan.methods[:MOST_ROWS]:
        # a set of the user's own is code, and a report runs none
        own = ":" in method.model
        parameters = study_report.DASH if own else str(len(method.ap_model().parameters))
        yield f"| {escaped(method.key)} | {parameters} | {escaped(against.get(method.key, study_report.DASH))} |"
    yield ""
    if len(plan.methods) > MOST_ROWS:
        yield f"The first {MOST_ROWS} of {len(plan.methods)} methods.\n"
    told = {key: sorted({str(m.columns[key]) for m in plan.methods}) for key in keys[3:]}
    yield (
        "Parameters are counted for one camera. What the adjustment is told of the standard deviation of image "
        f"coordinates, um: {escaped(', '.join(told['image_um']))}; of control, mm: "
        f"{escaped(', '.join(told['control_mm']))} (`scenario`: as the world has it).\n"
    )


def _counts(summed: Summary, plan: Plan) -> Iterator[str]:
    yield "## Trials and failures\n"
    cells = {(row["condition"], row["method"]): row for row in summed.rows if row["measure"] == "failure_share"}
    failed = {key: row for key, row in cells.items() if row["failures"]}
    ran = sum(row["n"] + row["failures"] for row in cells.values())
    lost = sum(row["failures"] for row in cells.values())
    yield f"{ran} adjustments in {len(cells)} cells of condition and method; {lost or 'none'} failed.\n"
    if failed:
        names = [*factor_names(plan.study), "method"]
        yield from study_report.table(list(failed.values()), names)
        yield ""
    yield from (f"- {escaped(line)}" for line in (*summed.failures, *summed.notes))
    yield ""


def _results(summed: Summary, plan: Plan, add: Add) -> Iterator[str]:
    yield "## Results\n"
    yield "Behind ± stands the Monte-Carlo standard error; bars are 95 % Monte-Carlo intervals.\n"
    shown: dict[str, list[str]] = {}
    for measure, drawn in study_drawings.measures(summed, plan):
        shown.setdefault(measure, []).append(add(drawn))
    for measure, heading, lines in study_report.by_measure(summed, plan):
        yield f"### {heading}\n"
        yield from shown.get(measure, ())
        yield from lines
        yield ""
    yield from study_report.ranked(summed, plan)


def _unknowns(summed: Summary, plan: Plan, trials: Sequence[TrialErrors], add: Add) -> Iterator[str]:
    first = plan.conditions[0]
    drawn = [
        ("Biases", study_drawings.biases(summed, plan, first.id)),
        ("Coverage", study_drawings.zips(trials)),
        ("Correlations", study_drawings.correlations(summed, plan, first.id)),
    ]
    parts = [(title, [add(each) for each in found]) for title, found in drawn]
    if not any(lines for _, lines in parts):
        return
    yield "## Single unknowns\n"
    which = f"Condition: {escaped(str(first))}. " if len(plan.conditions) > 1 else ""
    yield (
        f"{which}One method for each set of additional parameters, of all other choices the last. Of points, `edge` is "
        "the one farthest from the centre of the field, `centre` the nearest; of images that nearest to it.\n"
    )
    for title, lines in parts:
        if lines:
            yield f"### {title}\n"
            yield from lines
    if not trials:
        yield "Zip plots of coverage need the single trials, which are not in this folder.\n"


def _provenance(plan: Plan, manifest: Mapping[str, Any]) -> Iterator[str]:
    yield "## Provenance\n"
    versions = manifest.get("versions")
    rows = {
        **(versions if isinstance(versions, dict) else {}),
        "python": manifest.get("python"),
        "processor": manifest.get("processor"),
        "BLAS": manifest.get("blas"),
        "study, SHA-256": plan.identity_hash,
    }
    yield from provenance_table(rows)


def provenance_table(rows: Mapping[str, Any]) -> Iterator[str]:
    """What was used, line by line, in Markdown."""
    yield "| | |\n| --- | --- |"
    said = {name: value for name, value in rows.items() if value is not None}
    yield from (f"| {escaped(str(name))} | {escaped(str(value))} |" for name, value in said.items())
    yield ""


def _again(plan: Plan) -> Iterator[str]:
    study = plan.study
    yield "## Again\n"
    yield f"    simfield run study.toml --trials {plan.trials} --seed {study.study.seed} --out {study.name}\n"
    yield (
        "with the study.toml that lies beside the summary; the results are the same bytes for any number of processes. "
        "`simfield verify` reads a store again and computes some of its trials, `simfield replay` one of them.\n"
    )
    yield fenced(study.text)
