"""Gauss-Newton iteration with step control, and the rule by which it ends.

The length of a step, d = (g^T N^-1 g)^(1/2), bounds the change of every unknown in units of its own standard deviation
(Cauchy-Schwarz; standard deviations for sigma0 = 1). Full steps, with new normal equations, are taken until a step is
shorter than CHORD_BELOW; from there the last factorisation serves on, with new gradients only (chord steps), as long as
it contracts. The iteration has converged when the error left after a step, bounded by the step and the contraction
observed, d q / (1 - q) with q = d / d_before, is at most ERROR_LEFT, or when d has come down to what rounding of the
observations alone can cause.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from adjust.normals import Arithmetic, SingularError
from adjust.observations import Observations
from adjust.solution.rank_defect import explain
from adjust.status import CHECK_START, Status
from simfield.block import Floats

ERROR_LEFT = 1e-9
CHORD_BELOW = 100.0
CONTRACTION_MOST = 0.05
"""a chord step that contracts less asks for new normal equations"""
CONTRACTION_LEAST = 0.01
"""less is not believed: the first steps near a minimum show how the bulk of the error contracts, not all of it"""
ROUNDING = 16 * np.finfo(float).eps
ITERATIONS_MOST = 100
SMALL_STEP = 1e-7
"""a step this short that lowers vPv no more moves between the last digits: without noise vPv itself is rounding"""
LAST_DIGITS, IDLE_STEPS = 1e-8, 15
"""standard deviations, and how many steps in turn, of an iteration that goes to and fro between the last digits"""
NEARLY_SINGULAR = 1e-8
"""reciprocal condition at which an iteration that does not converge is laid to the normal equations"""
HALVINGS_MOST = 12


@dataclass(frozen=True, eq=False)
class Solution:
    """Where the iteration ended: x, how, and after how many steps."""

    x: Floats
    status: Status
    detail: str
    iterations: int


def solve(observations: Observations, start: Floats, arithmetic: Arithmetic, most: int = ITERATIONS_MOST) -> Solution:
    """Minimise vPv from `start`, in `most` steps at most."""
    of_images, of_all = (ROUNDING * size for size in observations.magnitude)
    x, normals = start, arithmetic.at(start)
    if not normals.depth > 0.0:
        return Solution(start, Status.BEHIND_CAMERA, points_behind(observations, start), 0)
    factor: Any = None
    chord, length = False, np.inf
    lengths: list[float] = []
    for iteration in range(1, most + 1):
        if not normals.finite:
            return Solution(x, Status.NOT_FINITE, _not_finite(observations, iteration), iteration)
        try:
            factor = factor if chord else arithmetic.factorise(normals)
        except SingularError as error:
            return Solution(x, Status.SINGULAR, explain(error, observations, x), iteration)
        before = length
        step, length = factor.step(normals)
        if not np.isfinite(length):
            return Solution(x, Status.NOT_FINITE, _not_finite(observations, iteration), iteration)
        contraction = min(max(length / before, CONTRACTION_LEAST), 0.5) if np.isfinite(before) else 0.5
        # priors as sharp as the last digit of their value round by more than others converge to
        rounds = length <= of_images or (length <= of_all and length > 0.5 * before)
        if rounds or length * contraction / (1.0 - contraction) <= ERROR_LEFT:
            return Solution(x + step, Status.CONVERGED, "", iteration)
        # a factorisation on the verge of singularity must be made anew at the end, where it may be singular
        contracts = not chord or length < CONTRACTION_MOST * before
        chord = length < CHORD_BELOW and contracts and factor.condition > NEARLY_SINGULAR
        advanced = _advance(arithmetic, x, step, normals.vpv * (1.0 + 1e-12) + 1e-6 * length**2, chord)
        if advanced is None and length <= SMALL_STEP:
            return Solution(x, Status.CONVERGED, "", iteration)
        if advanced is None:
            return _given_up(observations, x, _stuck(observations, x + step, length), iteration, arithmetic)
        x, normals, chord = advanced
        lengths.append(length)
    if _is_rounding(lengths):
        return Solution(x, Status.CONVERGED, "", most)
    detail = f"after {most} iterations the last step was {length:.2g} standard deviations"
    return _given_up(observations, x, (Status.NOT_CONVERGED, detail), most, arithmetic)


def _is_rounding(lengths: list[float]) -> bool:
    """Whether steps have long been short and become no shorter: the last digits of weak geometry."""
    earlier, late = lengths[-2 * IDLE_STEPS : -IDLE_STEPS], lengths[-IDLE_STEPS:]
    return max(late) <= LAST_DIGITS and min(late) > 0.9 * min(earlier)


def _advance(
    arithmetic: Arithmetic, x: Floats, step: Floats, most: float, chord: bool
) -> tuple[Floats, Any, bool] | None:
    """x plus the longest of step, step/2, step/4, ... whose vPv is at most `most`, with what is needed there next."""
    for halving in range(HALVINGS_MOST + 1):
        there = x + step * 0.5**halving
        chord = chord and halving == 0
        normals = arithmetic.gradient(there) if chord else arithmetic.at(there)
        if normals.depth > 0.0 and normals.vpv <= most:
            return there, normals, chord
    return None


def _given_up(
    observations: Observations, x: Floats, end: tuple[Status, str], iteration: int, arithmetic: Arithmetic
) -> Solution:
    """An iteration that leads nowhere: where the normal equations are nearly singular there, that is the reason."""
    if end[0] is Status.NOT_CONVERGED:
        try:
            arithmetic.factorise(arithmetic.at(x), NEARLY_SINGULAR)
        except SingularError as error:
            return Solution(x, Status.SINGULAR, explain(error, observations, x), iteration)
    return Solution(x, *end, iteration)


def _stuck(observations: Observations, x: Floats, length: float) -> tuple[Status, str]:
    behind = points_behind(observations, x)
    if behind:
        return Status.BEHIND_CAMERA, behind
    return Status.NOT_CONVERGED, f"no step lowers vPv; the last was {length:.2g} standard deviations long"


def _not_finite(observations: Observations, iteration: int) -> str:
    group = observations.image_points
    bad = np.argwhere(~np.isfinite(group.basis))
    if not bad.size:
        return f"in iteration {iteration}; check the standard deviations and the units"
    row, _, column = (int(i) for i in bad[0])
    ap = group.unknowns.sets[group.unknowns.image_set[group.image[row]]]
    x, y = group.xy[row]
    term = f"{ap.model.parameters[column]} of {group.unknowns.owner_of(ap)}"
    return f"the terms of {term} are not finite at x = {x:g}, y = {y:g} mm"


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
