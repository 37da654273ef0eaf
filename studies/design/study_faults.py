"""What is wrong with a study that has the right form: one line for each fault, with its place."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from simfield.block import nearest, shown
from simfield.numerics import TOGETHER
from simfield.scenario import ScenarioError, scenario_from_table
from studies.design import conditions
from studies.design.factors import canonical, canonical_text, factor_named, level_label
from studies.design.measuring import apart, measuring_of
from studies.design.methods import KEYS, method_faults
from studies.design.study import LEAST_TRIALS, NAME, Study, StudyError

MOST_TRIALS = 10_000_000
MOST_GEOMETRIES = 1000
MOST_TRIALS_A_BLOCK = 8192


def faults_of(study: Study) -> list[str]:
    """All faults of a study; only what hangs on a fault (levels on a wrong scenario, whole conditions) waits for it."""
    faults = [*_heading(study), *_trials(study), *_report(study)]
    cameras: tuple[str, ...] | None = None
    wrong_scenario: list[str] = []
    try:
        own, measured = apart(study.scenario)
        cameras = tuple(c.camera_id for c in scenario_from_table(own).cameras)
        measuring_of(measured)
    except ScenarioError as error:
        wrong_scenario = [_inside("scenario", line) for line in str(error).splitlines()]
    faults += [*wrong_scenario, *method_faults(study, cameras)]
    shape = [*_factors(study), *_paired(study)]
    bound = conditions.count(study)
    if bound > conditions.MOST_CONDITIONS:
        return [*faults, *shape, f"grid: {bound} conditions, allowed: at most {conditions.MOST_CONDITIONS}"]
    if not wrong_scenario:
        shape += _levels(study)
    return faults + (shape or ([] if wrong_scenario else _together(study)))


def _inside(place: str, line: str) -> str:
    return line if line.startswith(place) else f"{place}.{line}"


def _heading(study: Study) -> Iterator[str]:
    if not NAME.match(study.study.name):
        yield f"study.name: found {shown(study.study.name)}, allowed: 1 to 64 of a-z, 0-9, _ and -"
    if not study.study.question.strip():
        yield "study.question: is empty; a study has a question"
    if study.study.seed < 0:
        yield f"study.seed: found {study.study.seed}, allowed: 0 and above"


def _trials(study: Study) -> Iterator[str]:
    trials = study.trials
    if not 1 <= trials.geometries <= MOST_GEOMETRIES:
        yield f"trials.geometries: found {trials.geometries}, allowed: 1 to {MOST_GEOMETRIES}"
    if not 0 <= trials.max <= MOST_TRIALS:
        yield f"trials.max: found {trials.max}, allowed: 0 to {MOST_TRIALS}"
    if trials.min < LEAST_TRIALS:
        yield f"trials.min: found {trials.min}, allowed: {LEAST_TRIALS} and above"
    if trials.block % TOGETHER or not TOGETHER <= trials.block <= MOST_TRIALS_A_BLOCK:
        yield f"trials.block: found {trials.block}, allowed: multiples of {TOGETHER} up to {MOST_TRIALS_A_BLOCK}"
    for name, target in trials.target_mcse.items():
        if target <= 0.0:
            yield f"trials.target_mcse.{name}: found {target:g}, allowed: a number > 0"


def _factors(study: Study) -> Iterator[str]:
    places = [(f"grid.{name}", name, levels) for name, levels in study.grid.items()]
    for number, together in enumerate(study.zip):
        places += [(f"zip[{number}].{name}", name, levels) for name, levels in together.items()]
        if len({len(levels) for levels in together.values()}) > 1:
            lengths = ", ".join(f"{name} {len(levels)}" for name, levels in together.items())
            yield f"zip[{number}]: factors that move together need as many levels: {lengths}"
    seen: set[str] = set()
    for place, name, levels in places:
        try:
            factor_named(name, study)
        except StudyError as error:
            yield f"{place}: {error}"
        if name in seen:
            yield f"{place}: {name} is a factor twice"
        if name in (*KEYS, "condition", "method", "measure", "unit", "n", "failures", "estimate", "mcse"):
            yield f"{place}: this name is that of another column; give the factor a name in [factors]"
        seen.add(name)
        if not levels:
            yield f"{place}: found [], allowed: at least one level"
        yield from _twice(place, levels) if place.startswith("grid") else ()
        yield from _look_alike(place, levels)
    for kind, rules in (("exclude", study.exclude), ("include", study.include)):
        for number, rule in enumerate(rules):
            yield from _rule(f"{kind}[{number}]", rule, conditions.factor_names(study), whole=kind == "include")


def _twice(place: str, levels: tuple[Any, ...]) -> Iterator[str]:
    seen: set[str] = set()
    for number, level in enumerate(levels):
        text = canonical_text(level_label(level))
        if text in seen:
            yield f"{place}[{number}]: {shown(level)} stands there twice"
        seen.add(text)


def _look_alike(place: str, levels: tuple[Any, ...]) -> Iterator[str]:
    """The number 1 beside the label "1": two conditions with one name in every table."""
    said: dict[str, Any] = {}
    for number, level in enumerate(levels):
        label = level_label(level)
        text = f"{label:g}" if isinstance(label, int | float) and not isinstance(label, bool) else str(label).lower()
        first = said.setdefault(text, label)
        if canonical(first) != canonical(label):
            yield f"{place}[{number}]: {shown(level)} looks like {shown(first)} before it; give one another label"


def _rule(place: str, rule: Mapping[str, Any], names: list[str], *, whole: bool) -> Iterator[str]:
    for name in rule:
        if name not in names:
            yield f"{place}.{name}: no factor of this study{nearest(name, names) if names else ''}"
    for name in names:
        if whole and name not in rule:
            yield f"{place}.{name}: is missing; an included condition names every factor"
    if not rule:
        yield f"{place}: is empty"


def _paired(study: Study) -> Iterator[str]:
    names = conditions.factor_names(study)
    for number, name in enumerate(study.paired.factors):
        if name not in names:
            hint = nearest(name, names) if names else ""
            yield f"paired.factors[{number}]: {name!r} is no factor of this study{hint}"
    for key, level in study.paired.against.items():
        if key not in study.methods:
            yield f"paired.against.{key}: no key of [methods]{nearest(key, study.methods)}"
        elif canonical(level) not in [canonical(known) for known in study.methods[key]]:
            yield f"paired.against.{key}: found {shown(level)}, allowed: one of its levels"


def _report(study: Study) -> Iterator[str]:
    names = [*conditions.factor_names(study), *KEYS]
    places = [("report.x", study.report.x)] if study.report.x else []
    places += [(f"report.series[{number}]", name) for number, name in enumerate(study.report.series)]
    for place, name in places:
        if name not in names:
            yield f"{place}: {name!r} is neither factor nor key of [methods]{nearest(name, names)}"
    if not 0.0 <= study.report.least_correlation <= 1.0:
        yield f"report.least_correlation: found {study.report.least_correlation:g}, allowed: 0 to 1"


def _levels(study: Study) -> list[str]:
    """Every level on its own, so that a wrong one is named and not each condition that has it."""
    base = conditions.base_table(study)
    places = [(f"grid.{name}", name, levels) for name, levels in study.grid.items()]
    for number, together in enumerate(study.zip):
        places += [(f"zip[{number}].{name}", name, levels) for name, levels in together.items()]
    faults = []
    chains = {name: levels[0] for _, name, levels in places if levels and _is_chain(name, study)}
    for place, name, levels in places:
        try:
            factor_named(name, study)
        except StudyError:
            continue  # named as unknown already
        for number, level in enumerate(levels):
            try:
                conditions.situation(study, base, {**chains, name: level})
            except ScenarioError as error:
                lines = [line for line in str(error).splitlines() if not _may_go_together(line)]
                faults += [f"{place}[{number}]: {line}" for line in lines]
    return faults


def _is_chain(name: str, study: Study) -> bool:
    """Whether a factor is a whole chain, without which its values are nowhere."""
    try:
        return "chain" in factor_named(name, study).paths
    except StudyError:
        return False


def _may_go_together(line: str) -> bool:
    """A contradiction within the scenario may vanish when the other factors have their levels too."""
    return not line.partition(": ")[2].startswith(("found", "unknown key", "there is no", "is missing"))


def _together(study: Study) -> list[str]:
    faults = [
        f"exclude[{number}]: fits no condition; allowed: levels of this study"
        for number, rule in enumerate(study.exclude)
        if not conditions.fits_any(study, rule)
    ]
    base = conditions.base_table(study)
    if not any(True for _ in conditions.combinations(study)):
        return [*faults, "exclude: leaves no condition; allowed: rules that leave at least one"]
    for levels in conditions.combinations(study):
        try:
            conditions.situation(study, base, levels)
        except ScenarioError as error:
            named = ", ".join(f"{k} = {shown(level_label(v))}" for k, v in levels.items())
            faults += [f"condition {named}: {line}" for line in str(error).splitlines()]
        if len(faults) > 20:
            return [*faults[:20], "and more conditions are impossible"]
    return faults
