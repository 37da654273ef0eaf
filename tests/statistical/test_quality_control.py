"""Do the tests of quality control hold their level, and have they the power that theory gives them?

Every rate is compared with theory at three Monte-Carlo standard errors; seeds are fixed.
"""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats

from adjust import adjust_block, ap_models
from adjust.quality.gross_errors import snoop
from adjust.quality.reliability import familywise, noncentrality, tau_critical, w_critical
from adjust.quality.significance import ap_significance, f_test, global_test
from adjust.quality.variance import variance_components
from simfield import presets, simulate
from simfield.block.block import Floats
from tests import synthetic
from tests.adjust.quality.test_variance import FACTORS, noisy
from tests.statistical.repeated import STANDARD_ERRORS, Repeated, assert_rate, error_free, noise, repeat

LEVELS = (0.001, 0.01, 0.05)
MODEL = ap_models.get("torlegard")


@pytest.fixture(scope="module")
def small() -> Repeated:
    """2000 trials of 12 images without any true additional parameter."""
    w = synthetic.world([(synthetic.WW, synthetic.fly(synthetic.WW, 10500.0))], synthetic.quincunx())
    return repeat(w.block, MODEL, noise(w.block, 2000, np.random.default_rng(77)))


class TestSize:
    @pytest.mark.parametrize("alpha", LEVELS)
    def test_of_data_snooping(self, small: Repeated, alpha: float) -> None:
        assert_rate(np.abs(small.w) > w_critical(alpha), alpha)
        redundancy = small.reliability.influence.adjustment.redundancy
        assert_rate(np.abs(small.tau) > tau_critical(redundancy, alpha), alpha)

    def test_of_a_whole_adjustment(self, small: Repeated) -> None:
        """At most the level that was asked for; nearly that, for the tests are nearly independent."""
        largest = np.abs(small.w).max(axis=1)
        share = np.mean(largest > w_critical(familywise(0.05, small.w.shape[1])))
        error = np.sqrt(0.05 * 0.95 / len(largest))
        assert 0.03 < share < 0.05 + STANDARD_ERRORS * error

    @pytest.mark.parametrize("alpha", LEVELS)
    def test_of_sigma0(self, small: Repeated, alpha: float) -> None:
        f = small.reliability.influence.adjustment.redundancy
        vpv = f * small.sigma0**2
        lower, upper = scipy.stats.chi2.ppf([alpha / 2, 1 - alpha / 2], f)
        assert_rate((vpv < lower) | (vpv > upper), alpha)
        first = next(small.adjustments())
        assert global_test(first, alpha).passed == (lower <= vpv[0] <= upper)

    def test_of_additional_parameters(self, small: Repeated) -> None:
        part = Repeated(*(getattr(small, n)[:400] if n != "reliability" else small.reliability for n in vars(small)))
        p, p_added, group = [], [], []
        for a in part.adjustments():
            found = ap_significance(a, "ww")
            p.append(found.p)
            p_added.append(found.p_added)
            group.append(f_test(a, ("ww", "a1"), ("ww", "a2"), ("ww", "a3")).p)
        for alpha in (0.01, 0.05, 0.2):
            assert_rate(np.array(p) < alpha, alpha)
            assert_rate(np.array(p_added) < alpha, alpha)
            assert_rate(np.array(group) < alpha, alpha)
        assert np.abs(np.corrcoef(np.array(p_added).T) - np.eye(6)).max() < 0.2, "z are independent of each other"


def planted(image_points: Floats, sigma: Floats, size: float, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """One error of `size` standard deviations a trial, in any coordinate; returns the image points and the rows."""
    spoiled = image_points.copy()
    rows = rng.integers(2 * image_points.shape[1], size=len(image_points))
    sign = rng.choice([-1.0, 1.0], len(rows))
    spoiled.reshape(len(rows), -1)[np.arange(len(rows)), rows] += sign * size * sigma.ravel()[rows]
    return spoiled, rows


def power(redundancy: Floats, size: float, alpha: float) -> Floats:
    """Of the test of an observation with an error of `size` standard deviations (Baarda)."""
    shift, critical = size * np.sqrt(redundancy), w_critical(alpha)
    return np.asarray(scipy.stats.norm.sf(critical - shift) + scipy.stats.norm.cdf(-critical - shift))


@pytest.mark.parametrize("size", [4.0, 6.0, 9.0])
def test_power_is_baardas(small: Repeated, size: float) -> None:
    block = small.reliability.influence.adjustment.block
    rng = np.random.default_rng(int(size))
    spoiled, rows = planted(small.image_points[:1000], block.observations.sigma, size, rng)
    found = repeat(block, MODEL, spoiled)
    hit = np.abs(found.w[np.arange(len(rows)), rows]) > w_critical(0.001)
    expected = power(small.reliability.redundancy[rows], size, 0.001)
    standard_error = np.sqrt(np.sum(expected * (1.0 - expected))) / len(rows)
    assert abs(hit.mean() - expected.mean()) <= STANDARD_ERRORS * max(standard_error, 1.0 / len(rows))


def test_the_detectable_bias_is_found_as_often_as_promised(small: Repeated) -> None:
    block = small.reliability.influence.adjustment.block
    rng = np.random.default_rng(5)
    rows = rng.integers(small.w.shape[1], size=1000)
    spoiled = small.image_points[:1000].copy()
    spoiled.reshape(1000, -1)[np.arange(1000), rows] += small.reliability.mdb[rows]
    found = repeat(block, MODEL, spoiled)
    assert_rate(np.abs(found.w[np.arange(1000), rows]) > w_critical(0.001), 0.8)
    assert noncentrality() * synthetic.SIGMA_MM < small.reliability.mdb.min()


@pytest.mark.slow
def test_variance_components_are_unbiased(two_camera_world: synthetic.World) -> None:
    """Two cameras of 0.7 and 1.5 times the stated noise: the factors of the variances, and their standard
    deviations.
    """
    trials = 200
    factor, std = [], []
    for seed in range(trials):
        found = variance_components(adjust_block(noisy(two_camera_world, 1000 + seed), ap_models.get("optical")))
        assert found.converged
        factor.append(found.factor)
        std.append(found.factor_std)
    # that of control has few degrees of freedom and a bound at 0
    values, expected = np.array(factor)[:, :2], np.array([FACTORS["ww"] ** 2, FACTORS["sww"] ** 2])
    spread = values.std(axis=0, ddof=1)
    assert (np.abs(values.mean(axis=0) - expected) <= STANDARD_ERRORS * spread / np.sqrt(trials)).all()
    ratio = spread / np.array(std).mean(axis=0)[:2]
    assert (np.abs(ratio - 1.0) <= STANDARD_ERRORS / np.sqrt(2.0 * (trials - 1))).all()


@pytest.fixture(scope="module")
def rheidt() -> Repeated:
    model = ap_models.get("brown14")
    block = error_free(simulate(presets["rheidt-1980"], seed=1)[0], model)
    return repeat(block, model, noise(block, 500, np.random.default_rng(6626)))


@pytest.mark.slow
class TestRheidt:
    def test_false_alarms(self, rheidt: Repeated) -> None:
        assert rheidt.w.shape == (500, 6626)
        for alpha in LEVELS:
            assert_rate(np.abs(rheidt.w) > w_critical(alpha), alpha)

    def test_an_error_of_12_sigma_is_found(self, rheidt: Repeated) -> None:
        """Found: the planted coordinate is accused first."""
        nominal = rheidt.reliability.influence.adjustment
        spoiled, rows = planted(rheidt.image_points, nominal.block.observations.sigma, 12.0, np.random.default_rng(12))
        found = repeat(nominal.block, ap_models.get("brown14"), spoiled)
        w = np.abs(found.w)
        accused = (w.argmax(axis=1) == rows) & (w.max(axis=1) > w_critical(familywise(0.01, w.shape[1])))
        assert accused.mean() >= 0.99
        for trial, a in zip(range(3), found.adjustments(), strict=False):
            searched = snoop(a, familywise(0.01, a.observations))
            assert rows[trial] in [each.row for each in searched.accused]
