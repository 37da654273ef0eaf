"""Everything that the twin computes: components fitted for both readings of mu_xy, and both worlds flown."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from simfield import World, build_world, presets
from simfield.block import Floats
from simfield.scenario import Scenario
from studies.experiments import published
from studies.experiments.mauelshagen_1980 import Row, rows, run_trials, table1
from studies.experiments.mauelshagen_1980_twin import ap_sets, fixed, variances
from studies.experiments.mauelshagen_1980_twin.components import Component, all_components, scenario_with
from studies.experiments.mauelshagen_1980_twin.propagation import FIGURES, LinearRow, expected_squares
from studies.session import progress_bar

BASE = "rheidt-1980"
SAMPLED_WORLDS = 200
REFITS = 60
STARTS = 6
READINGS = {"2-D": 1.0, "coordinate": float(np.sqrt(2.0))}
"""what a published mu_xy has to be multiplied with to be the 2-D error"""


@dataclass(frozen=True, eq=False)
class Twin:
    """The worlds fitted under one reading of mu_xy, and their tables."""

    reading: str
    fit: variances.Fit
    refits: Floats
    fixed: fixed.FixedWorld
    random_scenario: Scenario
    fixed_scenario: Scenario
    table: pd.DataFrame
    table_fixed: pd.DataFrame


@dataclass(frozen=True, eq=False)
class TwinFindings:
    """The twins by reading, the components and the expected squares (figures, components) of each."""

    trials: int
    components: tuple[Component, ...]
    expected: Floats
    twins: dict[str, Twin]
    ap_sets: pd.DataFrame
    failures: list[str]


def compute(trials: int, jobs: int | None, seed: int) -> TwinFindings:
    """Fit, then fly `trials` whole experiments in each world. Raises ReproductionError if a row fails altogether."""
    experiment, components = rows(), all_components()
    base = build_world(presets[BASE], seed)
    failures: list[str] = []
    with threadpool_limits(1):
        linear = [LinearRow.of(base, row) for row in experiment]
        expected = expected_squares(linear, components)
        worlds = variances.sampled(linear, components, SAMPLED_WORLDS, seed)
        terms = fixed.terms_of(base)
        forms = fixed.quadratic_forms(linear, terms)
    twins = {}
    with progress_bar(2 * len(READINGS) * len(experiment), "adjustments of the twins") as bar:
        for reading in READINGS:
            with threadpool_limits(1):
                figures = published_figures(reading)
                fitted = variances.fit(figures, expected, worlds, components)
                refits = variances.refitted(fitted, worlds, components, REFITS)
                still = _fixed_world(figures, forms, expected, components, terms, seed)
            random_scenario = scenario_with(presets[BASE], f"twin, {reading}", _pairs(components, fitted.sizes))
            fixed_scenario = _fixed_scenario(base, still, reading)
            flown = [_flown(s, seed, experiment, trials, jobs, bar.update) for s in (random_scenario, fixed_scenario)]
            failures += [line for table in flown for line in table1.failures(experiment, table)]
            tables = [table1.table1(experiment, table) for table in flown]
            twins[reading] = Twin(reading, fitted, refits, still, random_scenario, fixed_scenario, *tables)
    with threadpool_limits(1):
        shown = (twins["2-D"].random_scenario, twins["2-D"].fixed_scenario)
        tested = ap_sets.tests([*(build_world(s, seed) for s in shown), base])
    return TwinFindings(trials, components, expected, twins, tested, failures)


def published_figures(reading: str) -> Floats:
    """(54): m0 um, mu_xy mm as a 2-D error, mu_z mm, row after row."""
    table = published.mauelshagen_table1()
    values = table[list(FIGURES)].to_numpy(float)
    values[:, 1] *= READINGS[reading]
    return np.asarray(values.ravel())


def _pairs(components: tuple[Component, ...], sizes: Floats) -> list[tuple[Component, float]]:
    return [(c, float(s)) for c, s in zip(components, sizes, strict=True)]


def _fixed_world(
    figures: Floats,
    forms: Floats,
    expected: Floats,
    components: tuple[Component, ...],
    terms: tuple[fixed.Term, ...],
    seed: int,
) -> fixed.FixedWorld:
    order = [Component("noise", "sww"), Component("noise", "ww"), Component("geodetic")]
    return fixed.search(figures, forms, expected[:, [components.index(c) for c in order]], terms, STARTS, seed)


def _fixed_scenario(base: World, still: fixed.FixedWorld, reading: str) -> Scenario:
    sizes = list(
        zip(
            (Component("noise", "sww"), Component("noise", "ww"), Component("geodetic")),
            still.random.tolist(),
            strict=True,
        )
    )
    plain = scenario_with(base.scenario, f"twin, fixed, {reading}", sizes)
    return replace(plain, effects=plain.effects + fixed.effects_of(still, base))


def _flown(
    scenario: Scenario, seed: int, experiment: list[Row], trials: int, jobs: int | None, report: Callable[[int], Any]
) -> pd.DataFrame:
    return run_trials(build_world(scenario, seed), experiment, trials, jobs, report)
