"""Which additional parameters an adjustment needs: tests of single ones, of groups, and of sigma0.

With estimates x, cofactors Q and redundancy f, all under the normal distribution and the hypothesis that the parameter
is 0:

    t_j = x_j / (sigma0 sqrt(q_jj))                  Student's t with f degrees of freedom
    F = x_g^T Q_gg^-1 x_g / (k sigma0^2)             Fisher's F with k and f, for a group g of k parameters
    z = L^T x / sigma0, Q_aa^-1 = L L^T              z_j is t with f: what parameter j adds to those before it
    T = vPv                                          chi square with f, for sigma0 = 1

The squares of sigma0 z are the amounts by which vPv falls when the parameters enter one after the other; they are
orthogonal, so that each stands for itself (Gram-Schmidt; Gruen 1978, Jacobsen 1980 test such transformed parameters).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.special

from adjust.adjustment import Adjustment, Name
from adjust.model import EXTERIOR_NAMES
from simfield.block import Floats


@dataclass(frozen=True, eq=False)
class ApSignificance:
    """The additional parameters (a) of one camera, tested.

    t, p: two-sided test of each beside all others. z, p_added: of what each adds to those before it. with_exterior: the
    multiple correlation with the exterior orientation of all images; with_all: with all other orientation unknowns.
    Near 1 a parameter cannot be determined. strongest: the single element most correlated with it, and r.
    """

    names: tuple[str, ...]
    values: Floats
    std: Floats
    t: Floats
    p: Floats
    z: Floats
    p_added: Floats
    with_exterior: Floats
    with_all: Floats
    strongest: tuple[tuple[str, str, float], ...]


@dataclass(frozen=True)
class FTest:
    """Fisher's test of a group of k parameters against f degrees of freedom."""

    statistic: float
    k: int
    f: int
    p: float


@dataclass(frozen=True)
class GlobalTest:
    """The test of sigma0 = 1: vPv against its bounds lower and upper at level alpha, two-sided."""

    vpv: float
    redundancy: int
    alpha: float
    lower: float
    upper: float
    p: float

    @property
    def passed(self) -> bool:
        return self.lower <= self.vpv <= self.upper


def global_test(a: Adjustment, alpha: float = 0.05) -> GlobalTest:
    """vPv against chi square with f degrees of freedom: do the a priori standard deviations and the model hold?"""
    f, vpv = a.redundancy, a.vpv
    lower, upper = (float(scipy.special.chdtri(f, 1.0 - q)) for q in (alpha / 2.0, 1.0 - alpha / 2.0))
    below = float(scipy.special.chdtr(f, vpv))
    return GlobalTest(vpv, f, alpha, lower, upper, 2.0 * min(below, float(scipy.special.chdtrc(f, vpv))))


def student_p(t: Floats, f: int) -> Floats:
    """The two-sided level at which |t| is exceeded, Student's t with f degrees of freedom."""
    return np.asarray(2.0 * scipy.special.stdtr(f, -np.abs(t)))


def f_test(a: Adjustment, *names: Name) -> FTest:
    """Are the named unknowns, such as ("ww", "b1"), all 0? Raises KeyError for an unknown name."""
    at = np.array([a.layout.index(*name) for name in names], dtype=np.intp)
    x = a.x[at]
    q = a.cofactors.block(at, at)
    scale = np.sqrt(np.diag(q))
    whole = float((x / scale) @ np.linalg.solve(q / scale / scale[:, None], x / scale))
    statistic = whole / (len(at) * a.sigma0**2)
    return FTest(statistic, len(at), a.redundancy, float(scipy.special.fdtrc(len(at), a.redundancy, statistic)))


def ap_significance(a: Adjustment, camera_id: str) -> ApSignificance:
    """The additional parameters of a camera, tested. Raises KeyError for a camera without, ValueError after a
    failure.
    """
    found = a.ap[camera_id]
    at = [a.layout.index(camera_id, name) for name in found.names]
    if not at:
        nothing = np.zeros(0)
        n = nothing
        return ApSignificance((), n, n, n, n, n, n, n, n, ())
    q = a.regular.cofactors.orientation
    t = found.values / found.std
    z = _added(found.values, q[np.ix_(at, at)]) / a.sigma0
    exterior = np.arange(6 * len(a.block.images))
    return ApSignificance(
        found.names,
        found.values,
        found.std,
        t,
        student_p(t, a.redundancy),
        z,
        student_p(z, a.redundancy),
        multiple_correlation(q, at, exterior),
        np.array([multiple_correlation(q, [j], np.delete(np.arange(len(q)), j))[0] for j in at]),
        tuple(_strongest(a, q, j) for j in at),
    )


def multiple_correlation(q: Floats, at: Sequence[int], others: np.typing.NDArray[np.intp]) -> Floats:
    """The multiple correlation of each unknown `at` with all `others`, from cofactors q: sqrt(q_jo Q_oo^-1 q_oj /
    q_jj).
    """
    std = np.sqrt(np.diag(q))
    r = q / std / std[:, None]
    across = r[others][:, list(at)]
    inner = scipy.linalg.solve(r[np.ix_(others, others)], across, assume_a="pos", check_finite=False)
    return np.asarray(np.sqrt(np.clip(np.einsum("oj,oj->j", across, inner), 0.0, 1.0)))


def _added(x: Floats, q: Floats) -> Floats:
    """L^T x with Q^-1 = L L^T, by the cofactors scaled to correlations."""
    scale = np.sqrt(np.diag(q))
    inverse = np.linalg.inv(q / scale / scale[:, None])
    return np.asarray(np.linalg.cholesky((inverse + inverse.T) / 2.0).T @ (x / scale))


def _strongest(a: Adjustment, q: Floats, j: int) -> tuple[str, str, float]:
    std = np.sqrt(np.diag(q))
    r = q[j] / std / std[j]
    r[j] = 0.0
    i = int(np.argmax(np.abs(r)))
    images = 6 * len(a.block.images)
    if i < images:
        return a.block.images.ids[i // 6], EXTERIOR_NAMES[i % 6], float(r[i])
    for s in a.layout.sets:
        if s.columns.start <= i < s.columns.stop:
            return s.id, s.model.parameters[i - s.columns.start], float(r[i])
    return "", a.layout.name(i), float(r[i])


def finer_sets(coarse: Adjustment, fine: Adjustment) -> FTest:
    """Are more sets of additional parameters (`ap_by`) worth it? F of vPv of the coarser and the finer adjustment.

    F = ((vPv_c - vPv_f) / k) / (vPv_f / f) with k more parameters and redundancy f of the finer one is Fisher's if the
    coarser choice is true (Koch 1999, Parameter estimation, section 4.2). Raises ValueError if the finer one does not
    have more unknowns, or if one of the two has failed.
    """
    more = fine.unknowns - coarse.unknowns
    if not (coarse.status.ok and fine.status.ok):
        raise ValueError("a test of two adjustments needs two that have succeeded")
    if more <= 0 or fine.redundancy <= 0:
        raise ValueError(f"the finer adjustment has {more} more unknowns and redundancy {fine.redundancy}: no test")
    statistic = float((coarse.vpv - fine.vpv) / more / (fine.vpv / fine.redundancy))
    return FTest(statistic, more, fine.redundancy, float(scipy.special.fdtrc(more, fine.redundancy, statistic)))
