"""How well an adjustment controls its own observations: Baarda's reliability.

With r_i the redundancy number of observation i, v_i its correction and sigma_i its a priori standard deviation:

    w_i = v_i / (sigma_i sqrt(r_i))            standardised residual, N(0, 1) without gross errors (Baarda 1968)
    tau_i = w_i / sigma0                       the same with the estimated sigma0 (Pope 1976)
    e_i = -v_i / r_i                           the estimated error, if observation i alone is wrong
    mdb_i = delta0 sigma_i / sqrt(r_i)         minimal detectable bias: found with the stated power at level alpha
    external_i = delta0 sqrt((1 - r_i) / r_i)  an error of that size moves no function of the unknowns by more than so
                                               many of its a priori standard deviations (Baarda 1968; Foerstner 1985)

Baarda: A testing procedure for use in geodetic networks, Neth. Geod. Comm. 2/5, 1968. Pope: The statistics of
residuals and the detection of outliers, NOAA TR NOS 65 NGS 1, 1976.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.special

from adjust.adjustment import Adjustment, Name
from adjust.quality.influence import Influence, row_name
from simfield.block import Floats, Indices

ALPHA = 0.001
POWER = 0.8


def noncentrality(alpha: float = ALPHA, power: float = POWER) -> float:
    """delta0: the shift of a standard normal that a two-sided test of level alpha finds with this power; 4.13 by
    default.

    The far tail is left out, as in Baarda's nomograms; it adds less than 1e-4 to the power for alpha <= 5 %.
    """
    return float(scipy.special.ndtri(1.0 - alpha / 2.0) + scipy.special.ndtri(power))


def w_critical(alpha: float = ALPHA) -> float:
    """The bound that |w| of one observation exceeds with probability alpha."""
    return float(scipy.special.ndtri(1.0 - alpha / 2.0))


def tau_critical(redundancy: float, alpha: float = ALPHA) -> float:
    """The bound that |tau| of one observation exceeds with probability alpha, from Student's t (Pope 1976).

    tau = sqrt(f) t / sqrt(f - 1 + t^2), t with f - 1 degrees of freedom. For redundancy 1 |tau| is always 1.
    """
    if redundancy < 2:
        return 1.0
    t = float(scipy.special.stdtrit(redundancy - 1, 1.0 - alpha / 2.0))
    return float(np.sqrt(redundancy) * t / np.sqrt(redundancy - 1.0 + t**2))


def tau_noncentrality(redundancy: float, alpha: float = ALPHA, power: float = POWER) -> float:
    """delta0 of the tau test: the error itself raises the estimated sigma0, so it is larger than that of the w test.

    t is noncentral then, with f - 1 degrees of freedom; NaN for a redundancy below 2.
    """
    if redundancy < 2:
        return float("nan")
    t = scipy.special.stdtrit(redundancy - 1, 1.0 - alpha / 2.0)
    return float(scipy.special.nctdtrinc(redundancy - 1, 1.0 - power, t))


def familywise(alpha: float, count: float) -> float:
    """The level of each of `count` tests by which all together reject wrongly with probability alpha (Sidak 1967).

    For dependent tests the level of all is at most alpha.
    """
    return float(-np.expm1(np.log1p(-alpha) / count))


@dataclass(frozen=True, eq=False)
class Reliability:
    """The reliability of all n observations of an adjustment, in the order of `Influence`.

    NaN where nothing can be said: an observation of redundancy 0 has no test, and an infinite minimal detectable bias.
    """

    influence: Influence
    alpha: float = ALPHA
    power: float = POWER
    shifts: Floats | None = None
    """(n) the shift of the standardised residual that the test of each observation finds; None: delta0 of the w test"""

    @classmethod
    def of(cls, adjustment: Adjustment, alpha: float = ALPHA, power: float = POWER) -> Reliability:
        """Raises ValueError where the adjustment failed."""
        return cls(Influence.of(adjustment), alpha, power)

    def __len__(self) -> int:
        return len(self.influence)

    @property
    def delta0(self) -> float:
        """Of the w test."""
        return noncentrality(self.alpha, self.power)

    @cached_property
    def _shifts(self) -> Floats:
        return np.full(len(self), self.delta0) if self.shifts is None else self.shifts

    @property
    def redundancy(self) -> Floats:
        """(n) r; the sum over observations of weight > 0 is the redundancy of the adjustment."""
        return self.influence.redundancy

    @cached_property
    def _root(self) -> Floats:
        r = np.where(self.influence.rows.weight > 0.0, self.redundancy, 0.0)
        return np.asarray(np.sqrt(np.where(r > 0.0, r, np.nan)))

    @cached_property
    def w(self) -> Floats:
        """(n) standardised residuals; NaN where the redundancy is 0 or the observation is rejected."""
        return np.asarray(self.influence.rows.standard / self._root)

    @property
    def tau(self) -> Floats:
        """(n) studentised residuals."""
        return np.asarray(self.w / self.influence.adjustment.sigma0)

    @cached_property
    def estimated_error(self) -> Floats:
        """(n) in the unit of the observation: what must be subtracted from it, if it alone is wrong."""
        return np.asarray(-self.influence.rows.v / self._root**2)

    @cached_property
    def mdb(self) -> Floats:
        """(n) the minimal detectable bias in the unit of the observation, for the a priori standard deviations."""
        with np.errstate(divide="ignore"):
            sigma = 1.0 / np.sqrt(self.influence.rows.weight)
        return np.where(np.isnan(self._root), np.inf, self._shifts * sigma / self._root)

    @cached_property
    def external(self) -> Floats:
        """(n) the bound of the effect of an undetected bias on anything, in a priori standard deviations of that
        thing.
        """
        r = self._root**2
        return np.where(np.isnan(r), np.inf, self._shifts * np.sqrt((1.0 - r) / r))

    def effect(self, rows: Sequence[int] | Indices, *names: Name) -> Floats:
        """(len(rows), len(names)): what the minimal detectable bias of an observation does to the named unknowns.

        Raises KeyError for an unknown name.
        """
        at = np.array([self.influence.adjustment.layout.index(*name) for name in names], dtype=np.intp)
        chosen = np.asarray(rows, dtype=np.intp)
        return np.asarray(self.influence.effect(chosen, at) * (self._shifts / self._root)[chosen, None])

    def worst_effect(self, at: Indices) -> tuple[Floats, Indices]:
        """For each place in x of `at`: the largest effect of any undetected bias, and the observation it comes from."""
        rows = np.flatnonzero(np.isfinite(self._root))
        effect = np.abs(self.influence.effect(rows, at)) * (self._shifts / self._root)[rows, None]
        worst = np.argmax(effect, axis=0)
        return np.asarray(effect[worst, np.arange(len(at))]), rows[worst]

    def test_correlation(self, i: Sequence[int] | Indices, j: Sequence[int] | Indices) -> Floats:
        """(len(i), len(j)) the correlation of the tests w_i and w_j: near 1, an error of one is laid to the other.

        Foerstner: Reliability and discernability of extended Gauss-Markov models, DGK A 98, 1983.
        """
        rows, columns = np.asarray(i, dtype=np.intp), np.asarray(j, dtype=np.intp)
        r = (rows[:, None] == columns) - self.influence.hat(rows, columns)
        return np.asarray(r / self._root[rows][:, None] / self._root[columns])

    def name(self, row: int) -> str:
        """The observation in words."""
        return row_name(self.influence.adjustment.groups, row)

    @property
    def image_points(self) -> slice:
        """The rows of the image coordinates, x and y in turn in the order of the block; reshape(-1, 2) gives points."""
        return slice(0, 2 * len(self.influence.adjustment.block.observations))
