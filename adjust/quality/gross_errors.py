"""Gross errors found one after the other: iterative data snooping (Baarda 1968; Pope 1976).

The rule. In every round the observation with the largest |w| (or |tau|) is accused if that exceeds the critical value,
and is taken out; all others are tested anew without it. When nobody else is accused, every observation taken out is
tested once more beside the others that are out, and the least suspicious one is taken back if it stands its test; then
the search goes on. An observation that the remaining ones check by less than LEAST_CHECKED of itself is never taken
out: it could be anything. In the end the block is adjusted again without the accused, and searched again, until
nothing changes.

Taking out is done exactly, in the linear model, by downdating the redundancy matrix: R' = R - u u^T with
u = R e_i / sqrt(r_ii). No normal equations are solved before the end.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from adjust.adjustment import Adjustment
from adjust.bundle import reweighted
from adjust.quality.influence import row_name
from adjust.quality.reliability import ALPHA, Reliability, tau_critical, w_critical
from simfield.block import Floats, Indices

LEAST_CHECKED = 0.02
"""least redundancy number of an observation that can be accused"""
CONFUSED = 0.9
"""from this correlation of tests on, an accusation is said to be ambiguous"""
CONFUSED_MOST = 3
SHARE_MOST = 0.2
"""largest share of all observations that is taken out: beyond, it is the model that is wrong"""
ADJUSTMENTS_MOST = 5

Test = Literal["w", "tau"]
"""w: the a priori sigma0 = 1 is trusted; tau: sigma0 is estimated, and a common factor of all sigmas has no
influence
"""
DEGREES_LEAST = 2.0
"""redundancy of a group with a sigma0 of its own, below which nobody in it is accused"""


@dataclass(frozen=True)
class Accused:
    """An observation taken out: its row, its name, the test quantity and critical value when it was accused, the
    estimated error in its own unit, its redundancy number then, and the others that could as well be the culprit."""

    row: int
    name: str
    statistic: float
    critical: float
    error: float
    redundancy: float
    confused_with: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Snooping:
    """What was accused, in this order, the adjustment without it, the level of one test, and whether the search had to
    be stopped.
    """

    accused: tuple[Accused, ...]
    adjustment: Adjustment
    alpha: float
    stopped: bool = False


@dataclass(eq=False)
class _Search:
    """The state of the search: corrections and redundancy numbers (n) with the accused out, and the downdates u.

    label (n): whose sigma0 each observation is tested with, -1 for the a priori one, which is 1.
    """

    found: Reliability
    label: Indices
    alpha: float
    standard: Floats = field(init=False)
    redundancy: Floats = field(init=False)
    downdates: list[Floats] = field(default_factory=list)
    out: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.standard = self.found.influence.rows.standard.copy()
        self.redundancy = self.found.redundancy.copy()
        self.redundancy[self.found.influence.rows.weight == 0.0] = 0.0

    @property
    def degrees(self) -> float:
        """The redundancy that is left."""
        return float(self.redundancy.sum())

    def _own(self) -> tuple[Floats, Floats]:
        """The sigma0 that divides w, and the critical value, of every group, and last of those tested a priori."""
        size = int(self.label.max()) + 1
        label = np.where(self.label < 0, size, self.label)
        degrees = np.bincount(label, self.redundancy, size + 1)[:size]
        squares = np.bincount(label, self.standard**2, size + 1)[:size]
        scale = np.sqrt(squares / np.maximum(degrees, 1.0))
        tau = [tau_critical(f, self.alpha) if f >= DEGREES_LEAST else np.inf for f in degrees]
        return np.append(scale, 1.0), np.append(tau, w_critical(self.alpha))

    def statistics(self) -> tuple[Floats, Floats]:
        """(n) |w| or |tau|, 0 for what cannot be accused, and (n) the critical values."""
        possible = self.redundancy > LEAST_CHECKED
        root = np.sqrt(np.where(possible, self.redundancy, 1.0))
        scale, critical = self._own()
        w = np.where(possible, np.abs(self.standard) / root, 0.0)
        with np.errstate(invalid="ignore"):  # a group without any error has the sigma0 0
            return np.nan_to_num(w / scale[self.label]), critical[self.label]

    def column(self, i: int) -> Floats:
        """(n) column i of the downdated redundancy matrix."""
        column = self.found.influence.column(i)
        for u in self.downdates:
            column -= u * u[i]
        return column

    def take_out(self, i: int) -> None:
        column = self.column(i)
        u = column / np.sqrt(column[i])
        drop = self.standard[i] / np.sqrt(column[i])
        self.standard -= u * drop
        self.redundancy -= u * u
        self.redundancy[i] = self.standard[i] = 0.0
        self.downdates.append(u)
        self.out.append(i)

    def acquitted(self) -> int | None:
        """The least suspicious of those that are out, if it stands its test beside the others."""
        if len(self.out) < 2:
            return None
        at = np.array(self.out, dtype=np.intp)
        r = np.eye(len(at)) - self.found.influence.hat(at, at)
        inverse = np.linalg.inv(r)
        error = inverse @ self.found.influence.rows.standard[at]
        scale, critical = self._own()
        statistic = np.abs(error) / np.sqrt(np.diag(inverse)) / scale[self.label[at]]
        over = statistic / critical[self.label[at]]
        least = int(np.argmin(over))
        return self.out[least] if over[least] <= 1.0 else None

    def without(self, i: int) -> _Search:
        """The search with i taken back."""
        again = _Search(self.found, self.label, self.alpha)
        for j in self.out:
            if j != i:
                again.take_out(j)
        return again


def first_tests(a: Adjustment, alpha: float, own: Indices) -> Floats:
    """(rows) every statistic over its critical value while nobody is accused; 0 for what cannot be. As `snoop`."""
    statistics, critical = _Search(Reliability.of(a, alpha), own, alpha).statistics()
    return statistics / critical


def snoop(
    a: Adjustment, alpha: float = ALPHA, test: Test = "w", most: int | None = None, own: Indices | None = None
) -> Snooping:
    """Iterative data snooping by the rule above; alpha is the level of one test, `most` bounds the number of accused.

    For a given level of the whole adjustment take `alpha=familywise(0.05, a.observations)`, or the sharper one of
    `adjust.quality.inspected`. own (rows): the number of the group whose sigma0 each observation is tested with, -1 for
    the a priori one; it takes the place of `test`. Raises ValueError where the adjustment has failed.
    """
    label = np.full(a.groups.rows, -1 if test == "w" else 0, dtype=np.intp) if own is None else own
    limit = int(SHARE_MOST * a.observations) if most is None else most
    accused: dict[int, Accused] = {}
    current, weights = a, a.groups.weights
    for _ in range(ADJUSTMENTS_MOST):
        fresh = _searched(current, alpha, label, limit - len(accused))
        if not fresh:
            return Snooping(tuple(accused.values()), current, alpha)
        accused.update((each.row, each) for each in fresh)
        trial = weights.copy()
        trial[list(accused)] = 0.0
        current = reweighted(current, trial)
        if not current.status.ok or len(accused) >= limit:
            break
    return Snooping(tuple(accused.values()), current, alpha, stopped=True)


def _searched(a: Adjustment, alpha: float, label: Indices, limit: int) -> list[Accused]:
    """One search in the linear model of an adjustment."""
    search = _Search(Reliability.of(a, alpha), label, alpha)
    accused: dict[int, Accused] = {}
    back: set[int] = set()
    while len(search.out) < limit and search.degrees > 1.5:
        statistics, critical = search.statistics()
        statistics[list(back)] = 0.0
        i = int(np.argmax(statistics / critical))
        if statistics[i] > critical[i]:
            accused[i] = _accusation(search, i, float(statistics[i]), float(critical[i]))
            search.take_out(i)
            continue
        innocent = search.acquitted()
        if innocent is None:
            break
        # nobody is taken back twice, so that the search ends
        back.add(innocent)
        search = search.without(innocent)
    return [accused[i] for i in search.out]


def _accusation(search: _Search, i: int, statistic: float, critical: float) -> Accused:
    rows, groups = search.found.influence.rows, search.found.influence.adjustment.groups
    column, r = search.column(i), float(search.redundancy[i])
    root = np.sqrt(np.where(search.redundancy > LEAST_CHECKED, search.redundancy * r, np.inf))
    correlation = np.abs(column) / root
    correlation[i] = 0.0
    others: Indices = np.argsort(-correlation)[:CONFUSED_MOST]
    return Accused(
        i,
        row_name(groups, i),
        statistic,
        critical,
        float(-search.standard[i] / r / np.sqrt(rows.weight[i])),
        r,
        tuple(row_name(groups, int(j)) for j in others if correlation[j] > CONFUSED),
    )
