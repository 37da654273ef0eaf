"""What a study asks to be computed: conditions, methods, blocks of trials."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from studies.design.conditions import Condition, base_table, conditions_of
from studies.design.methods import Method, methods_of
from studies.design.study import Study

SCHEMA = 1
"""of what identifies a study; another one makes every store another study's"""


@dataclass(frozen=True)
class BlockTask:
    """Trials first .. stop - 1 of a condition; lost: trials that are not computed any more, and what became of them."""

    condition: Condition
    methods: tuple[Method, ...]
    block: int
    first: int
    stop: int
    lost: Mapping[int, str] = field(default_factory=dict)

    def __len__(self) -> int:
        return self.stop - self.first

    @property
    def name(self) -> tuple[str, int]:
        return self.condition.id, self.block


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
    def situations(self) -> tuple[tuple[Condition, ...], ...]:
        """The conditions that share their levels, one a geometry."""
        found: dict[str, list[Condition]] = {}
        for condition in self.conditions:
            found.setdefault(condition.situation, []).append(condition)
        return tuple(tuple(of_one) for of_one in found.values())

    @property
    def firsts(self) -> tuple[Condition, ...]:
        """The first geometry of every situation, under whose id it is told."""
        return tuple(of_one[0] for of_one in self.situations)

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
