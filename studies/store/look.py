"""What the shards of a store hold: what is found in the place of a block, and the columns of blocks put together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from studies.design import Condition, Plan
from studies.store.shards import BEFORE, Columns, DamageError, ForeignError
from studies.store.status_codes import ABSENT, CONVERGED
from studies.store.store import NOMINAL, Store, StoreError

MOST_NOMINAL = 1 << 16
"""rows of the nominal columns"""


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
            store.read_shard(condition.id, NOMINAL, MOST_NOMINAL)
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
    """The columns of the first trials of a condition, and its nominal ones. Raises DamageError, FileNotFoundError.

    A column that a block has not, though the method converged in it, is left out: another version of simfield wrote the
    block, and what the other blocks say is not what all trials say.
    """
    size = plan.study.trials.block
    blocks = -(-trials // size)
    parts = [store.read_shard(condition.id, block, size) for block in range(blocks)]
    if not parts:
        return {}, {}
    columns = {}
    for method in plan.methods:
        head = method.key + BEFORE
        for name in dict.fromkeys(name for part in parts for name in part if name.startswith(head)):
            if not any(_lacks(part, name, head + "status") for part in parts):
                columns[name] = np.concatenate([_column(part, name, head + "status") for part in parts])[:trials]
    return columns, store.read_shard(condition.id, NOMINAL, MOST_NOMINAL)


def _lacks(part: Columns, name: str, status: str) -> bool:
    return name not in part and status in part and bool(np.any(part[status] == CONVERGED))


def _column(part: Columns, name: str, status: str) -> npt.NDArray[Any]:
    """A column of a block, or what stands for it where the method has no results."""
    if name in part:
        return part[name]
    rows = len(next(iter(part.values())))
    return np.full(rows, ABSENT, dtype=np.int8) if name == status else np.full(rows, np.nan)
