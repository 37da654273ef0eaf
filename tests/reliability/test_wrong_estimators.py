"""Estimators made wrong on purpose, through a whole study: its own figures must expose them."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from adjust.adjustment import Adjustment
from adjust.trials import replicates
from adjust.trials.chord import Chord
from adjust.trials.replicates import Replicates
from studies.trials import geometry
from tests.studies.small_study import TEXT, run_here, study

TRIALS = 960
STANDARD_ERRORS = 4.0
"""an honest figure is off by more once in 16 000 times, and the seed is fixed"""
SHRUNK = 0.8
COVERAGE_OF_SHRUNK, COVERAGE_OF_BIASED = 0.8831, 0.8300
"""of 95 % intervals that are 0.8 times as wide, and of true ones around an estimate that is one sigma off"""
UNKNOWNS = ("ww.a3", "centre.Z", "ww.Z0")

Figures = dict[str, tuple[float, float]]


@pytest.fixture(autouse=True)
def _nothing_ready() -> Iterator[None]:
    """What was prepared for other tests is right, what is prepared here is not."""
    geometry.forget()
    yield
    geometry.forget()


class ShrunkCofactors:
    """Cofactors of an adjustment that takes its standard errors for 0.8 times what they are."""

    def __init__(self, true: Any) -> None:
        self.true = true
        self.diagonal = SHRUNK**2 * true.diagonal

    def block(self, *places: Any) -> Any:
        return SHRUNK**2 * self.true.block(*places)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.true, name)


class Overconfident:
    """An adjustment with such cofactors."""

    def __init__(self, true: Adjustment) -> None:
        self.true = true
        self.cofactors = ShrunkCofactors(true.cofactors)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.true, name)


def figures(folder: Path) -> Figures:
    """Estimate and Monte-Carlo standard error by measure, of method `optical`."""
    asked = study(TEXT, ("[3.0, 6.0]", "[3.0]"), ("max = 96", f"max = {TRIALS}"), ("block = 32", "block = 480"))
    run_here(folder, asked)
    rows = csv.DictReader(io.StringIO((folder / "summary.csv").read_text(encoding="utf-8")))
    return {r["measure"]: (float(r["estimate"]), float(r["mcse"] or "nan")) for r in rows if r["ap"] == "optical"}


def off(found: Figures, measure: str, value: float) -> float:
    """How many Monte-Carlo standard errors lie between a figure and a value."""
    estimate, mcse = found[measure]
    return abs(estimate - value) / mcse


@pytest.mark.parametrize("unknown", UNKNOWNS)
def test_right_estimators_are_not_accused(tmp_path: Path, unknown: str) -> None:
    found = figures(tmp_path)
    assert off(found, f"coverage {unknown}", 0.95) < STANDARD_ERRORS
    assert off(found, f"model_se_error {unknown}", 0.0) < STANDARD_ERRORS
    assert off(found, f"bias {unknown}", 0.0) < STANDARD_ERRORS


def test_standard_errors_too_small_by_a_fifth_are_exposed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = geometry.prepared

    def overconfident(*arguments: Any) -> Chord:
        chord = real(*arguments)
        return replace(chord, nominal=Overconfident(chord.nominal))  # type: ignore[arg-type]

    monkeypatch.setattr(geometry, "prepared", overconfident)
    found = figures(tmp_path)
    for unknown in UNKNOWNS:
        assert off(found, f"coverage {unknown}", 0.95) > STANDARD_ERRORS
        assert off(found, f"coverage {unknown}", COVERAGE_OF_SHRUNK) < STANDARD_ERRORS
        assert off(found, f"model_se_error {unknown}", 0.0) > STANDARD_ERRORS
        assert off(found, f"model_se_error {unknown}", SHRUNK - 1.0) < STANDARD_ERRORS
        assert off(found, f"bias {unknown}", 0.0) < STANDARD_ERRORS
    assert off(found, "coverage_z", 0.95) > STANDARD_ERRORS


def test_a_bias_of_one_sigma_is_exposed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = replicates.adjust_prepared

    def biased(*arguments: Any, **named: Any) -> Replicates:
        found = real(*arguments, **named)
        sigma = found.sigma0.mean() * np.sqrt(found.nominal.cofactors.diagonal)
        return replace(found, trials=replace(found.trials, x=found.trials.x + sigma))

    monkeypatch.setattr(replicates, "adjust_prepared", biased)
    found = figures(tmp_path)
    for unknown in UNKNOWNS:
        sigma = found[f"model_se {unknown}"][0]
        assert off(found, f"bias {unknown}", 0.0) > STANDARD_ERRORS
        assert off(found, f"bias {unknown}", sigma) < STANDARD_ERRORS
        assert off(found, f"coverage {unknown}", 0.95) > STANDARD_ERRORS
        assert off(found, f"coverage {unknown}", COVERAGE_OF_BIASED) < STANDARD_ERRORS
        assert off(found, f"model_se_error {unknown}", 0.0) < STANDARD_ERRORS
    assert off(found, "coverage_z", 0.95) > STANDARD_ERRORS
    assert off(found, "mean_z_mm", 0.0) > STANDARD_ERRORS
