"""Normal equations with the object points eliminated (Schur complement), in plain numpy.

With e the orientation unknowns and p the point coordinates, and N = A^T P A, g = A^T P v,

    [ N_ee  W^T ] [dx_e]      [g_e]
    [ W     V   ] [dx_p]  = - [g_p]

V consists of one 3 x 3 block a point. The reduced matrix is S = N_ee - W^T V^-1 W (Triggs et al. 2000, section 6).
All columns are scaled to a unit diagonal before they are factorised, so that "singular" has one meaning for metres,
radians and mm^-6 alike.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import scipy.linalg

from adjust.observations import Observations, group as further
from simfield.block import Floats, Indices

CONDITION_LEAST = 3e-15
"""smallest reciprocal condition number of the scaled reduced matrix. Singular blocks come out below 2e-16, control
that is known to 1 km still at 2e-13. Pivots do not tell: after two weak ones a singular matrix can end on 1e-8."""
PROBES = 4
DETERMINANT_LEAST = 1e-13
"""smallest determinant of a scaled point block: that of two rays which differ by 6e-7 rad"""


class SingularError(ArithmeticError):
    """The normal equations are singular. scaled: the scaled matrix; columns: where its columns stand in x."""

    def __init__(self, scaled: Floats, scale: Floats, columns: slice) -> None:
        super().__init__("singular normal equations")
        self.scaled, self.scale, self.columns = scaled, scale, columns


@dataclass(frozen=True, eq=False)
class Normals:
    """Assembled normal equations: ee (E, E), pe (n, 3, E), pp (n, 3, 3), the gradients e (E), p (n, 3), and vPv."""

    ee: Floats
    pe: Floats
    pp: Floats
    gradient_e: Floats
    gradient_p: Floats
    vpv: float
    depth: float
    """the least depth of a point before a camera, m"""

    @property
    def finite(self) -> bool:
        """Whether all numbers are finite."""
        arrays = (self.ee, self.pe, self.pp, self.gradient_e, self.gradient_p)
        return bool(np.isfinite(self.vpv)) and all(bool(np.isfinite(a).all()) for a in arrays)

    @property
    def diagonal(self) -> Floats:
        """(size) of the normal equations, orientation first."""
        return np.concatenate([np.diag(self.ee), np.einsum("nii->ni", self.pp).ravel()])

    def damped(self, share: float) -> Normals:
        """The same with the diagonal larger by a share."""
        ee, pp = self.ee.copy(), self.pp.copy()
        np.einsum("ii->i", ee)[:] *= 1.0 + share
        np.einsum("nii->ni", pp)[:] *= 1.0 + share
        return replace(self, ee=ee, pp=pp)


def assemble(observations: Observations, x: Floats) -> Normals:
    """The normal equations of all groups at x."""
    points = observations.image_points
    u = points.unknowns
    size, n = u.orientation, len(u.block.points)
    ee, pe, pp = np.zeros((size, size)), np.zeros((n, 3, size)), np.zeros((n, 3, 3))
    gradient_e, gradient_p = np.zeros(size), np.zeros((n, 3))
    at = points.jacobian(x)
    weighted = points.weight[:, :, None] * at.by_orientation
    weighted_point = points.weight[:, :, None] * at.by_point
    crossed = at.by_point.transpose(0, 2, 1) @ weighted
    blocks = weighted_point.transpose(0, 2, 1) @ at.by_point
    for image in range(len(u.block.images)):
        rows = slice(points.starts[image], points.starts[image + 1])
        s = u.sets[u.image_set[image]]
        width = 6 + len(s.model.parameters)
        columns = np.r_[6 * image : 6 * image + 6, s.columns]
        jacobian = at.by_orientation[rows, :, :width].reshape(-1, width)
        right = weighted[rows, :, :width].reshape(-1, width)
        seen = points.point[rows]
        ee[np.ix_(columns, columns)] += right.T @ jacobian
        gradient_e[columns] += right.T @ at.v[rows].ravel()
        # a point stands at most once in an image, so fancy-index addition loses nothing
        pe[seen[:, None, None], np.arange(3)[:, None], columns] += crossed[rows, :, :width]
        pp[seen] += blocks[rows]
        gradient_p[seen] += np.einsum("kij,ki->kj", weighted_point[rows], at.v[rows])
    control = observations.control
    v, alone = control.residuals(x), control.columns >= size
    at_point, axis = np.divmod(control.columns[alone] - size, 3)
    np.add.at(pp, (at_point, axis, axis), control.weight[alone])
    gradient_p[at_point, axis] += (control.weight * v)[alone]
    fixed_point, fixed_axis = np.nonzero(u.held)
    pp[fixed_point, fixed_axis, fixed_axis] = 1.0
    vpv = float(np.sum(points.weight * at.v**2) + np.sum(control.weight * v**2))
    forms, more = observations.beside_elimination(x)
    further.add_gradient(observations.beside_elimination(x, gradient_only=True)[0], gradient_e)
    further.add_dense(forms, ee)
    vpv += more
    return Normals(ee, pe, pp, gradient_e, gradient_p, vpv, float(at.depth.min()))


@dataclass(frozen=True, eq=False)
class Plain:
    """The arithmetic of this module, for adjust.solution.iteration: readable, and what the compiled one is tested
    against.
    """

    observations: Observations

    def at(self, x: Floats) -> Normals:
        return assemble(self.observations, x)

    def gradient(self, x: Floats) -> Normals:
        return assemble(self.observations, x)

    def factorise(self, normals: Normals, condition_least: float = CONDITION_LEAST) -> FactorisedNormals:
        return factorise(normals, condition_least)


@dataclass(frozen=True, eq=False)
class FactorisedNormals:
    """Factorised normal equations.

    lower (E, E) is the Cholesky factor of the scaled S, so that S^-1 = D (lower lower^T)^-1 D with D = diag(scale);
    root (n, 3, 3) = L^-1 with V = L L^T, and white (n, 3, E) = L^-1 W.
    """

    scale: Floats
    lower: Floats
    root: Floats
    white: Floats
    condition: float
    """the reciprocal condition of the scaled S"""

    def spread(self, at: Indices) -> Floats:
        """(len(at), E): rows of [I; -V^-1 W], by which the unknowns at these places hang on the orientation."""
        size = len(self.scale)
        rows = np.zeros((len(at), size))
        inside, outside = np.flatnonzero(at < size), np.flatnonzero(at >= size)
        rows[inside, at[inside]] = 1.0
        point, axis = np.divmod(at[outside] - size, 3)
        rows[outside] = -np.einsum("kq,kqe->ke", self.root[point, :, axis], self.white[point])
        return rows

    def step(self, normals: Normals) -> tuple[Floats, float]:
        """The Gauss-Newton step -N^-1 g as one vector, and its length in standard deviations, (g^T N^-1 g)^(1/2)."""
        white = self.white.reshape(-1, len(self.scale))
        white_g = (self.root @ normals.gradient_p[:, :, None])[:, :, 0]
        reduced = normals.gradient_e - white_g.ravel() @ white
        step_e = -self.scale * scipy.linalg.lapack.dpotrs(self.lower, self.scale * reduced, lower=1)[0]
        hanging = white_g + (white @ step_e).reshape(-1, 3)
        step_p = -(hanging[:, None, :] @ self.root)[:, 0]
        decrement = -float(normals.gradient_e @ step_e + np.sum(normals.gradient_p * step_p))
        return np.concatenate([step_e, step_p.ravel()]), max(decrement, 0.0) ** 0.5


def factorise(normals: Normals, condition_least: float = CONDITION_LEAST) -> FactorisedNormals:
    """Eliminate the points and factorise. Raises SingularError with the scaled matrix that is singular."""
    root = _root_of_point_blocks(normals.pp, normals.ee.shape[0])
    white = root @ normals.pe
    flat = white.reshape(-1, normals.ee.shape[0])
    reduced = normals.ee - flat.T @ flat
    diagonal = np.diag(normals.ee)
    # scaled by N_ee, not S: what is small in the result is what the other unknowns leave over of a column
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    scaled = reduced * scale * scale[:, None]
    lower, info = scipy.linalg.lapack.dpotrf(scaled, lower=1, clean=1)
    condition = reciprocal_condition(lower, scaled) if info == 0 else 0.0
    if condition < condition_least:
        raise SingularError(scaled, scale, slice(0, len(scale)))
    return FactorisedNormals(scale, lower, root, white, condition)


def reciprocal_condition(lower: Floats, matrix: Floats) -> float:
    """1 / (|M| |M^-1|) from the Cholesky factor `lower` of M, |M| in the 1-norm."""
    norm = float(scipy.linalg.lapack.dlange("1", matrix))
    return 1.0 / (norm * inverse_norm(lambda b: scipy.linalg.lapack.dpotrs(lower, b, lower=1)[0], len(lower)))


def inverse_norm(solve: Callable[[Floats], Floats], size: int) -> float:
    """|M^-1| by inverse iteration, two steps from four random vectors, always the same; solve(b) is M^-1 b.

    LAPACK's estimator starts from a vector of ones, which is orthogonal to the null vector of two equal columns,
    (1, -1): it sees nothing of the commonest defect of all.
    """
    probes = solve(_probes(size))
    return float(np.linalg.norm(solve(probes / np.linalg.norm(probes, axis=0)), axis=0).max())


@cache
def _probes(size: int) -> Floats:
    """(size, PROBES) random vectors, not to be written to."""
    return np.asfortranarray(np.random.default_rng(0).standard_normal((size, PROBES)))


def _root_of_point_blocks(pp: Floats, size: int) -> Floats:
    """L^-1 (n, 3, 3) of V = L L^T, by scaled blocks. Raises SingularError for the first undetermined point."""
    diagonal = np.einsum("nii->ni", pp)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    scaled = pp * scale[:, :, None] * scale[:, None, :]
    determinant = np.linalg.det(scaled)
    # of a unit-diagonal positive matrix; parallel rays let it vanish
    bad = ~(determinant > DETERMINANT_LEAST)
    if bad.any():
        point = int(np.argmax(bad))
        raise SingularError(scaled[point], scale[point], slice(size + 3 * point, size + 3 * point + 3))
    return np.asarray(np.linalg.inv(np.linalg.cholesky(scaled)) * scale[:, None, :])
