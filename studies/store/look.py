"""What is found in the place of a block of trials, and the trials of a condition put together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from studies.design import Condition, Plan
from studies.store.shards import BEFORE, Columns, DamageError, ForeignError
from studies.store.store import NOMINAL, Store, StoreError


@dataclass(frozen=True)
class Shard:
    """What was found in the place of a block: whole, missing, short, or damaged with the reason."""

    condition: Condition
    block: int
    state: str
    reason: str = ""


def look_at(store: Store, plan: Plan, condition: Condition, block: int) -> Shard:
    """Read a shard and say what it is. Raises StoreError if it is whole and of another study."""
    try:
        columns = store.read_shard(condition.id, block, plan.study.trials.block)
        if block == 0:
            store.read_shard(condition.id, NOMINAL, 1 << 16)
    except FileNotFoundError:
        return Shard(condition, block, "missing")
    except ForeignError as error:
        raise StoreError(f"{store.shard_path(condition.id, block)} belongs to another study: {error}") from None
    except DamageError as error:
        return Shard(condition, block, "damaged", str(error))
    if any(m.key + BEFORE + "status" not in columns for m in plan.methods):
        return Shard(condition, block, "short", "methods were added")
    rows = len(next(iter(columns.values())))
    if rows < plan.stop(block) - block * plan.study.trials.block:
        return Shard(condition, block, "short", "trials were added")
    return Shard(condition, block, "whole")


def joined(store: Store, plan: Plan, condition: Condition, trials: int) -> tuple[Columns, Columns]:
    """The columns of the first trials of a condition, and its nominal ones. Raises DamageError, FileNotFoundError."""
    size = plan.study.trials.block
    blocks = -(-trials // size)
    parts = [store.read_shard(condition.id, block, size) for block in range(blocks)]
    if not parts:
        return {}, {}
    names = dict.fromkeys(name for part in parts for name in part)
    columns = {}
    for name in names:
        pieces = [part[name] if name in part else np.full(_rows(part), np.nan) for part in parts]
        columns[name] = np.concatenate(pieces)[:trials]
    return columns, store.read_shard(condition.id, NOMINAL, 1 << 16)


def _rows(part: Columns) -> int:
    return len(next(iter(part.values())))
