"""What a study asks to be computed: conditions, methods, blocks of trials; and what its store must agree with."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from studies.block_task import BEFORE, BlockTask, Columns
from studies.conditions import Condition, base_table, conditions_of
from studies.methods import Method, methods_of
from studies.shards import DamageError, ForeignError
from studies.store import NOMINAL, SCHEMA, Store, StoreError
from studies.study import Study

MOST_DIFFERENCES = 10


@dataclass(frozen=True)
class Plan:
    """A study, laid out."""

    study: Study
    conditions: tuple[Condition, ...]
    methods: tuple[Method, ...]
    base: Mapping[str, Any]

    @classmethod
    def of(cls, study: Study) -> Plan:
        """Raises ScenarioError where levels do not go together."""
        return cls(study, conditions_of(study), methods_of(study), base_table(study))

    @property
    def trials(self) -> int:
        """The most trials that a condition can get."""
        return self.study.trials.max

    @property
    def blocks(self) -> int:
        """The most blocks that a condition can get."""
        return -(-self.trials // self.study.trials.block)

    def stop(self, block: int) -> int:
        """The number of the trial behind the last one of a block."""
        return min((block + 1) * self.study.trials.block, self.trials)

    def task(self, condition: Condition, block: int, lost: Mapping[int, str]) -> BlockTask:
        first = block * self.study.trials.block
        return BlockTask(condition, self.methods, block, first, self.stop(block), lost)

    def tasks(self) -> Iterator[tuple[Condition, int]]:
        """Every block of every condition, first blocks first."""
        for block in range(self.blocks):
            for condition in self.conditions:
                yield condition, block

    @property
    def identity(self) -> dict[str, Any]:
        """What must be the same for two runs to share a store; trials, levels and methods may be added."""
        study = self.study
        return {
            "schema": SCHEMA,
            "name": study.name,
            "seed": study.study.seed,
            "block": study.trials.block,
            "paired": sorted(study.paired.factors),
            "scenario": self.base,
        }

    @property
    def identity_hash(self) -> str:
        return hashlib.sha256(json.dumps(self.identity, sort_keys=True).encode()).hexdigest()

    def manifest(self, provenance: Mapping[str, Any]) -> dict[str, Any]:
        """What the store says about itself."""
        return {
            "identity": self.identity,
            "trials": self.trials,
            "methods": [m.key for m in self.methods],
            "conditions": {c.id: c.columns for c in self.conditions},
            **provenance,
        }

    def refuse_other(self, manifest: Mapping[str, Any]) -> None:
        """Raise StoreError, a line for each difference, if the manifest is that of another study."""
        lines = list(_differences("", manifest.get("identity", {}), self.identity))
        if not lines:
            ids = {c.id for c in self.conditions}
            gone = [labels for key, labels in manifest.get("conditions", {}).items() if key not in ids]
            lines = [f"condition {_levels(labels)} is in the store and no longer in the study" for labels in gone]
            kept = {m.key for m in self.methods}
            lines += [
                f"method {key!r} is in the store and no longer in the study"
                for key in manifest.get("methods", [])
                if key not in kept
            ]
        if lines:
            more = [f"and {len(lines) - MOST_DIFFERENCES} more"] if len(lines) > MOST_DIFFERENCES else []
            raise StoreError("\n".join([*lines[:MOST_DIFFERENCES], *more]))


def _levels(labels: Any) -> str:
    return (
        ", ".join(f"{k} {v}" for k, v in labels.items())
        if isinstance(labels, Mapping) and labels
        else "without factors"
    )


def _differences(place: str, old: Any, new: Any) -> Iterator[str]:
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        for key in dict.fromkeys([*new, *old]):
            yield from _differences(f"{place}.{key}".removeprefix("."), old.get(key), new.get(key))
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for number, pair in enumerate(zip(old, new, strict=True)):
            yield from _differences(f"{place}[{number}]", *pair)
    elif old != new:
        yield f"{place}: the store has {json.dumps(old)[:80]}, the study {json.dumps(new)[:80]}"


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
    import numpy as np

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
