"""One trial of a study alone, in full words."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from simfield import build_world
from simfield.numerics import TOGETHER
from studies.design import Condition, Plan, StudyError
from studies.store import BEFORE, CONVERGED, DEVIATIONS, SENTENCES
from studies.trials import compute

BEGINNING = 4


def condition_named(plan: Plan, name: str) -> Condition:
    """The condition with an id that begins so, or with that number in the dry run, from 1. Raises StudyError."""
    if name.isdecimal() and 1 <= int(name) <= len(plan.conditions):
        return plan.conditions[int(name) - 1]
    found = [c for c in plan.conditions if c.id.startswith(name)] if len(name) >= BEGINNING else []
    if len(found) != 1:
        raise StudyError(
            f"no condition {name!r}; give the id, its beginning, or a number from 1 to {len(plan.conditions)}"
        )
    return found[0]


def replay(plan: Plan, condition: Condition, trial: int) -> Iterator[str]:
    """What a trial gives, line by line, told before each step so that a crash shows where it happens."""
    yield f"study {plan.study.name}, condition {condition.id}: {condition}"
    yield f"world seed {condition.seed}, trial {trial}"
    world = build_world(condition.scenario, condition.seed)
    yield f"{len(world.plan)} images, {len(world.place)} points, {len(world.image)} image points"
    task = plan.task(condition, trial // plan.study.trials.block, {})
    first = trial - trial % TOGETHER
    for method in plan.methods:
        yield f"{method.key}:"
        others = dict.fromkeys(range(first, trial), "crashed")
        alone = type(task)(condition, (method,), task.block, first, trial + 1, others)
        columns, _, reasons = compute(alone)
        own = {name.split(BEFORE, 1)[1]: values[-1] for name, values in columns.items()}
        status = int(own.pop("status"))
        yield f"  {SENTENCES.get(status, 'the adjustment failed')}" + "".join(f": {r}" for r in reasons.values())
        if status == CONVERGED:
            yield "  " + ", ".join(
                f"{name} {own[name]:.4g}" for name in DEVIATIONS if np.isfinite(own.get(name, np.nan))
            )
            yield "  " + ", ".join(f"{name} {value:.8g}" for name, value in own.items() if name not in DEVIATIONS)
