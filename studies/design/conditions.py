"""Conditions of a study: grid x zip - exclude + include, each with an id from its content and a seed of its own.

A study of several geometries has each condition so many times, with other seeds of the world. What they share, the
levels, is told under the id of the first.
"""

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

    geometry: the number of its world, from 1, where there are several; situation: the id of the first of them.
    """

    id: str
    levels: Mapping[str, Any]
    scenario: Scenario
    seed: int
    measuring: Measuring | None = None
    geometry: int | None = None
    situation: str = ""

    @property
    def columns(self) -> dict[str, str | float | bool]:
        """The levels as columns of a table."""
        return {name: level_label(level) for name, level in self.levels.items()}

    @property
    def said(self) -> str:
        """The levels in words."""
        return ", ".join(f"{k} {v}" for k, v in self.columns.items()) or "the scenario itself"

    def __str__(self) -> str:
        return self.said + (f", geometry {self.geometry}" if self.geometry else "")


def factor_names(study: Study) -> list[str]:
    """The factors in the order of the file."""
    return [*study.grid, *(name for together in study.zip for name in together)]


def count(study: Study) -> int:
    """An upper bound of the number of conditions, those of all geometries, without building any."""
    crossed = math.prod(len(levels) for levels in study.grid.values())
    together = math.prod(min((len(levels) for levels in rows.values()), default=1) for rows in study.zip)
    return (crossed * together + len(study.include)) * study.trials.geometries


def combinations(study: Study) -> Iterator[dict[str, Any]]:
    """The levels of every condition, in the order of the file."""
    for levels in _crossed(study):
        if not any(_matches(levels, rule) for rule in study.exclude):
            yield levels
    yield from ({name: added[name] for name in factor_names(study)} for added in study.include)


def fits_any(study: Study, rule: Mapping[str, Any]) -> bool:
    """Whether a rule fits any combination of levels."""
    return any(_matches(levels, rule) for levels in _crossed(study))


def _crossed(study: Study) -> Iterator[dict[str, Any]]:
    """All combinations of levels, none left out."""
    crossed = [[(name, level) for level in levels] for name, levels in study.grid.items()]
    rows = [
        [list(zip(together, row, strict=True)) for row in zip(*together.values(), strict=True)]
        for together in study.zip
    ]
    for chosen in itertools.product(*crossed):
        for moved in itertools.product(*rows):
            yield dict([*chosen, *itertools.chain.from_iterable(moved)])


def _matches(levels: Mapping[str, Any], rule: Mapping[str, Any]) -> bool:
    return bool(rule) and all(_same(levels[name], value) for name, value in rule.items())


def _same(level: Any, wanted: Any) -> bool:
    return canonical(wanted) in (canonical(level), canonical(level_label(level)))


def conditions_of(study: Study) -> tuple[Condition, ...]:
    """All conditions of a study without faults. Raises ScenarioError where levels do not go together."""
    base = base_table(study)
    found: dict[str, Condition] = {}
    for levels in combinations(study):
        for condition in _geometries(study, base, levels):
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


def _geometries(study: Study, base: Mapping[str, Any], levels: Mapping[str, Any]) -> Iterator[Condition]:
    """A condition in each of its worlds."""
    scenario, measuring = situation(study, base, levels)
    table, first = scenario_as_table(scenario), ""
    for number in range(study.trials.geometries):
        unpaired = {k: v for k, v in levels.items() if k not in study.paired.factors}
        seed = condition_seed(study.study.seed, unpaired, number)
        said: dict[str, Any] = {"scenario": table, "seed": str(seed)}
        if measuring is not None:
            said["measuring"] = asdict(measuring)
        own = hashlib.sha256(canonical_text(said).encode()).hexdigest()[:16]
        first = first or own
        geometry = number + 1 if study.trials.geometries > 1 else None
        yield Condition(own, levels, scenario, seed, measuring, geometry, first)


def condition_seed(study_seed: int, unpaired: Mapping[str, Any], geometry: int = 0) -> int:
    """The seed of a world, from the study's seed, the levels of the factors that are not paired, and its number."""
    digest = hashlib.sha256(canonical_text(unpaired).encode()).digest()
    key = tuple(int.from_bytes(digest[i : i + 4], "little") for i in range(0, 16, 4))
    key += (geometry,) if geometry else ()
    word = np.random.SeedSequence(study_seed, spawn_key=key).generate_state(1, np.uint64)[0]
    return int(word) >> (64 - SEED_BITS)
