"""Standard errors of what is computed over trials: means, quantiles, and anything at all by resampling.

An error of one trial has none: NaN.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from simfield.block import Floats

RESAMPLED = 400
"""draws of the bootstrap: the error itself is then good to 4 %"""


def mean_error(values: Floats) -> float:
    """The standard error of the mean of values (n)."""
    return float(np.std(values, ddof=1) / len(values) ** 0.5) if len(values) > 1 else float("nan")


def quantile_error(values: Floats, share: float) -> float:
    """The standard error of the quantile at `share` (0 to 1) of values (n), without an assumption on how they lie.

    Half the distance of the quantiles a binomial standard error on either side (Woodruff 1952, JASA 47, 635). Where
    that reaches beyond the smallest or largest value it is too small, as for a quantile of 2.5 % from fewer than 40
    values.
    """
    if len(values) < 2:
        return float("nan")
    s = np.sqrt(share * (1.0 - share) / len(values))
    low, high = np.quantile(values, np.clip([share - s, share + s], 0.0, 1.0))
    return float(0.5 * (high - low))


def bootstrap_error(values: Floats, figure: Callable[[Floats], float], seed: int = 1979) -> float:
    """The standard error of a figure of means over trials: values (n, ...), figure of an array (...).

    Whole trials are drawn with replacement (Efron 1979, Annals of Statistics 7, 1). Missing values, NaN, are left out
    of the means.
    """
    n = len(values)
    if n < 2:
        return float("nan")
    flat, known = np.nan_to_num(values.reshape(n, -1)), np.isfinite(values.reshape(n, -1))
    weights = np.random.default_rng(seed).multinomial(n, np.full(n, 1.0 / n), size=RESAMPLED).astype(float)
    with np.errstate(invalid="ignore"):
        means = (weights @ flat) / (weights @ known)
    return float(np.std([figure(each.reshape(values.shape[1:])) for each in means], ddof=1))
