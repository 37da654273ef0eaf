"""Does the engine promise what it keeps: sigma0 is 1 and 95 % intervals hold in 95 % of all blocks.

Noise as stated, control free of error, and the truth within the set of additional parameters. Seeds are fixed, so the
tests say the same every time. A correct engine passes each comparison at three standard errors with 997 of 1000 seeds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
import scipy.special
import scipy.stats

from adjust import adjust_block, ap_models
from simfield import build_world, presets
from simfield.block.block import Block, Floats
from simfield.disturbances.noise import Noise
from tests import synthetic

TRIALS = 200
STANDARD_ERRORS = 3.0
LEVEL = 0.95


@dataclass(frozen=True, eq=False)
class Trials:
    """sigma0 (t); AP estimates minus truth, and standard deviations (t, a); errors and deviations of points (t, n)."""

    redundancy: int
    sigma0: Floats
    ap_error: Floats
    ap_std: Floats
    point_error: Floats
    point_std: Floats


def adjusted(blocks: list[Block], model_id: str, ap: dict[str, Floats], coordinates: Floats) -> Trials:
    """Every block adjusted; ap by camera id and coordinates (n, 3) are the truth."""
    model = ap_models.get(model_id)
    rows = []
    for block in blocks:
        a = adjust_block(block, model)
        assert a.status.ok, a.message
        free = ~block.points.fixed
        rows.append(
            (
                a.sigma0,
                np.concatenate([a.ap[c].values - ap[c] for c in ap]),
                np.concatenate([a.ap[c].std for c in ap]),
                (a.points.values - coordinates)[free],
                a.points.std[free],
            )
        )
    return Trials(a.redundancy, *(np.array(column) for column in zip(*rows, strict=True)))


@pytest.fixture(scope="module")
def own() -> Trials:
    """Blocks of this test's own making, with a distortion that torlegard describes."""
    model = ap_models.get("torlegard")
    ap = {"ww": np.array([8e-5, -5e-5, -1.8e-8, 5e-13, 3e-7, -2e-7])}
    w = synthetic.world([(synthetic.WW, synthetic.fly(synthetic.WW, 10500.0))], synthetic.quincunx(), {"ww": model}, ap)
    rng = np.random.default_rng(2024)
    return adjusted([w.with_noise(rng).block for _ in range(TRIALS)], "torlegard", ap, w.coordinates)


def assert_sigma0_is_one(trials: Trials) -> None:
    """In the mean and in its spread: redundancy * sigma0^2 is chi-squared."""
    r = trials.redundancy
    expected = np.sqrt(2.0 / r) * np.exp(scipy.special.gammaln((r + 1) / 2) - scipy.special.gammaln(r / 2))
    spread = np.sqrt(1.0 - expected**2)
    standard_error = spread / np.sqrt(TRIALS)
    assert abs(trials.sigma0.mean() - expected) <= STANDARD_ERRORS * standard_error
    assert abs(trials.sigma0.mean() - 1.0) <= STANDARD_ERRORS * standard_error
    assert abs(trials.sigma0.std(ddof=1) / spread - 1.0) <= STANDARD_ERRORS / np.sqrt(2.0 * (TRIALS - 1))


def assert_intervals_cover(error: Floats, std: Floats, redundancy: int) -> None:
    """Over all parameters together; the parameters of one block are correlated, so trials are the sample."""
    half = scipy.stats.t.ppf(0.5 + LEVEL / 2.0, redundancy) * std
    inside = (np.abs(error) <= half).reshape(TRIALS, -1)
    share = inside.mean(axis=1)
    standard_error = share.std(ddof=1) / np.sqrt(TRIALS)
    assert abs(share.mean() - LEVEL) <= STANDARD_ERRORS * standard_error
    # one by one: with k parameters looked at, the worst may stand 1.5 standard errors further out
    each = np.sqrt(LEVEL * (1.0 - LEVEL) / TRIALS)
    assert (np.abs(inside.mean(axis=0) - LEVEL) <= (STANDARD_ERRORS + 1.5) * each).all()


def assert_unbiased(error: Floats) -> None:
    z = error.mean(axis=0) / (error.std(axis=0, ddof=1) / np.sqrt(TRIALS))
    assert np.abs(z).max() <= STANDARD_ERRORS + 1.5


def test_sigma0(own: Trials) -> None:
    assert_sigma0_is_one(own)


def test_intervals_of_the_additional_parameters(own: Trials) -> None:
    assert own.ap_error.shape == (TRIALS, 6)
    assert_intervals_cover(own.ap_error, own.ap_std, own.redundancy)
    assert_unbiased(own.ap_error)


def test_intervals_of_the_points(own: Trials) -> None:
    assert_intervals_cover(own.point_error, own.point_std, own.redundancy)
    assert_unbiased(own.point_error)


def test_a_shortened_interval_would_be_seen(own: Trials) -> None:
    """The test has the power to find standard deviations that are 20 % too small."""
    with pytest.raises(AssertionError):
        assert_intervals_cover(own.ap_error, 0.8 * own.ap_std, own.redundancy)


@pytest.mark.slow
def test_the_simulated_block_of_rheidt() -> None:
    """The simulator's block without effects and geodetic errors, noise as the block states it."""
    scenario = replace(presets["rheidt-1980"], effects=(), noise=Noise(image_um=4.0, geodetic_mm=0.0))
    world = build_world(scenario, seed=1980)
    observed = [world.observe(trial) for trial in range(TRIALS)]
    nothing = {c.camera_id: np.zeros(14) for c in observed[0][0].cameras}
    trials = adjusted([block for block, _ in observed], "brown14", nothing, observed[0][1].coordinates)
    assert trials.redundancy == 6010
    assert trials.ap_error.shape == (TRIALS, 28)
    assert_sigma0_is_one(trials)
    assert_intervals_cover(trials.ap_error, trials.ap_std, trials.redundancy)
    assert_unbiased(trials.ap_error)
    assert_intervals_cover(trials.point_error, trials.point_std, trials.redundancy)
    assert_unbiased(trials.point_error)
