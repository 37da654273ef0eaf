"""Conditions of a study: grid x zip - exclude + include, each with an id from its content and a seed of its own."""

from __future__ import annotations

import copy
import hashlib
import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from simfield.scenario import Scenario, ScenarioError, scenario_as_table, scenario_from_table
from studies.design.factors import canonical, canonical_text, factor_named, level_label, put_level
from studies.design.measuring import Measuring, apart, measuring_of, whole
from studies.design.study import Factor, Study

MOST_CONDITIONS = 10_000
SEED_BITS = 63
IN_A_CHAIN = ("chain.", "reductions")


@dataclass(frozen=True)
class Condition:
    """One data-generating situation: the levels of all factors, the scenario they make, the seed of its world, and how
    its images are measured (None: by the scenario's own noise alone).
    """

    id: str
    levels: Mapping[str, Any]
    scenario: Scenario
    seed: int
    measuring: Measuring | None = None

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
    """The scenario that all conditions start from, as a table, with chain and reductions where they are said.

    Raises ScenarioError.
    """
    own, measured = apart(study.scenario)
    return {**scenario_as_table(scenario_from_table(own)), **whole(measured)}


def situation(study: Study, base: Mapping[str, Any], levels: Mapping[str, Any]) -> tuple[Scenario, Measuring | None]:
    """Scenario and measuring of some levels. Raises ScenarioError where they do not fit, StudyError for an unknown
    factor.
    """
    table = copy.deepcopy(dict(base))
    # a whole chain comes before its values
    for factor, level in sorted(((factor_named(n, study), v) for n, v in levels.items()), key=_of_a_part):
        for path in factor.paths:
            if path.startswith(IN_A_CHAIN) and "chain" not in table:
                raise ScenarioError(f'{path}: there is no chain; allowed: beside a chain, as chain = "psk-1969"')
        put_level(table, factor, level)
        own, measured = apart(table)
        table = own | whole(measured)
    own, measured = apart(table)
    return scenario_from_table(own), measuring_of(measured)


def _of_a_part(changed: tuple[Factor, Any]) -> bool:
    return "chain" not in changed[0].paths


def _condition(study: Study, base: Mapping[str, Any], levels: Mapping[str, Any]) -> Condition:
    scenario, measuring = situation(study, base, levels)
    seed = condition_seed(study.study.seed, {k: v for k, v in levels.items() if k not in study.paired.factors})
    said: dict[str, Any] = {"scenario": scenario_as_table(scenario), "seed": str(seed)}
    if measuring is not None:
        said["measuring"] = asdict(measuring)
    content = canonical_text(said)
    return Condition(hashlib.sha256(content.encode()).hexdigest()[:16], levels, scenario, seed, measuring)


def condition_seed(study_seed: int, unpaired: Mapping[str, Any]) -> int:
    """The seed of a world, from the study's seed and the levels of the factors that are not paired."""
    digest = hashlib.sha256(canonical_text(unpaired).encode()).digest()
    key = tuple(int.from_bytes(digest[i : i + 4], "little") for i in range(0, 16, 4))
    word = np.random.SeedSequence(study_seed, spawn_key=key).generate_state(1, np.uint64)[0]
    return int(word) >> (64 - SEED_BITS)
