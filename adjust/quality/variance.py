"""Variance components: how precise were the observations of each group really?

The covariance matrix of the observations is taken as the sum of theta_i Sigma_i over the groups, Sigma_i the a priori
one. With r the redundancy matrix in units of standard deviations, Helmert's equations say what the weighted sums of
squares of the groups should be (Helmert 1907; Grafarend, Schaffrin 1980; the trace form is Kubik's, the iteration
Foerstner's, ZfV 104, 1979):

    sum_j H_ij theta_j = v_i^T P_i v_i,   H_ij = tr(r_ij r_ji),   sum_j H_ij = r_i, the redundancy of group i.

Weights are divided by theta and the block is adjusted again, until all theta are 1: there v_i^T P_i v_i = r_i, as in
Foerstner's simpler iteration, the estimate is that of restricted maximum likelihood, and 2 H^-1 is the covariance
matrix of the factors. A step changes no factor by more than STEP_MOST, for Helmert's solution can be negative.

H needs no n x n matrix. With h_kl = t_k . t_l + b_k . b_l (adjust.quality.influence) the sum of its squares over two
groups is

    tr(G_i G_j) + sum over points of 2 <M_i, M_j> + <B_i, B_j>,   G = sum t t^T, M = sum t b^T, B = sum b b^T.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from adjust.adjustment import Adjustment
from adjust.bundle import reweighted
from adjust.quality.influence import Influence
from simfield.block import Floats, Indices

CHANGE_LEFT = 1e-4
"""of the factors in their standard deviations, where the iteration ends"""
STD_MOST = 1.0
"""of a factor in its own size, from which on it does not make the iteration end earlier"""
ROUNDS_MOST = 50
STEP_MOST = 10.0
REDUNDANCY_LEAST = 1.0
"""a group of less redundancy keeps its a priori standard deviations: nothing checks it"""
FACTOR_LEAST = 1e-4
"""a factor that tends to 0 or below stops here: the errors of the group are too small for its redundancy to show
them
"""
CONTROL = "control"


@dataclass(frozen=True, eq=False)
class VarianceComponents:
    """The groups by name; count of observations, redundancy, the factor of the a priori variances and its standard
    deviation (NaN for groups that were held: at 1 without redundancy, at FACTOR_LEAST without visible errors), and the
    adjustment with the variances found, whose sigma0 is 1."""

    names: tuple[str, ...]
    count: Indices
    redundancy: Floats
    factor: Floats
    factor_std: Floats
    adjustment: Adjustment
    rounds: int
    converged: bool

    @property
    def held(self) -> npt.NDArray[np.bool_]:
        """Groups whose factor was not estimated."""
        return np.isnan(self.factor_std)

    @property
    def sigma_factor(self) -> Floats:
        """The factor of the a priori standard deviations."""
        return np.sqrt(self.factor)

    @property
    def sigma_factor_std(self) -> Floats:
        return np.asarray(0.5 * self.factor_std / self.sigma_factor)


def groups_by_camera(a: Adjustment) -> dict[str, Indices]:
    """The usual groups: the image coordinates of each camera, weighted control, and each further group; rows by
    name.
    """
    b = a.block
    camera = np.repeat(b.images.camera[b.observations.image], 2)
    groups = {f"images of {c.camera_id}": np.flatnonzero(camera == i) for i, c in enumerate(b.cameras)}
    groups[CONTROL] = len(camera) + np.arange(len(a.groups.control.columns))
    start = len(camera) + len(groups[CONTROL])
    for group in a.groups.further:
        # two lists of distances are one group of observations
        earlier = groups.get(group.name, np.empty(0, dtype=np.intp))
        groups[group.name] = np.append(earlier, start + np.arange(len(group.weight)))
        start += len(group.weight)
    return {name: rows for name, rows in groups.items() if len(rows)}


def variance_components(a: Adjustment, groups: Mapping[str, Indices] | None = None) -> VarianceComponents:
    """Estimate one factor a group, by default of `groups_by_camera`; rows in no group keep their weights.

    Raises ValueError where an adjustment fails, when groups overlap, or where their components cannot be told apart.
    """
    groups = groups_by_camera(a) if groups is None else groups
    label = _labels(a, groups)
    factor, converged, rounds = np.ones(len(groups)), False, 0
    weights, current, damping = a.groups.weights, a, _Damping(len(groups))
    while True:
        helmert, squares, count = _helmert(Influence.of(current), label, len(groups) + 1)
        redundancy = helmert.sum(axis=1)[:-1]
        estimated = (redundancy >= REDUNDANCY_LEAST) & (factor > FACTOR_LEAST)
        try:
            std, theta = _relative_std(helmert, estimated), _solution(helmert, squares, estimated)
        except np.linalg.LinAlgError as error:
            raise ValueError(f"the variance components of {', '.join(groups)} cannot be told apart") from error
        # of the equations themselves, and not of a step that was shortened
        change = np.abs(theta - 1.0) / np.minimum(std, STD_MOST)
        converged = not bool((change[estimated] > CHANGE_LEFT).any())
        if converged or rounds == ROUNDS_MOST:
            break
        step = damping.step(np.clip(theta, 1.0 / STEP_MOST, STEP_MOST))
        factor, rounds = np.maximum(factor * step, FACTOR_LEAST), rounds + 1
        current = reweighted(current, weights / np.append(factor, 1.0)[label])
        if not current.status.ok:
            raise ValueError(f"the block cannot be adjusted with these variances: {current.message}")
    return VarianceComponents(tuple(groups), count[:-1], redundancy, factor, factor * std, current, rounds, converged)


class _Damping:
    """Helmert's steps are too long or too short where a group has little redundancy: where they do not shrink to half
    from round to round, they are halved after a change of direction, and grow otherwise."""

    def __init__(self, size: int) -> None:
        self.last, self.share = np.zeros(size), np.ones(size)

    def step(self, theta: Floats) -> Floats:
        """The factor to take instead of theta, both near 1 at the end."""
        raw = np.log(theta)
        slow = np.abs(raw) > 0.5 * np.abs(self.last)
        direction = np.where(slow, np.sign(raw * self.last), 0.0)
        self.share = np.clip(self.share * np.choose((direction + 1).astype(int), [0.5, 1.0, 1.5]), 0.25, 20.0)
        self.last = raw
        return np.exp(np.clip(self.share * raw, -np.log(STEP_MOST), np.log(STEP_MOST)))


def _relative_std(helmert: Floats, estimated: npt.NDArray[np.bool_]) -> Floats:
    """The standard deviation of every factor in units of the factor, NaN for those that are held."""
    std = np.full(len(estimated), np.nan)
    at = np.flatnonzero(estimated)
    if at.size:
        std[at] = np.sqrt(2.0 * np.diag(np.linalg.inv(helmert[np.ix_(at, at)])))
    return std


def _labels(a: Adjustment, groups: Mapping[str, Indices]) -> Indices:
    """(n) the number of each row's group; rows in none get the number after the last."""
    label = np.full(a.groups.rows, len(groups), dtype=np.intp)
    for number, (name, rows) in enumerate(groups.items()):
        if (label[rows] != len(groups)).any():
            raise ValueError(f"{name}: an observation of this group stands in another one, too")
        label[rows] = number
    return label


def _solution(helmert: Floats, squares: Floats, estimated: npt.NDArray[np.bool_]) -> Floats:
    """theta of every group, 1 for those that are held."""
    at = np.flatnonzero(estimated)
    held = np.setdiff1d(np.arange(len(helmert)), at)
    right = squares[at] - helmert[np.ix_(at, held)].sum(axis=1)
    theta = np.ones(len(estimated))
    if at.size:
        theta[at] = np.linalg.solve(helmert[np.ix_(at, at)], right)
    return theta


def _helmert(influence: Influence, label: Indices, size: int) -> tuple[Floats, Floats, Indices]:
    """H (size, size), v^T P v (size) and the number of observations (size) of every group."""
    counted = influence.rows.weight > 0.0
    count: Indices = np.bincount(label[counted], minlength=size)
    squares = np.bincount(label, weights=influence.rows.standard**2, minlength=size)
    leverage = np.bincount(label, weights=influence.leverage, minlength=size)
    gram = np.array([influence.t[label == i].T @ influence.t[label == i] for i in range(size)]).reshape(size, -1)
    helmert = np.diag(count - 2.0 * leverage) + gram @ gram.T + _by_points(influence, label, size)
    return np.asarray(helmert), np.asarray(squares, dtype=float), count


def _by_points(influence: Influence, label: Indices, size: int) -> Floats:
    """The part of the sums of squares of h that observations of the same point contribute."""
    total = np.zeros((size, size))
    point = influence.rows.point
    order = np.argsort(point, kind="stable")
    bounds = np.searchsorted(point[order], np.arange(len(influence.factor.root) + 1))
    for start, stop in pairwise(bounds):
        rows = order[start:stop]
        member = (label[rows] == np.arange(size)[:, None]).astype(float)
        t, b = influence.t[rows], influence.b[rows]
        weighted = member[:, None, :] * b.T
        spread, blocks = (weighted @ t).reshape(size, -1), (weighted @ b).reshape(size, -1)
        total += 2.0 * spread @ spread.T + blocks @ blocks.T
    return total
