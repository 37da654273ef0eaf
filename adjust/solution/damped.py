"""Damped steps (Levenberg 1944, Marquardt 1963), for blocks on which Gauss-Newton comes to nothing.

A step solves (N + lambda D) dx = -g with D the diagonal of N. lambda follows the gain, what vPv falls by over what the
linear model foretells (Nielsen 1999, Damping parameter in Marquardt's method, IMM-REP-1999-05). Where the steps have
become short, Gauss-Newton finishes, with its own rule of convergence and its own look at singularity: damping hides a
defect, it does not mend one.
"""

from __future__ import annotations

from collections.abc import Callable

from adjust.normals import Arithmetic, SingularError
from adjust.observations import Observations
from adjust.solution.iteration import ITERATIONS_MOST, Solution, solve
from adjust.status import Status
from simfield.block import Floats

FIRST_DAMPING = 1e-3
DAMPING_MOST = 1e12
GAIN_LEAST = 1e-4
SHORT = 1e-2
"""standard deviations; from here Gauss-Newton is at home"""
SLOWLY = 10 * ITERATIONS_MOST
"""steps of the finish: where residuals are large it contracts slowly"""
WORTH_TRYING = (Status.NOT_CONVERGED, Status.BEHIND_CAMERA, Status.NOT_FINITE, Status.SINGULAR)
STEPS_MOST, FROM_SINGULAR_MOST = 300, 20
"""damped steps; what is singular at the start may not be so at the minimum, but in most cases it is"""


def minimised(
    observations: Observations,
    start: Floats,
    arithmetic: Arithmetic,
    believed: Callable[[Floats], bool] = lambda x: True,
) -> Solution:
    """The minimum of vPv from `start`: by Gauss-Newton, and where that fails by damped steps and Gauss-Newton.

    believed: whether a minimum at x that damped steps led to may be the answer; they go far where a start is wrong.
    """
    found = solve(observations, start, arithmetic)
    if found.status not in WORTH_TRYING:
        return found
    singular_start = found.status is Status.SINGULAR and found.iterations == 1
    nearer, steps = damped(start, arithmetic, FROM_SINGULAR_MOST if singular_start else STEPS_MOST)
    if not steps:
        return found
    again = solve(observations, nearer, arithmetic, ITERATIONS_MOST if singular_start else SLOWLY)
    if not again.status.ok or not believed(again.x):
        return found
    return Solution(again.x, again.status, again.detail, found.iterations + steps + again.iterations)


def damped(start: Floats, arithmetic: Arithmetic, most: int) -> tuple[Floats, int]:
    """Where `most` tries of damped steps lead from `start`, and how many were taken: 0 where none lowers vPv."""
    x, normals = start, arithmetic.at(start)
    if not normals.finite:
        return start, 0
    damping, faster, taken = FIRST_DAMPING, 2.0, 0
    for _ in range(most):
        try:
            step, length = arithmetic.factorise(normals.damped(damping), 0.0).step(normals)
        except SingularError:
            damping, faster = damping * faster, 2.0 * faster
            if damping > DAMPING_MOST:
                break
            continue
        there = arithmetic.at(x + step)
        foretold = length**2 + damping * float(normals.diagonal @ step**2)
        gain = (normals.vpv - there.vpv) / foretold if foretold > 0.0 else 0.0
        # a point may stand behind a camera at the start; none may come to stand there
        in_front = there.depth > 0.0 or (taken == 0 and not normals.depth > 0.0)
        if there.finite and in_front and gain > GAIN_LEAST:
            x, normals, taken = x + step, there, taken + 1
            damping, faster = damping * max(1.0 / 3.0, 1.0 - (2.0 * gain - 1.0) ** 3), 2.0
            if length < SHORT and damping < FIRST_DAMPING:
                break
        else:
            damping, faster = damping * faster, 2.0 * faster
            if damping > DAMPING_MOST or length == 0.0:
                break
    return x, taken
