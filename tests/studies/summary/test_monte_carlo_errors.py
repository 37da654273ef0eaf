"""Errors of means, quantiles and resampled figures, beside the scatter of many repetitions and beside theory."""

from __future__ import annotations

from math import isnan

import numpy as np
import pytest
from scipy.stats import norm

from studies.summary.monte_carlo_errors import bootstrap_error, mean_error, quantile_error

REPEATED = 400
SCATTER_KNOWN_TO = 0.15
"""4 standard errors of a standard deviation from 400 repetitions, 1 / sqrt(2 * 400) each"""


@pytest.mark.parametrize("share", [0.025, 0.16, 0.5, 0.975])
def test_a_quantile_scatters_as_its_error_says(share: float) -> None:
    random = np.random.default_rng(8)
    drawn = random.standard_normal((REPEATED, 1000))
    scatter = np.quantile(drawn, share, axis=1).std(ddof=1)
    said = np.mean([quantile_error(row, share) for row in drawn])
    theory = np.sqrt(share * (1 - share) / 1000) / norm.pdf(norm.ppf(share))
    assert said == pytest.approx(scatter, rel=SCATTER_KNOWN_TO)
    assert said == pytest.approx(theory, rel=SCATTER_KNOWN_TO)


def test_the_bootstrap_error_of_a_mean_is_that_of_the_mean() -> None:
    values = np.random.default_rng(2).normal(3.0, 2.0, (500, 1))
    found = bootstrap_error(values, lambda mean: float(mean[0]))
    assert found == pytest.approx(mean_error(values[:, 0]), rel=SCATTER_KNOWN_TO)


def test_missing_values_leave_a_trial_out() -> None:
    values = np.random.default_rng(2).normal(3.0, 2.0, (600, 2))
    values[:300, 1] = np.nan
    found = bootstrap_error(values, lambda mean: float(mean[1]))
    assert found == pytest.approx(mean_error(values[300:, 1]), rel=SCATTER_KNOWN_TO)


def test_one_trial_has_no_error() -> None:
    one = np.ones(1)
    assert isnan(mean_error(one))
    assert isnan(quantile_error(one, 0.5))
    assert isnan(bootstrap_error(one, lambda mean: float(mean)))
