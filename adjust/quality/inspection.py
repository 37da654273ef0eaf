"""The order of the tests: variance components, then gross errors, then what is left.

Observations of unequal precision tested with one sigma0 accuse the group that is less precise. So the components of the
groups come first, each observation is tested with the sigma0 of its own group, and, as errors raise the component of
their group, the components are estimated again without the accused, until nobody else is accused. Additional parameters
are tested in what is left. The level is that of the whole search (adjust.quality.level_of_all); the minimal detectable
biases are those of this test at this level.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adjust.adjustment import Adjustment
from adjust.bundle import reweighted
from adjust.quality.gross_errors import LEAST_CHECKED, Snooping, first_tests, snoop
from adjust.quality.influence import Influence
from adjust.quality.level_of_all import level_of_one
from adjust.quality.reliability import POWER, Reliability, noncentrality, tau_noncentrality
from adjust.quality.variance import VarianceComponents, groups_by_camera, variance_components
from simfield.block import Floats, Indices

LEVEL = 0.05
OF_ITS_OWN_LEAST = 20.0
"""redundancy of a group that gets a component here: in smaller ones an error would hide in its own"""
ROUNDS_MOST = 5


@dataclass(frozen=True, eq=False)
class Inspection:
    """The components (None where no group has the redundancy for one, or where they cannot be told apart), the level of
    the search and of one test, the search, and the reliability of all observations under this test.

    own (n): the number of the group whose sigma0 an observation is tested with, -1 for the stated one. tests (n): its
    statistic over its critical value before anybody is accused; 0 where nothing checks it. adjustment: with the
    components and without the accused.
    """

    components: VarianceComponents | None
    own: Indices
    tests: Floats
    level: float
    alpha: float
    snooping: Snooping
    reliability: Reliability

    @property
    def adjustment(self) -> Adjustment:
        return self.snooping.adjustment

    @property
    def suspected(self) -> Indices:
        """The rows of the accused."""
        return np.array([each.row for each in self.snooping.accused], dtype=np.intp)


def inspected(
    a: Adjustment,
    level: float = LEVEL,
    most: int | None = None,
    power: float = POWER,
    alpha: float | None = None,
) -> Inspection:
    """Components, search and what is left of an adjustment. `most` bounds the number of accused.

    level: the share of clean blocks in which anybody is accused. alpha: that of one test, if it is known from another
    block of the same geometry. Raises ValueError where an adjustment fails.
    """
    groups = _groups(a)
    own = np.full(a.groups.rows, -1, dtype=np.intp)
    for number, rows in enumerate(groups.values()):
        own[rows] = number
    stated, out = a.groups.weights, np.empty(0, dtype=np.intp)
    of_one, tests = alpha, np.empty(0)
    for _ in range(ROUNDS_MOST):
        components, weights = _components(a, stated, out, groups)
        scaled = reweighted(a, weights)
        if not scaled.status.ok:
            raise ValueError(f"the block cannot be adjusted with its variance components: {scaled.message}")
        influence = Influence.of(scaled)
        if of_one is None:
            testable = (influence.redundancy > LEAST_CHECKED) & (influence.rows.weight > 0.0)
            of_one = level_of_one(influence, own, level, testable)
        if not len(tests):
            tests = first_tests(scaled, of_one, own)
        search = snoop(scaled, of_one, most=most, own=own)
        before, out = out, np.array([each.row for each in search.accused], dtype=np.intp)
        if search.stopped or set(before.tolist()) == set(out.tolist()):
            break
    reliability = Reliability(influence, search.alpha, power, _shifts(influence, own, search.alpha, power))
    return Inspection(components, own, tests, level, search.alpha, search, reliability)


def _groups(a: Adjustment) -> dict[str, Indices]:
    """The usual groups that have the redundancy for a component of their own."""
    influence = Influence.of(a)
    redundancy = np.where(influence.rows.weight > 0.0, influence.redundancy, 0.0)
    return {name: rows for name, rows in groups_by_camera(a).items() if redundancy[rows].sum() >= OF_ITS_OWN_LEAST}


def _components(
    a: Adjustment, stated: Floats, out: Indices, groups: dict[str, Indices]
) -> tuple[VarianceComponents | None, Floats]:
    """The components without the rows that are out, and the weights with them, those rows back in."""
    weights = stated.copy()
    if not groups:
        return None, weights
    trial = stated.copy()
    trial[out] = 0.0
    try:
        found = variance_components(reweighted(a, trial) if len(out) else a, groups)
    except ValueError:  # each group still has a sigma0 of its own
        return None, weights
    for rows, factor in zip(groups.values(), found.factor, strict=True):
        weights[rows] /= factor
    return found, weights


def _shifts(influence: Influence, own: Indices, alpha: float, power: float) -> Floats:
    """(n) delta0 of the test of every observation."""
    redundancy = np.where(influence.rows.weight > 0.0, influence.redundancy, 0.0)
    size = int(own.max()) + 1
    by_group = [tau_noncentrality(float(redundancy[own == g].sum()), alpha, power) for g in range(size)]
    return np.append(by_group, noncentrality(alpha, power))[own]
