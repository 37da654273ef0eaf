"""When a condition has enough trials.

A condition that has a target stops at the end of the first block, not before the minimum, at which every Monte-Carlo
standard error named is small enough. The decision looks at the first blocks only, in their order, so it is the same
for any number of processes; blocks behind it may exist and are not used. Coverage counts with a smoothed standard
error: a naive one stops when it happens to be small, and is then biased.
"""

from __future__ import annotations

import fnmatch
from collections.abc import Iterator

from studies.design import Condition, Plan
from studies.store import Columns, Store, joined
from studies.summary.cells import Cell, measured


def rounds(plan: Plan, store: Store, jobs: int, *, whole_study: bool = True) -> Iterator[list[tuple[Condition, int]]]:
    """The blocks that are needed next, until nothing is. A part of an array job cannot see the others and gets all."""
    if not plan.study.trials.target_mcse or not whole_study:
        yield list(plan.tasks())
        return
    size = plan.study.trials.block
    first = min(plan.blocks, -(-plan.study.trials.min // size))
    asked = dict.fromkeys((c.id for c in plan.conditions), first)
    yield [(c, block) for block in range(first) for c in plan.conditions]
    while True:
        unfinished = [
            c for c in plan.conditions if asked[c.id] < plan.blocks and stop_of(plan, store, c, asked[c.id]) is None
        ]
        if not unfinished:
            return
        step = max(1, -(-jobs // len(unfinished)))
        wanted = []
        for condition in unfinished:
            further = min(asked[condition.id] + step, plan.blocks)
            wanted += [(condition, block) for block in range(asked[condition.id], further)]
            asked[condition.id] = further
        yield wanted


def stop_of(plan: Plan, store: Store, condition: Condition, blocks: int) -> int | None:
    """The trials at which a condition stops early, looking at its first blocks; None if it goes on."""
    size, trials = plan.study.trials.block, plan.study.trials
    if not trials.target_mcse or blocks == 0:
        return None
    columns, nominal = joined(store, plan, condition, min(blocks * size, plan.trials))
    for block in range(-(-trials.min // size), blocks + 1):
        n = min(block * size, plan.trials)
        if n >= trials.min and _reached(plan, {k: v[:n] for k, v in columns.items()}, nominal):
            return n
    return None


def trials_of(plan: Plan, store: Store, condition: Condition) -> int:
    """The number of trials of a condition that count."""
    if not plan.study.trials.target_mcse:
        return plan.trials
    available = 0
    while available < plan.blocks and store.shard_path(condition.id, available).exists():
        available += 1
    stop = stop_of(plan, store, condition, available)
    return plan.trials if stop is None else stop


def _reached(plan: Plan, columns: Columns, nominal: Columns) -> bool:
    for method in plan.methods:
        cell = Cell.of(method.key, columns, nominal)
        if len(cell.error) < plan.study.trials.min:
            return False
        found = measured(cell)
        for pattern, target in plan.study.trials.target_mcse.items():
            named = fnmatch.filter(found, pattern)
            if cell.left_out and not named:
                return False  # what is not known is not reached
            for name in named:
                if not float(found[name].mcse[0]) <= target:
                    return False
    return True
