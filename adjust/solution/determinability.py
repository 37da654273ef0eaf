"""Can this geometry tell a parameter from the exterior orientation? Looked at for those that a flat block cannot tell.

The measure is the share of a parameter's effect on the image points that no change of all other unknowns takes up,
1 / sqrt(n_jj q_jj), the sine of the angle between its column of the design matrix and all others. A parameter whose
share is below LEAST_SHARE has a standard deviation more than 1000 times as large as if all else were known. That
standard deviation is true, and with a long lens it may be all that is asked for; but lens distortion that the model
lacks ruins such a parameter. So it is said, and refused only where the iteration comes to nothing or the normal
equations are singular to working precision. Over flat ground with tilts of a degree the principal distance has 0.0002
to 0.0006, from convergent images 0.02.
"""

from __future__ import annotations

import numpy as np

from adjust.model import ApSet, Unknowns
from adjust.normals import Arithmetic, Cofactors, SingularError
from adjust.solution.iteration import Solution
from adjust.status import Status
from simfield.block import Floats, Indices

LEAST_SHARE = 1e-3


def judged(solution: Solution, unknowns: Unknowns, arithmetic: Arithmetic) -> Solution:
    """The solution with those parameters named that the geometry hardly determines, or a refusal where for them it did
    not converge.
    """
    doubtful = [(s, name) for s in unknowns.sets for name in s.model.why_not_estimable]
    if not doubtful or solution.status not in (Status.CONVERGED, Status.NOT_CONVERGED):
        return solution
    columns = np.array([s.columns.start + s.model.parameters.index(name) for s, name in doubtful])
    found = shares(unknowns, arithmetic, solution.x, columns)
    weak = [(s, name, share) for (s, name), share in zip(doubtful, found, strict=True) if share < LEAST_SHARE]
    if not weak:
        return solution
    status = Status.CONVERGED if solution.status is Status.CONVERGED else Status.SINGULAR
    said = "; ".join(_sentence(unknowns.owner_of(s), s, name, share, status) for s, name, share in weak)
    names = dict.fromkeys(name for _, name, _ in weak)
    quoted = ", ".join(f'"{name}"' for name in names) + ("," if len(names) == 1 else "")
    advice = f"; leave out without=({quoted})" if all("without" in s.model.settings for s, _, _ in weak) else ""
    return Solution(solution.x, status, said + advice, solution.iterations)


def shares(unknowns: Unknowns, arithmetic: Arithmetic, x: Floats, columns: Indices) -> Floats:
    """The share (len(columns)) of each additional parameter (its place in x) that all other unknowns leave over."""
    normals = arithmetic.at(x)
    if not normals.finite:
        return np.full(len(columns), np.nan)
    try:
        factor = arithmetic.factorise(normals)
    except SingularError:
        return np.full(len(columns), np.nan)
    q = np.diag(Cofactors(unknowns, factor).block(columns, columns))
    n = arithmetic.observations.image_points.squared_effects(x)[columns - 6 * len(unknowns.block.images)]
    return np.asarray(1.0 / np.sqrt(n * q))


def _sentence(owner: str, s: ApSet, name: str, share: float, status: Status) -> str:
    how = "hardly" if status.ok else "not"
    return (
        f"{name} of {owner} is {how} determined ({s.model.why_not_estimable[name]}): all other unknowns leave over "
        f"{100 * share:.2g} % of its effect"
    )
