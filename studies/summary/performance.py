"""Performance measures over trials, each with its Monte-Carlo standard error.

An estimate is formed over n trials, never over the points within one. Beside it stands what every trial contributes to
it, its influence: to first order, estimate - value = mean(influence). The Monte-Carlo standard error is the standard
deviation of the influences / sqrt(n) (the delta method; for means, bias and coverage it is the formula of Morris, White
& Crowther 2019, table 6; for the others it needs no normal distribution, which those formulas do). The difference of
two methods on the same trials has the standard error of the differences of their influences, so it is paired.

All functions take a column of quantities at once, (n, q), without failed trials; NaN estimates come from no trials, NaN
standard errors from a single one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simfield.block import Floats

Z2 = 1.959963984540054**2
"""square of the 97.5 % point of the normal distribution: Agresti & Coull 1998 add so many trials, half of them hits"""


@dataclass(frozen=True, eq=False)
class Measured:
    """Estimates (q), their Monte-Carlo standard errors (q), and the influences (n, q) of the trials."""

    estimate: Floats
    mcse: Floats
    influence: Floats

    @classmethod
    def of(cls, estimate: Floats, influence: Floats) -> Measured:
        return cls(estimate, standard_error(influence), influence)


def standard_error(influence: Floats) -> Floats:
    """(q) standard deviation / sqrt(n) of the influences (n, q); NaN for fewer than two trials."""
    n = len(influence)
    if n < 2:
        return np.full(influence.shape[1], np.nan)
    deviation = influence - np.add.reduce(influence, axis=0) / n  # np.std takes three times as long for one column
    np.square(deviation, out=deviation)
    return np.asarray(np.sqrt(np.add.reduce(deviation, axis=0) / (n - 1)) / np.sqrt(n))


def _mean(values: Floats) -> Floats:
    return np.asarray(values.mean(axis=0)) if len(values) else np.full(values.shape[1], np.nan)


def mean(values: Floats) -> Measured:
    """The mean over trials."""
    estimate = _mean(values)
    return Measured.of(estimate, values - estimate)


def bias(error: Floats) -> Measured:
    """The mean of estimate - estimand."""
    return mean(error)


def empirical_se(error: Floats) -> Measured:
    """The standard deviation of the estimates over trials."""
    n = len(error)
    if n < 2:
        return _nothing(error)
    squares = (error - error.mean(axis=0)) ** 2
    variance = squares.sum(axis=0) / (n - 1)
    s = np.sqrt(variance)
    return Measured.of(s, _divided(squares - variance, 2.0 * s))


def model_se(std: Floats) -> Measured:
    """The root of the mean square of the standard errors that the adjustments claim."""
    squares = std**2
    square = _mean(squares)
    root = np.sqrt(square)
    return Measured.of(root, _divided(squares - square, 2.0 * root))


def model_se_error(model: Measured, empirical: Measured) -> Measured:
    """The relative error of the claimed standard errors: model_se / empirical_se - 1."""
    ratio = _divided(model.estimate, empirical.estimate)
    shares = _divided(model.influence, model.estimate) - _divided(empirical.influence, empirical.estimate)
    return Measured.of(ratio - 1.0, ratio * shares)


def rmse(error: Floats) -> Measured:
    """The root of the mean square of estimate - estimand."""
    return model_se(error)


def coverage(inside: Floats) -> Measured:
    """The share of trials whose interval contains the estimand; the standard error is never 0 (Agresti & Coull)."""
    share = mean(inside)
    return Measured(share.estimate, smoothed(share.estimate, len(inside)), share.influence)


def share_coverage(shares: Floats) -> Measured:
    """The mean over trials of the share of points inside; trials that all agree get the standard error of coverage."""
    found = mean(shares)
    least = smoothed(found.estimate, len(shares))
    return Measured(found.estimate, np.where(found.mcse > 0.0, found.mcse, least), found.influence)


def smoothed(share: Floats, n: int) -> Floats:
    """The standard error of a share of n trials after Agresti & Coull's adjustment; NaN for no trials."""
    if n == 0:
        return np.full_like(share, np.nan)
    adjusted = (share * n + Z2 / 2.0) / (n + Z2)
    return np.asarray(np.sqrt(adjusted * (1.0 - adjusted) / (n + Z2)))


def correlation(first: Floats, second: Floats) -> Measured:
    """The correlation over trials of two estimates, (n, q) each."""
    if len(first) < 2:
        return _nothing(first)
    a, b = (_divided(v - v.mean(axis=0), v.std(axis=0)) for v in (first, second))
    r = (a * b).mean(axis=0)
    return Measured.of(r, a * b - 0.5 * r * (a**2 + b**2))


def difference(of: Measured, against: Measured) -> Measured:
    """of - against on the same trials, with the paired standard error; influences (n, q) trial by trial."""
    return Measured.of(of.estimate - against.estimate, of.influence - against.influence)


def _divided(numerator: Floats, denominator: Floats) -> Floats:
    with np.errstate(divide="ignore", invalid="ignore"):
        quotient = np.asarray(numerator / denominator)
    finite = np.isfinite(quotient)
    if not finite.all():
        quotient[~finite] = np.nan
    return quotient


def _nothing(values: Floats) -> Measured:
    nan = np.full(values.shape[1], np.nan)
    return Measured(nan, nan, np.full_like(values, np.nan))
