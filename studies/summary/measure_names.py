"""Which measures a study can have, and which of those that it names it has not.

A name that does not exist gives no table, and a target for it is never reached, so it is refused before
anything is run.
"""

from __future__ import annotations

import fnmatch
from collections.abc import Iterator

from simfield.block import nearest
from studies.design import Plan
from studies.store import DEVIATIONS, described

OF_A_TRIAL = (*DEVIATIONS, "aic", "bic", "parameters", "significant", "largest_ap_exterior", "condition_number")
OF_A_CELL = ("failure_share",)
"""formed of all trials, and so no target of theirs"""
OF_AN_UNKNOWN = ("bias", "emp_se", "model_se", "model_se_error", "rmse", "coverage")
OF_A_PAIR = ("correlation", "formal_correlation")


def unknowns_of(plan: Plan) -> tuple[str, ...]:
    """The unknowns that are followed in any method: "ww.a3", "ww.Z0", "centre.Z"."""
    return tuple(dict.fromkeys(each["name"] for names in described(plan)["unknowns"].values() for each in names))


def measure_faults(plan: Plan) -> Iterator[str]:
    """A line for each measure that is named in a study and that it cannot have."""
    unknowns = unknowns_of(plan)
    report, trials = plan.study.report, plan.study.trials
    named = [(f"report.measures[{number}]", measure) for number, measure in enumerate(report.measures)]
    named += [("report.rank_by", report.rank_by)] if report.rank_by else []
    for place, measure in named:
        if not _exists(measure, unknowns):
            yield f"{place}: there is no measure {measure!r}{_hint(measure, unknowns)}"
    single = [*OF_A_TRIAL, *(f"{form} {name}" for form in OF_AN_UNKNOWN for name in unknowns)]
    for pattern in trials.target_mcse:
        if not fnmatch.filter(single, pattern):
            yield f"trials.target_mcse.{pattern}: fits no measure that a trial can reach{_hint(pattern, unknowns)}"


def _exists(measure: str, unknowns: tuple[str, ...]) -> bool:
    form, _, name = measure.partition(" ")
    if not name:
        return form in (*OF_A_TRIAL, *OF_A_CELL)
    if form in OF_A_PAIR:
        first, _, second = name.partition("~")
        return first in unknowns and second in unknowns and first.split(".")[0] == second.split(".")[0]
    return form in OF_AN_UNKNOWN and name in unknowns


def _hint(measure: str, unknowns: tuple[str, ...]) -> str:
    """What is nearest, or what there is."""
    form, _, name = measure.partition(" ")
    if not name:
        return nearest(form, (*OF_A_TRIAL, *OF_A_CELL))
    if form not in (*OF_AN_UNKNOWN, *OF_A_PAIR):
        return nearest(form, (*OF_AN_UNKNOWN, *OF_A_PAIR))
    return nearest(name.partition("~")[0], unknowns)
