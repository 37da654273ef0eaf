"""The level of one test by which all tests of a search together reject a clean block in the stated share of cases.

The residuals of one block hang together, so that Sidak's level for independent tests is too low where points have few
rays: by a quarter in the preset grid-small, by nothing to speak of in rheidt-1980. The distribution of the least level
of all tests depends on the geometry alone. It is that of n_e independent tests, nearly, and n_e is estimated from
simulated errors: with p the least level of each of N error vectors, n_e = -N / sum log(1 - p), to a share of
1 / sqrt(N).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import scipy.sparse
import scipy.special

from adjust.quality.influence import Influence
from adjust.quality.reliability import familywise
from simfield.block import Floats, Indices

VECTORS = 1000
AT_ONCE = 100
WORK_MOST = 1e11
"""multiplications; beyond, Sidak's level is taken, which accuses fewer"""
SEED = 1968


def level_of_one(influence: Influence, label: Indices, level: float, testable: npt.NDArray[np.bool_]) -> float:
    """The level of each test, for `level` of all observations that are testable (n).

    label (n): the group whose sigma0 an observation is tested with, -1 for the a priori one.
    """
    count = int(testable.sum())
    if not count or 2.0 * VECTORS * influence.t.size > WORK_MOST:
        return familywise(level, max(count, 1))
    least = np.concatenate([_least_levels(influence, label, testable, part) for part in range(VECTORS // AT_ONCE)])
    return familywise(level, -len(least) / float(np.sum(np.log1p(-least))))


def _least_levels(influence: Influence, label: Indices, testable: npt.NDArray[np.bool_], part: int) -> Floats:
    """(AT_ONCE) the least level of all tests, of error vectors that are drawn by the number of their part."""
    standard = _residuals(influence, np.random.default_rng([SEED, part]))
    redundancy = influence.redundancy
    w = np.abs(standard[:, testable]) / np.sqrt(redundancy[testable])
    least = np.ones(len(standard))
    for group in np.unique(label[testable]):
        largest = np.max(w[:, label[testable] == group], axis=1)
        if group < 0:
            p = 2.0 * scipy.special.ndtr(-largest)
        else:
            rows = (label == group) & (influence.rows.weight > 0.0)
            f = float(redundancy[rows].sum())
            tau2 = np.minimum(largest**2 / (np.sum(standard[:, rows] ** 2, axis=1) / f), f * (1.0 - 1e-12))
            p = 2.0 * scipy.special.stdtr(f - 1.0, -np.sqrt(tau2 * (f - 1.0) / (f - tau2)))
        least = np.minimum(least, p)
    return np.minimum(least, 1.0 - 1e-12)


def _residuals(influence: Influence, random: np.random.Generator) -> Floats:
    """(AT_ONCE, n) residuals r e of standard normal errors e, in standard deviations, by the factors of h."""
    n = len(influence)
    errors = random.standard_normal((AT_ONCE, n)) * (influence.rows.weight > 0.0)
    rows, axes = np.divmod(np.arange(3 * n), 3)
    seen = np.repeat(influence.rows.point >= 0, 3)
    places = 3 * influence.rows.point[rows] + axes
    by_point = scipy.sparse.csr_array(
        (influence.b.ravel()[seen], (rows[seen], places[seen])), shape=(n, 3 * len(influence.factor.root))
    )
    return np.asarray(errors - (errors @ influence.t) @ influence.t.T - (errors @ by_point) @ by_point.T)
