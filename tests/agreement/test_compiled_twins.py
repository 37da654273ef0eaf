"""Compiled twins beside their readable forms, number by number, where no other test compares the two directly."""

from __future__ import annotations

import numpy as np
import pytest

from adjust import Replicates, adjust_replicates, ap_models
from adjust.normals.band import BandFactor
from adjust.normals.band_inverse_compiled import band_cofactors
from adjust.normals.cofactors import Cofactors
from adjust.normals.normals import Plain
from adjust.normals.normals_compiled import Compiled
from adjust.trials import lane_copies, lane_copies_compiled
from simfield import World, build_world, presets
from simfield.numerics import WIDTH
from studies.comparison import measures
from studies.trials.trial_columns_compiled import point_deviations

ROUNDING = 1e-12
"""relative: sums in another order"""
INVERSE = 1e-9
"""relative: two factorisations of normal equations with a condition of up to 1e6"""
TRIALS = 11
"""more than one tile, and a last one that is not full"""


@pytest.fixture(scope="module")
def world() -> World:
    return build_world(presets["grid-small"], 3)


@pytest.fixture(scope="module")
def trials(world: World) -> Replicates:
    block, _ = world.observe(0)
    return adjust_replicates(block, ap_models.get("optical"), world.draws(0, TRIALS))


def test_trials_into_lanes() -> None:
    rng = np.random.default_rng(1)
    image_points, order = rng.standard_normal((TRIALS, 7, 2)), rng.permutation(7)
    plain, compiled = np.zeros((2, 7, 2, WIDTH)), np.zeros((2, 7, 2, WIDTH))
    lane_copies.transpose(image_points, order, plain)
    lane_copies_compiled.transpose(image_points, order, compiled)
    assert plain.tobytes() == compiled.tobytes()
    assert plain[1, 0, 1, 2] == image_points[10, order[0], 1]


def test_lanes_into_trials() -> None:
    x = np.random.default_rng(2).standard_normal((2, 5, WIDTH))
    plain, compiled = np.zeros((TRIALS, 5)), np.zeros((TRIALS, 5))
    lane_copies.untile(x, plain)
    lane_copies_compiled.untile(x, compiled)
    assert plain.tobytes() == compiled.tobytes()
    assert plain[9, 4] == x[1, 4, 1]


def test_given_coordinates_into_lanes() -> None:
    rng = np.random.default_rng(3)
    coordinates, origin = rng.standard_normal((TRIALS, 4, 3)), np.array([1.0, 2.0, 3.0])
    fixed = rng.random(12) < 0.5
    found = []
    for module in (lane_copies, lane_copies_compiled):
        given, start, x = np.zeros((2, 12, WIDTH)), np.zeros((2, 20, WIDTH)), np.ones((2, 20, WIDTH))
        module.give(coordinates, origin, fixed, 8, given, start, x)
        found.append((given, start, x))
    for plain, compiled in zip(*found, strict=True):
        assert plain.tobytes() == compiled.tobytes()
    assert found[0][0][1, 0, WIDTH - 1] == coordinates[0, 0, 0] - 1.0


def test_deviations_at_points_are_those_of_the_comparison(world: World, trials: Replicates) -> None:
    block, truth = world.observe(0)
    a = trials.nominal
    layout, role = a.layout, block.points.role
    q = a.cofactors.diagonal[layout.orientation :].reshape(-1, 3)
    found = np.empty((7, TRIALS))
    true, given = truth.coordinates - layout.origin, block.points.coordinates[None].copy()
    half = 1.96 * trials.sigma0
    free, check = role != "control", role == "check"
    point_deviations(
        trials.trials.x, layout.orientation, true, given, layout.origin, free, check, half, np.sqrt(q), found
    )
    for t in range(TRIALS):
        error = trials.points[t] - truth.coordinates
        against = (trials.points[t] - block.points.coordinates)[check]
        inside = np.abs(error) <= half[t] * np.sqrt(q)
        by_hand = [
            np.hypot(*(measures.root_mean_square(against[:, axis]) for axis in (0, 1))),
            measures.root_mean_square(against[:, 2]),
            np.hypot(*(measures.root_mean_square(error[free, axis]) for axis in (0, 1))),
            measures.root_mean_square(error[free, 2]),
            error[free, 2].mean(),
            inside[free, :2].mean(),
            inside[free, 2].mean(),
        ]
        np.testing.assert_allclose(found[:, t], by_hand, rtol=1e3 * ROUNDING, atol=ROUNDING)


def test_cofactors_inside_a_band_are_those_of_the_readable_arithmetic(
    trials: Replicates, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Compiled, "banded", True)
    a = trials.nominal
    compiled, plain = Compiled(a.groups), Plain(a.groups)
    factor = compiled.factorise(compiled.at(a.x))
    assert isinstance(factor, BandFactor)
    dense = Cofactors(a.layout, plain.factorise(plain.at(a.x)))
    diagonal, blocks = band_cofactors(factor)
    np.testing.assert_allclose(diagonal, dense.diagonal[: len(diagonal)], rtol=INVERSE)
    free = ~a.layout.held.any(axis=1)
    np.testing.assert_allclose(blocks[free], dense.points[free], rtol=INVERSE, atol=INVERSE * dense.points.max())
