"""Conditions of a study: grid x zip - exclude + include, each with an id from its content and a seed of its own."""

from __future__ import annotations

import hashlib
import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from simfield.scenario import Scenario, scenario_as_table, scenario_from_table
from studies.design.factors import canonical, canonical_text, factor_named, level_label, put_level
from studies.design.study import Study

MOST_CONDITIONS = 10_000
SEED_BITS = 63


@dataclass(frozen=True)
class Condition:
    """One data-generating situation: the levels of all factors, the scenario they make, and the seed of its world."""

    id: str
    levels: Mapping[str, Any]
    scenario: Scenario
    seed: int

    @property
    def columns(self) -> dict[str, str | float | bool]:
        """The levels as columns of a table."""
        return {name: level_label(level) for name, level in self.levels.items()}

    def __str__(self) -> str:
        return ", ".join(f"{k} {v}" for k, v in self.columns.items()) or "the scenario itself"


def factor_names(study: Study) -> list[str]:
    """The factors in the order of the file."""
    return [*study.grid, *(name for together in study.zip for name in together)]


def count(study: Study) -> int:
    """An upper bound of the number of conditions, without building any."""
    crossed = math.prod(len(levels) for levels in study.grid.values())
    together = math.prod(min((len(levels) for levels in rows.values()), default=1) for rows in study.zip)
    return crossed * together + len(study.include)


def combinations(study: Study) -> Iterator[dict[str, Any]]:
    """The levels of every condition, in the order of the file."""
    crossed = [[(name, level) for level in levels] for name, levels in study.grid.items()]
    rows = [
        [list(zip(together, row, strict=True)) for row in zip(*together.values(), strict=True)]
        for together in study.zip
    ]
    for chosen in itertools.product(*crossed):
        for moved in itertools.product(*rows):
            levels = dict([*chosen, *itertools.chain.from_iterable(moved)])
            if not any(_matches(levels, rule) for rule in study.exclude):
                yield levels
    yield from ({name: added[name] for name in factor_names(study)} for added in study.include)


def _matches(levels: Mapping[str, Any], rule: Mapping[str, Any]) -> bool:
    return bool(rule) and all(_same(levels[name], value) for name, value in rule.items())


def _same(level: Any, wanted: Any) -> bool:
    return canonical(wanted) in (canonical(level), canonical(level_label(level)))


def conditions_of(study: Study) -> tuple[Condition, ...]:
    """All conditions of a study without faults. Raises ScenarioError where levels do not go together."""
    base = base_table(study)
    found: dict[str, Condition] = {}
    for levels in combinations(study):
        condition = _condition(study, base, levels)
        found.setdefault(condition.id, condition)
    return tuple(found.values())


def base_table(study: Study) -> dict[str, Any]:
    """The scenario that all conditions start from, as a table. Raises ScenarioError."""
    return scenario_as_table(scenario_from_table(study.scenario))


def scenario_with(study: Study, base: Mapping[str, Any], levels: Mapping[str, Any]) -> Scenario:
    """The scenario of some levels. Raises ScenarioError where they do not fit, StudyError for an unknown factor."""
    import copy

    table = copy.deepcopy(dict(base))
    for name, level in levels.items():
        put_level(table, factor_named(name, study), level)
    return scenario_from_table(table)


def _condition(study: Study, base: Mapping[str, Any], levels: Mapping[str, Any]) -> Condition:
    scenario = scenario_with(study, base, levels) if levels else scenario_from_table(base)
    seed = condition_seed(study.study.seed, {k: v for k, v in levels.items() if k not in study.paired.factors})
    content = canonical_text({"scenario": scenario_as_table(scenario), "seed": str(seed)})
    return Condition(hashlib.sha256(content.encode()).hexdigest()[:16], levels, scenario, seed)


def condition_seed(study_seed: int, unpaired: Mapping[str, Any]) -> int:
    """The seed of a world, from the study's seed and the levels of the factors that are not paired."""
    digest = hashlib.sha256(canonical_text(unpaired).encode()).digest()
    key = tuple(int.from_bytes(digest[i : i + 4], "little") for i in range(0, 16, 4))
    word = np.random.SeedSequence(study_seed, spawn_key=key).generate_state(1, np.uint64)[0]
    return int(word) >> (64 - SEED_BITS)
