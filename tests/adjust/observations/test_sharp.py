"""Observations far sharper than all others hold what they observe: as a limit, and not as noise of the last digits."""

from __future__ import annotations

import numpy as np
import pytest

from adjust import adjust_block, ap_models
from adjust.observations import ApPriors, Distances, StationPositions
from tests import synthetic

SHARP = [1e-6, 1e-9, 1e-12, 1e-15, 1e-20]
SAME = 1e-6
"""standard deviations; two sharpnesses differ by the square of the first"""
MODEL = ap_models.get("torlegard")


@pytest.fixture(scope="module")
def world(ww_world: synthetic.World) -> synthetic.World:
    return ww_world.with_noise(np.random.default_rng(9))


@pytest.mark.parametrize("sharp", SHARP)
@pytest.mark.parametrize("number", range(6))
def test_priors(world: synthetic.World, sharp: float, number: int) -> None:
    """Of each parameter, at a place two standard deviations off: as with one that is sharp enough."""
    free = adjust_block(world.block, MODEL)
    name, std = MODEL.parameters[number], free.ap["ww"].std[number]
    at = float(free.ap["ww"].values[number] + 2.0 * std)
    expected, found = (
        adjust_block(world.block, MODEL, observations=[ApPriors("ww", {name: (at, s * std)})]) for s in (1e-4, sharp)
    )
    assert found.status.ok, found.message
    assert abs(found.ap["ww"][name] - at) < 1e-4 * std
    rows = expected.points.std > 0.0
    np.testing.assert_allclose(
        (found.coordinates - expected.coordinates)[rows] / expected.points.std[rows], 0.0, atol=SAME
    )
    np.testing.assert_allclose(found.points.std[rows], expected.points.std[rows], rtol=1e-5)
    assert found.sigma0 == pytest.approx(expected.sigma0, rel=1e-6)


@pytest.mark.parametrize("sharp", SHARP)
def test_control(world: synthetic.World, sharp: float) -> None:
    """As if it were fixed; only the redundancy counts it on both sides."""
    fixed = adjust_block(world.controlled(synthetic.CONTROL).block, MODEL)
    found = adjust_block(world.controlled(synthetic.CONTROL, (1e-3 * sharp,) * 3).block, MODEL)
    assert found.status.ok, found.message
    rows = fixed.points.std > 0.0
    np.testing.assert_allclose((found.coordinates - fixed.coordinates)[rows] / fixed.points.std[rows], 0.0, atol=SAME)
    assert found.redundancy == fixed.redundancy
    assert found.sigma0 == pytest.approx(fixed.sigma0, rel=1e-6)


@pytest.mark.parametrize("sharp", SHARP)
def test_stations(world: synthetic.World, sharp: float) -> None:
    expected, found = (
        adjust_block(
            world.block,
            MODEL,
            observations=[
                StationPositions(world.block.images.ids[:3], world.exterior[:3, :3], np.full((3, 3), 1e-2 * s))
            ],
        )
        for s in (1e-4, sharp)
    )
    assert found.status.ok, found.message
    rows = expected.points.std > 0.0
    np.testing.assert_allclose(
        (found.coordinates - expected.coordinates)[rows] / expected.points.std[rows], 0.0, atol=SAME
    )
    assert found.sigma0 == pytest.approx(expected.sigma0, rel=1e-6)


def test_distances(world: synthetic.World) -> None:
    """A sharp distance lies across the axes, so that it takes digits from the normal equations: six here."""
    names, at = world.block.points.ids, world.coordinates
    ends = ((names[3], names[9]), (names[12], names[30]))
    lengths = np.array([np.linalg.norm(at[names.index(a)] - at[names.index(b)]) for a, b in ends]) + 0.01
    expected, found = (
        adjust_block(world.block, MODEL, observations=[Distances(ends, lengths, np.full(2, s))]) for s in (1e-6, 1e-7)
    )
    assert found.status.ok, found.message
    rows = expected.points.std > 0.0
    np.testing.assert_allclose(
        (found.coordinates - expected.coordinates)[rows] / expected.points.std[rows], 0.0, atol=10.0 * SAME
    )
