"""Is the store what it should be? Everything is read again, and some trials are computed again, bit by bit."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from simfield.numerics import TOGETHER
from studies.design import Plan
from studies.session import processor, program
from studies.store import NOMINAL, Columns, Store, locked, look_at, other_program, programs_of, study_of
from studies.trials import Draw, compute, image_points

ELSEWHERE = 1e-9
"""relative difference that another type of processor may make"""
RECOMPUTED = 4
"""conditions of which some trials are computed again"""


def verify(folder: Path, say: Callable[[str], object], draw: Draw = image_points) -> list[str]:
    """A line for each defect. Raises StoreError, LockedError, OSError, StudyError."""
    plan = study_of(folder)
    with locked(folder, "verify"):
        store = Store(folder, plan.identity_hash)
        defects = list(_read_everything(store, plan))
        if not defects:
            say("every shard is whole")
            _say_by_whom(store, say)
            defects = list(_compute_some_again(store, plan, say, draw))
    return defects


def _say_by_whom(store: Store, say: Callable[[str], object]) -> None:
    """Which programs computed the trials, if it was not this one alone."""
    manifest = store.read_manifest() or {}
    if len(programs := programs_of(manifest)) > 1:
        said = "; ".join(", ".join(f"{name} {value}" for name, value in each.items()) for each in programs)
        say(f"trials of {len(programs)} programs are averaged here: {said}")
    elif other := other_program(manifest, program()):
        say(other)


def _read_everything(store: Store, plan: Plan) -> Iterator[str]:
    known = set()
    for condition, block in plan.tasks():
        path = store.shard_path(condition.id, block)
        known |= {path, store.shard_path(condition.id, NOMINAL)}
        shard = look_at(store, plan, condition, block)
        if shard.state == "missing" and plan.study.trials.target_mcse:
            continue  # a condition that has stopped early
        if shard.state != "whole":
            yield f"trials/{condition.id}/{block}.parquet is {shard.state}" + (
                f": {shard.reason}" if shard.reason else ""
            )
    for path in sorted((store.folder / "trials").rglob("*")):
        if path.is_file() and path not in known:
            yield f"{path.relative_to(store.folder)} belongs to no condition of the study"


def _compute_some_again(store: Store, plan: Plan, say: Callable[[str], object], draw: Draw) -> Iterator[str]:
    same = (store.read_manifest() or {}).get("processor") == processor()
    for number in np.unique(np.linspace(0, len(plan.conditions) - 1, RECOMPUTED).astype(int)):
        condition = plan.conditions[number]
        if not plan.trials or not store.shard_path(condition.id, 0).exists():
            continue
        task = plan.task(condition, 0, store.failed(condition.id))
        task = replace(task, stop=min(task.stop, TOGETHER))
        fresh, _, _ = compute(task, draw)
        kept = store.read_shard(condition.id, 0, plan.study.trials.block)
        yield from (f"condition {condition.id}: {line}" for line in _compared(fresh, kept, same))
        if other := sorted(set(fresh) ^ set(kept)):
            say(f"condition {condition.id}: only stored or only computed, so not compared: {', '.join(other)}")
        say(f"condition {condition.id}: {len(task)} trials computed again by {len(plan.methods)} methods")


def _compared(fresh: Columns, kept: Columns, same: bool) -> Iterator[str]:
    for name, values in fresh.items():
        if name not in kept:
            continue  # a column that the version which wrote the block did not know
        stored = kept[name][: len(values)]
        if same:
            equal = values.tobytes() == stored.astype(values.dtype).tobytes()
        else:
            scale = max(float(np.nanmax(np.abs(values), initial=0.0)), 1e-300)
            equal = bool(np.allclose(values / scale, stored / scale, rtol=0.0, atol=ELSEWHERE, equal_nan=True))
        if not equal:
            row = int(np.flatnonzero(~((values == stored) | ((values != values) & (stored != stored))))[0])
            yield f"{name}, trial {row}: stored {stored[row]!r}, computed again {values[row]!r}"
