"""A study: a question, its factors, methods and trials, as values."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

NAME = re.compile(r"[a-z0-9_-]{1,64}\Z")
LEAST_TRIALS = 500
"""no condition is stopped early before it has so many trials: an early standard error is too easily too small"""


class StudyError(ValueError):
    """A study file that cannot be used; one line for each fault: place, what was found, what is allowed."""


@dataclass(frozen=True)
class Heading:
    """What the study is called and what it asks."""

    name: str
    question: str
    seed: int


@dataclass(frozen=True)
class Trials:
    """How many trials a condition gets: at most max; from min on it stops when every target_mcse is reached.

    geometries: in how many worlds, with fields, flights and points of their own, each condition is tried; each of them
    gets so many trials.
    """

    geometries: int = 1
    max: int = 1000
    min: int = LEAST_TRIALS
    block: int = 512
    target_mcse: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Factor:
    """Where a factor acts in the scenario; times: its levels multiply what stands there instead of replacing it."""

    paths: tuple[str, ...]
    times: bool = False


@dataclass(frozen=True)
class Paired:
    """factors share their random numbers between levels; methods are compared with those of the levels `against`."""

    factors: tuple[str, ...] = ()
    against: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Report:
    """What the figures show: measures over the factor x, a line for each combination of the factors `series` (none
    named: of all that vary), and correlations from least_correlation on; rank_by: a measure by which the report ranks
    the methods of each condition, the smallest first.
    """

    x: str = ""
    series: tuple[str, ...] = ()
    measures: tuple[str, ...] = ("m0_um", "mu_xy_mm", "mu_z_mm", "coverage_z")
    least_correlation: float = 0.3
    rank_by: str = ""


@dataclass(frozen=True)
class Study:
    """A study as its file says it; `text` is the file itself."""

    study: Heading
    scenario: Mapping[str, Any]
    methods: Mapping[str, tuple[Any, ...]]
    trials: Trials = field(default_factory=Trials)
    factors: Mapping[str, str | Factor] = field(default_factory=dict)
    grid: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    zip: tuple[Mapping[str, tuple[Any, ...]], ...] = ()
    exclude: tuple[Mapping[str, Any], ...] = ()
    include: tuple[Mapping[str, Any], ...] = ()
    paired: Paired = field(default_factory=Paired)
    report: Report = field(default_factory=Report)
    text: str = ""

    @property
    def name(self) -> str:
        return self.study.name

    def with_changes(self, *, trials: int | None = None, seed: int | None = None) -> Study:
        """The study with another number of trials or another seed, as given on the command line."""
        changed = self
        if trials is not None:
            changed = replace(changed, trials=replace(self.trials, max=trials))
        if seed is not None:
            changed = replace(changed, study=replace(self.study, seed=seed))
        return changed
