"""Gauss-Newton iteration with step control, and the rule by which it ends.

The length of a step, d = (dx^T N dx)^(1/2), bounds the change of every unknown in units of its own standard deviation
(Cauchy-Schwarz; standard deviations for sigma0 = 1). The iteration has converged when d <= STEP_ENOUGH, or when d has
come down to what rounding of the observations alone can cause. The last step is still applied, so what is left is
smaller by another factor of contraction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adjust.normals import Factor, Normals, SingularError, assemble, factorise
from adjust.observations import Observations
from adjust.rank_defect import explain, hardly_separable
from adjust.status import CHECK_START, Status
from simfield.block import Floats

STEP_ENOUGH = 1e-8
ROUNDING = 16 * np.finfo(float).eps
ITERATIONS_MOST = 50
HALVINGS_MOST = 12


@dataclass(frozen=True, eq=False)
class Solution:
    """Where the iteration ended: x, the normal equations there (None where none could be solved), and how."""

    x: Floats
    normals: Normals | None
    factor: Factor | None
    status: Status
    detail: str
    iterations: int


def solve(observations: Observations, start: Floats) -> Solution:
    """Minimise vPv from `start`."""
    behind = points_behind(observations, start)
    if behind:
        return Solution(start, None, None, Status.BEHIND_CAMERA, behind, 0)
    enough = max(STEP_ENOUGH, ROUNDING * observations.magnitude)
    x, length = start, float("inf")
    normals: Normals | None = None
    for iteration in range(1, ITERATIONS_MOST + 1):
        normals = assemble(observations, x)
        if not normals.finite:
            return Solution(x, normals, None, Status.NOT_FINITE, _not_finite(observations, iteration), iteration)
        try:
            factor = factorise(normals)
        except SingularError as error:
            detail = explain(error, observations, x) + (
                f" (not so at the start; {CHECK_START})" if iteration > 1 else ""
            )
            return Solution(x, normals, None, Status.SINGULAR, detail, iteration)
        step, length = factor.step(normals)
        if not np.isfinite(length):
            return Solution(x, normals, None, Status.NOT_FINITE, _not_finite(observations, iteration), iteration)
        if length <= enough:
            return Solution(x + step, normals, factor, Status.CONVERGED, "", iteration)
        shorter = _shorten(observations, x, step, normals.vpv, length)
        if shorter is None:
            return Solution(x, normals, None, *_stuck(observations, x + step, length, factor), iteration)
        x = shorter
    detail = f"after {ITERATIONS_MOST} iterations the last step was {length:.2g} standard deviations"
    detail += hardly_separable(factor, observations)
    return Solution(x, normals, None, Status.NOT_CONVERGED, detail, ITERATIONS_MOST)


def _shorten(observations: Observations, x: Floats, step: Floats, vpv: float, length: float) -> Floats | None:
    """x plus the longest of step, step/2, step/4, ... that lowers vPv; None if none does."""
    slack = 1e-12 * vpv + length**2 * 1e-6
    for halving in range(HALVINGS_MOST + 1):
        there = x + step * 0.5**halving
        if observations.cost(there) <= vpv + slack:
            return there
    return None


def _stuck(observations: Observations, x: Floats, length: float, factor: Factor) -> tuple[Status, str]:
    behind = points_behind(observations, x)
    if behind:
        return Status.BEHIND_CAMERA, behind
    detail = f"no step lowers vPv; the last was {length:.2g} standard deviations long"
    return Status.NOT_CONVERGED, detail + hardly_separable(factor, observations)


def _not_finite(observations: Observations, iteration: int) -> str:
    group = observations.image_points
    bad = np.argwhere(~np.isfinite(group.basis))
    if not bad.size:
        return f"in iteration {iteration}; check the standard deviations and the units"
    row, _, column = (int(i) for i in bad[0])
    ap = group.unknowns.sets[group.unknowns.image_set[group.image[row]]]
    x, y = group.xy[row]
    return f"the terms of {ap.model.parameters[column]} of camera {ap.id} are not finite at x = {x:g}, y = {y:g} mm"


def points_behind(observations: Observations, x: Floats) -> str:
    """Which point lies behind which camera; empty if none does."""
    group = observations.image_points
    _, depth = group.residuals(x)
    bad = ~(depth > 0.0)
    if not bad.any():
        return ""
    row = int(np.argmax(bad))
    block = group.unknowns.block
    point, image = block.points.ids[group.point[row]], block.images.ids[group.image[row]]
    more = f" and {int(bad.sum()) - 1} more" if bad.sum() > 1 else ""
    return f"point {point} behind image {image}{more}; {CHECK_START}"
