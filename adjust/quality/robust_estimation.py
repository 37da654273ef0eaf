"""Robust estimation by reweighting: many gross errors at once lose their weight, step by step.

In every round each observation gets the weight f(u) / sigma^2 with its own f, where u = |w| / s is the residual it
would have if it were alone at fault, standardised by its redundancy number, and s the robust scale of all w (1.4826
times the median of |w|; Hampel 1974). With f = rho'(u) / u this minimises the sum of rho(u) (Huber 1964). The rounds
end when no f changes by more than FACTOR_LEFT.

What lost its weight counts no more: the redundancy is the expectation of vPv for given factors, the sum of f_i r_i over
all observations, to the nearest whole number. Else sigma0 and all standard deviations would be too small by the root
of the share that was taken out.

Small redundancy numbers let an error hide in the estimates, so robust estimation does not make weak geometry strong.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from adjust.adjustment import Adjustment
from adjust.bundle import reweighted
from adjust.quality.gross_errors import LEAST_CHECKED
from adjust.quality.influence import Influence, row_name
from adjust.quality.reliability import ALPHA, w_critical
from simfield.block import Floats

FACTOR_LEFT = 1e-3
ROUNDS_MOST = 50
FACTOR_LEAST = 1e-8
"""no observation loses all its weight, so that it can come back and no point is left without rays"""
NORMAL_SCALE = 1.4826
"""of the median of |w| to the standard deviation, for normal errors"""


class WeightFunction(Protocol):
    """The factor of the weight for standardised residuals u >= 0."""

    def __call__(self, u: Floats, /) -> Floats: ...


@dataclass(frozen=True)
class Huber:
    """Least squares up to k, then least sums: f = min(1, k / u) (Huber 1964). Convex, with one minimum."""

    k: float = 1.5

    def __call__(self, u: Floats) -> Floats:
        return np.asarray(self.k / np.maximum(u, self.k))


@dataclass(frozen=True)
class Danish:
    """The Danish method of Krarup: 1 up to c, then a steep exponential, here exp(1 - (u / c)^2), continuous at c.

    Krarup, Juhl, Kubik: Goetterdaemmerung over least squares adjustment, XIV ISP Congress, Hamburg 1980; several
    exponentials are in use.
    """

    c: float = 3.0

    def __call__(self, u: Floats) -> Floats:
        return np.exp(1.0 - np.maximum(u / self.c, 1.0) ** 2)


@dataclass(frozen=True)
class Cauchy:
    """f = 1 / (1 + (u / k)^2); k = 2.385 keeps 95 % of the efficiency for normal errors (Holland, Welsch 1977)."""

    k: float = 2.385

    def __call__(self, u: Floats) -> Floats:
        return np.asarray(1.0 / (1.0 + (u / self.k) ** 2))


@dataclass(frozen=True)
class Suspect:
    """An observation that does not fit: its row, its name, u, the final factor of its weight, and the estimated error
    in its own unit."""

    row: int
    name: str
    statistic: float
    factor: float
    error: float


@dataclass(frozen=True, eq=False)
class Robust:
    """The reweighted adjustment, the factor of every weight (n), u (n), the scale s, and the suspects, worst first."""

    adjustment: Adjustment
    factor: Floats
    statistic: Floats
    scale: float
    suspects: tuple[Suspect, ...]
    rounds: int
    converged: bool


def robust(a: Adjustment, function: WeightFunction | None = None, alpha: float = ALPHA) -> Robust:
    """Reweight until nothing changes, Danish by default; suspects have |w| / s above the critical value of level alpha.

    Raises ValueError where an adjustment fails.
    """
    function = Danish() if function is None else function
    weights, factor = a.groups.weights, np.ones(a.groups.rows)
    current, converged, rounds = a, False, 0
    while rounds < ROUNDS_MOST and not converged:
        w, _, _ = _alone(current, factor)
        u = np.abs(w) / _scale(w)
        fresh = np.where(np.isnan(u), 1.0, np.maximum(function(np.nan_to_num(u)), FACTOR_LEAST))
        converged = bool(np.abs(fresh - factor).max() <= FACTOR_LEFT)
        factor, rounds = fresh, rounds + 1
        current = _reweighted(current, weights * factor)
    current = _reweighted(current, weights * factor, a.groups.taken_out + _taken_out(current, factor))
    w, error, _ = _alone(current, factor)
    scale = _scale(w)
    u = np.abs(w) / scale
    critical = w_critical(alpha)
    worst = [int(i) for i in np.argsort(-np.nan_to_num(u), kind="stable") if u[i] > critical]
    suspects = tuple(Suspect(i, row_name(a.groups, i), float(u[i]), float(factor[i]), float(error[i])) for i in worst)
    return Robust(current, factor, u, scale, suspects, rounds, converged)


def _reweighted(a: Adjustment, weights: Floats, taken_out: int = 0) -> Adjustment:
    found = reweighted(a, weights, taken_out)
    if not found.status.ok:
        raise ValueError(f"the reweighted block cannot be adjusted: {found.message}")
    return found


def _taken_out(a: Adjustment, factor: Floats) -> int:
    """By how much the redundancy of all that has a weight is larger than the sum of f_i r_i; one is left at least."""
    influence, redundancy = Influence.of(a), a.regular.redundancy
    counted = influence.rows.weight > 0.0
    left = float(np.sum(factor[counted] * (1.0 - influence.leverage[counted])))
    return min(round(redundancy - left), redundancy - 1)


def _scale(w: Floats) -> float:
    return float(NORMAL_SCALE * np.nanmedian(np.abs(w)))


def _alone(a: Adjustment, factor: Floats) -> tuple[Floats, Floats, Floats]:
    """Of every observation (n): w and estimated error if it alone had no weight, and its redundancy number with full
    weight.

    With the reduced weight f p the redundancy number is r_f = 1 / (1 + f s), with full weight 1 / (1 + s). NaN for what
    is hardly checked or rejected.
    """
    influence = Influence.of(a)
    r_f, weight = influence.redundancy, influence.rows.weight
    checked = (r_f > 0.0) & (weight > 0.0)
    r_f = np.where(checked, r_f, np.nan)
    r = 1.0 / (1.0 + influence.leverage / (factor * r_f))
    r = np.where(r > LEAST_CHECKED, r, np.nan)
    error = -influence.rows.v / r_f
    sigma = 1.0 / np.sqrt(np.where(checked, weight / factor, np.nan))
    return -error * np.sqrt(r) / sigma, error, r
