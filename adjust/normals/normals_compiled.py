"""Normal equations assembled by compiled loops: the same as adjust.normals.normals, for one adjustment as fast as it
goes.

Two ways to reduce them. A block whose images nearly all share points with one another gets a dense reduced matrix, and
BLAS does the work. A large block gets a banded one: images are ordered so that those sharing points are neighbours
(reverse Cuthill-McKee), and the additional parameters, which touch every image, stand in a border.

Readable form: `adjust.normals.normals.Plain`. Agreement: `tests/adjust/normals/test_schur.py`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt
import scipy.linalg
import scipy.sparse

from adjust.model import rotation_matrices
from adjust.normals import loops_compiled as loops
from adjust.normals.band import BandFactor, SingularBandError, banded
from adjust.normals.normals import (
    CONDITION_LEAST,
    DETERMINANT_LEAST,
    FactorisedNormals,
    SingularError,
    reciprocal_condition,
)
from adjust.normals.ordering import BLAS_RATE, Ordering
from adjust.observations import Observations, group as further
from simfield.block import Floats, Indices

DENSE_ANYWAY = 3e6
"""a dense reduction of at most so many ns is not worth an ordering, which takes as long"""


EXPLAINED_MOST = 3000
"""orientation unknowns of which a null space is looked for; 10 000 would take gigabytes and an hour"""


@dataclass(frozen=True, eq=False)
class Gradient:
    """The gradients e (6m + A) and p (n, 3), vPv, and the least depth, m."""

    gradient_e: Floats
    gradient_p: Floats
    vpv: float
    depth: float

    @property
    def finite(self) -> bool:
        return bool(np.isfinite(self.vpv) and np.isfinite(self.gradient_e).all() and np.isfinite(self.gradient_p).all())


@dataclass(frozen=True, eq=False)
class CompiledNormals(Gradient):
    """Assembled normal equations of m images, k observations, n points, A additional parameters.

    ee (m, 6, 6) lower triangles, ea (m, 6, A), aa (A, A), pe (k, 3, 6), pa (n, 3, A), pp (n, 3, 3).
    """

    ee: Floats
    ea: Floats
    aa: Floats
    pe: Floats
    pa: Floats
    pp: Floats

    @property
    def diagonal(self) -> Floats:
        """(size) of the normal equations, orientation first."""
        exterior, points = (np.einsum("nii->ni", each).ravel() for each in (self.ee, self.pp))
        return np.concatenate([exterior, np.diag(self.aa), points])

    def damped(self, share: float) -> CompiledNormals:
        """The same with the diagonal larger by a share."""
        ee, aa, pp = self.ee.copy(), self.aa.copy(), self.pp.copy()
        np.einsum("ii->i", aa)[:] *= 1.0 + share
        for blocks in (ee, pp):
            np.einsum("nii->ni", blocks)[:] *= 1.0 + share
        return replace(self, ee=ee, aa=aa, pp=pp)


@dataclass(frozen=True, eq=False)
class Compiled:
    """The compiled arithmetic for adjust.solution.iteration; it keeps what stays the same from one iteration to the
    next.
    """

    observations: Observations

    @cached_property
    def first(self) -> Indices:
        """(m) the first column of each image's AP set, counted from the first parameter."""
        u = self.observations.image_points.unknowns
        starts = np.array([s.columns.start for s in u.sets], dtype=np.intp) - 6 * len(u.block.images)
        return np.asarray(starts[u.image_set])

    @cached_property
    def linear_aa(self) -> Floats:
        """(A, A) of the constant terms: they stand at the measured coordinates, so their normal equations never
        change.
        """
        return self.aa(self.observations.image_points.basis)

    def aa(self, terms: Floats) -> Floats:
        """(A, A) of the AP terms (k, 2, a)."""
        g = self.observations.image_points
        u = g.unknowns
        images = 6 * len(u.block.images)
        aa = np.zeros((u.orientation - images, u.orientation - images))
        for number, s in enumerate(u.sets):
            rows = u.image_set[g.image] == number
            basis = terms[rows, :, : len(s.model.parameters)].reshape(2 * int(rows.sum()), -1)
            at = slice(s.columns.start - images, s.columns.stop - images)
            aa[at, at] = (basis * g.weight[rows].reshape(-1, 1)).T @ basis
        return aa

    @cached_property
    def renamed(self) -> npt.NDArray[np.bool_]:
        """(m) the images with renamed axes."""
        u = self.observations.image_points.unknowns
        return np.zeros(len(u.block.images), dtype=bool) if u.renamed is None else u.renamed

    @cached_property
    def free(self) -> Floats:
        """(n, 3): 1 for free coordinates, 0 for fixed and for coupled ones."""
        return (~self.observations.image_points.unknowns.held).astype(float)

    @cached_property
    def widths(self) -> tuple[int, int, int, int]:
        """m, k, n, A."""
        g = self.observations.image_points
        m = len(g.unknowns.block.images)
        return m, len(g.image), len(g.unknowns.block.points), g.unknowns.orientation - 6 * m

    def at(self, x: Floats) -> CompiledNormals:
        """The normal equations of all groups at x."""
        g = self.observations.image_points
        m, k, n, a = self.widths
        v, by_exterior, by_point, terms, depth = self._linearised(x)
        ee, ea, pe, pa = np.zeros((m, 6, 6)), np.zeros((m, 6, a)), np.empty((k, 3, 6)), np.zeros((n, 3, a))
        pp, gradient_e, gradient_p = np.zeros((n, 3, 3)), np.zeros(6 * m + a), np.zeros((n, 3))
        vpv = loops.accumulate(
            g.starts, g.point, g.weight, self.free, self.first, v, by_exterior, by_point, terms,
            ee, ea, pe, pa, pp, gradient_e[: 6 * m].reshape(m, 6), gradient_e[6 * m :], gradient_p,
        )  # fmt: skip
        vpv += self._add_control(x, pp, gradient_p)
        aa = self.linear_aa if terms is g.basis else self.aa(terms)
        if self.observations.further:
            aa = aa.copy()
            vpv += self._add_further(x, gradient_e)
            further.add_blocks(self.observations.beside_elimination(x)[0], ee, ea, aa)
        return CompiledNormals(gradient_e, gradient_p, vpv, depth, ee, ea, aa, pe, pa, pp)

    def gradient(self, x: Floats) -> Gradient:
        """The gradients, vPv and the least depth at x."""
        g = self.observations.image_points
        m, _, n, a = self.widths
        v, by_exterior, by_point, terms, depth = self._linearised(x)
        gradient_e, gradient_p = np.zeros(6 * m + a), np.zeros((n, 3))
        vpv = loops.gradient(
            g.starts, g.point, g.weight, self.free, self.first, v, by_exterior, by_point, terms,
            gradient_e[: 6 * m].reshape(m, 6), gradient_e[6 * m :], gradient_p,
        )  # fmt: skip
        vpv += self._add_control(x, None, gradient_p)
        vpv += self._add_further(x, gradient_e)
        return Gradient(gradient_e, gradient_p, vpv, depth)

    def _linearised(self, x: Floats) -> tuple[Floats, Floats, Floats, Floats, float]:
        g = self.observations.image_points
        u = g.unknowns
        exterior = np.ascontiguousarray(u.exterior(x))
        at = g.distortion(x)
        v = at.d.copy() if g.not_linear else at.d
        by_exterior, by_point = np.empty((len(v), 2, 6)), np.empty((len(v), 2, 3))
        rotation = rotation_matrices(exterior[:, 3:], u.renamed)
        points = np.ascontiguousarray(u.points(x))
        depth = loops.linearise(
            exterior, rotation, self.renamed, at.interior, points, g.starts, g.point, g.xy, v, by_exterior, by_point
        )
        if g.not_linear:
            g.add_principal_distance(at, v - at.d + g.xy)
        return v, by_exterior, by_point, at.terms, depth

    def _add_further(self, x: Floats, gradient_e: Floats) -> float:
        forms, vpv = self.observations.beside_elimination(x, gradient_only=True)
        further.add_gradient(forms, gradient_e)
        return vpv

    def _add_control(self, x: Floats, pp: Floats | None, gradient_p: Floats) -> float:
        """The weighted and the fixed control; returns the vPv of the former."""
        u = self.observations.image_points.unknowns
        control = self.observations.control
        v, alone = control.residuals(x), control.columns >= u.orientation
        at_point, axis = np.divmod(control.columns[alone] - u.orientation, 3)
        gradient_p[at_point, axis] += (control.weight * v)[alone]
        if pp is not None:
            pp[at_point, axis, axis] += control.weight[alone]
            fixed_point, fixed_axis = np.nonzero(u.held)
            pp[fixed_point, fixed_axis, fixed_axis] = 1.0
        return float(np.sum(control.weight * v**2))

    def factorise(
        self, normals: CompiledNormals, condition_least: float = CONDITION_LEAST
    ) -> FactorisedNormals | BandFactor:
        """Eliminate the points and factorise. Raises SingularError."""
        g = self.observations.image_points
        size = g.unknowns.orientation
        root = np.empty_like(normals.pp)
        bad = loops.cholesky_blocks(normals.pp, DETERMINANT_LEAST, root)
        if bad >= 0:
            block = normals.pp[bad]
            scale = 1.0 / np.sqrt(np.where(np.diag(block) > 0.0, np.diag(block), 1.0))
            raise SingularError(block * scale * scale[:, None], scale, slice(size + 3 * bad, size + 3 * bad + 3))
        white = np.empty_like(normals.pe)
        loops.whiten(g.point, root, normals.pe, white)
        white_a = root @ normals.pa
        if not self.banded:
            return self._dense(normals, root, white, white_a, condition_least)
        try:
            return banded(normals, self.ordering, g, root, white, white_a, condition_least)
        except SingularBandError:
            if size > EXPLAINED_MOST:
                raise SingularError(np.empty((0, 0)), np.empty(0), slice(0, size)) from None
            return self._dense(normals, root, white, white_a, condition_least)  # whose error can say why

    @cached_property
    def banded(self) -> bool:
        """Whether a band is less work than a dense matrix; an order is only looked for where that could matter."""
        m, _, n, _ = self.widths
        dense = (1.5 * n * (6.0 * m) ** 2 + (6.0 * m) ** 3 / 6) / BLAS_RATE
        return dense > DENSE_ANYWAY and self.ordering.work < dense

    @cached_property
    def ordering(self) -> Ordering:
        return Ordering.of(self.observations)

    def _dense(
        self, normals: CompiledNormals, root: Floats, white: Floats, white_a: Floats, condition_least: float
    ) -> FactorisedNormals:
        g = self.observations.image_points
        m, _, n, _ = self.widths
        size = g.unknowns.orientation
        dense = np.zeros((3 * n, size))
        loops.scatter(g.starts, g.point, white, dense)
        dense[:, 6 * m :] = white_a.reshape(3 * n, -1)
        # only the lower triangle of the Fortran-ordered matrix is used
        reduced = scipy.linalg.blas.dsyrk(-1.0, dense.T, lower=1)
        diagonal = np.empty(size)
        down, right = reduced.strides
        image_blocks = np.lib.stride_tricks.as_strided(reduced, (m, 6, 6), (6 * (down + right), down, right))
        image_blocks += normals.ee
        reduced[6 * m :, : 6 * m] += normals.ea.reshape(6 * m, -1).T
        reduced[6 * m :, 6 * m :] += normals.aa
        diagonal[: 6 * m] = np.einsum("mii->mi", normals.ee).ravel()
        diagonal[6 * m :] = np.diag(normals.aa)
        scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        reduced *= scale
        reduced *= scale[:, None]
        lower, info = scipy.linalg.lapack.dpotrf(reduced, lower=1, clean=1)
        condition = reciprocal_condition(lower, reduced) if info == 0 else 0.0
        if condition < condition_least:
            full = np.tril(reduced) + np.tril(reduced, -1).T
            raise SingularError(full, scale, slice(0, size))
        return FactorisedNormals(scale, lower, root, dense.reshape(n, 3, size), condition)
