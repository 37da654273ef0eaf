"""Image coordinates as observations: measured + v = projected + d(measured)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from adjust.model import ApSet, Unknowns, linearise, project
from adjust.observations.group import Linear
from simfield.block import Block, Floats, Indices


@dataclass(frozen=True, eq=False)
class ImagePointJacobian:
    """Corrections v (k, 2) of the image points with their derivatives.

    by_orientation (k, 2, 6 + a): exterior orientation of the image, then the additional parameters of its set (padded
    with zeros to the largest set); by_point (k, 2, 3) with zero columns for coordinates held fixed.
    """

    v: Floats
    by_orientation: Floats
    by_point: Floats
    depth: Floats
    """(k) the depths of the points before their cameras, m"""


@dataclass(frozen=True, eq=False)
class Distortion:
    """d(measured) (k, 2), mm, with its derivatives by the additional parameters, terms (k, 2, a).

    interior (m, 3): c, x0, y0 of every image, mm, c with what the parameters add to it. The terms are the constant
    basis itself where all sets are linear, a copy otherwise.
    """

    d: Floats
    terms: Floats
    interior: Floats


@dataclass(frozen=True, eq=False)
class ImagePoints:
    """The image coordinates of a block: measured + v = projected + d(measured), sorted by image.

    order (k) is the place of each sorted observation in the block; starts (m + 1) bound the rows of each image.
    """

    unknowns: Unknowns
    order: Indices
    starts: Indices
    image: Indices
    point: Indices
    xy: Floats
    weight: Floats
    interior: Floats
    """(m, 3) c, x0, y0 of every image, mm"""
    basis: Floats
    """(k, 2, a) AP terms at the measured coordinates, zero-padded to the largest set; where a set is not linear, those
    at parameters of 0"""

    @classmethod
    def of(cls, block: Block, unknowns: Unknowns) -> ImagePoints:
        o = block.observations
        order = np.argsort(o.image, kind="stable")
        image = o.image[order]
        interior = np.array([(c.c_mm, c.x0_mm, c.y0_mm) for c in block.cameras])[block.images.camera]
        xy = o.xy[order]
        return cls(
            unknowns,
            order,
            np.searchsorted(image, np.arange(len(block.images) + 1)),
            image,
            o.point[order],
            xy,
            1.0 / o.sigma[order] ** 2,
            interior,
            _basis(unknowns, image, xy),
        )

    @cached_property
    def free(self) -> Floats:
        """(k, 1, 3): 1 for free coordinates of the observed point, 0 for fixed and for coupled ones."""
        return (~self.unknowns.held).astype(float)[self.point][:, None, :]

    def ap_values(self, x: Floats) -> Floats:
        """(m, a) the additional parameters that apply to each image, zero-padded."""
        padded = np.zeros((len(self.unknowns.sets), self.basis.shape[2]))
        for row, s in zip(padded, self.unknowns.sets, strict=True):
            row[: len(s.model.parameters)] = x[s.columns]
        return np.asarray(padded[self.unknowns.image_set])

    @cached_property
    def not_linear(self) -> tuple[tuple[ApSet, Indices, Indices], ...]:
        """The sets that are not linear, with the rows (k') and the images (m') that have them."""
        u = self.unknowns
        return tuple(
            (s, np.flatnonzero(u.image_set[self.image] == number), np.flatnonzero(u.image_set == number))
            for number, s in enumerate(u.sets)
            if not s.model.linear
        )

    def distortion(self, x: Floats) -> Distortion:
        """d and its derivatives at x, and the interior orientation to project with."""
        with np.errstate(invalid="ignore"):  # a term with a pole; the status names it
            d = np.einsum("kij,kj->ki", self.basis, self.ap_values(x)[self.image])
        if not self.not_linear:
            return Distortion(d, self.basis, self.interior)
        terms, interior = self.basis.copy(), self.interior.copy()
        for s, rows, images in self.not_linear:
            values = x[s.columns]
            reduced = self.xy[rows] - self.interior[self.image[rows], 1:]
            d[rows], terms[rows, :, : len(values)] = s.model.evaluate(reduced[:, 0], reduced[:, 1], values)
            if s.model.principal_distance:
                interior[images, 0] += values[s.model.parameters.index(s.model.principal_distance)]
        return Distortion(d, terms, interior)

    def add_principal_distance(self, at: Distortion, projected: Floats) -> None:
        """Put the derivative of projected (k, 2) by the principal distance, -p_x/p_z, into the terms that stand for
        it.
        """
        for s, rows, _ in self.not_linear:
            if s.model.principal_distance:
                interior = at.interior[self.image[rows]]
                column = s.model.parameters.index(s.model.principal_distance)
                at.terms[rows, :, column] = (projected[rows] - interior[:, 1:]) / interior[:, :1]

    def squared_effects(self, x: Floats) -> Floats:
        """(A) the diagonal of the normal equations of all additional parameters, set after set."""
        u, first = self.unknowns, 6 * len(self.unknowns.block.images)
        squared = self.weight[:, :, None] * self.jacobian(x).by_orientation[:, :, 6:] ** 2
        effects = np.zeros(u.orientation - first)
        for number, s in enumerate(u.sets):
            rows = u.image_set[self.image] == number
            effects[s.columns.start - first : s.columns.stop - first] = squared[rows].sum(axis=(0, 1))[
                : len(s.model.parameters)
            ]
        return effects

    def coupled(self, x: Floats) -> tuple[Indices, Linear]:
        """The rows (k') that see coupled coordinates, and their image coordinates (2k') as functions of all orientation
        unknowns: exterior orientation, additional parameters, coupled coordinates. The last three columns are these."""
        u = self.unknowns
        rows = np.flatnonzero(np.isin(self.point, u.coupled // 3))
        at, points = self.jacobian(x), u.points(x)
        interior = self.distortion(x).interior
        by_point = linearise(u.exterior(x), interior, points[self.point[rows]], self.image[rows], u.renamed).by_point
        first = np.array([s.columns.start for s in u.sets], dtype=np.intp)[u.image_set[self.image[rows]]]
        exterior = 6 * self.image[rows][:, None] + np.arange(6)
        coordinates = 3 * self.point[rows][:, None] + np.arange(3)
        tied = np.isin(coordinates, u.coupled)
        by_orientation = at.by_orientation[rows]
        parameters = np.where(by_orientation[:, :, 6:].any(axis=1), first[:, None] + np.arange(self.basis.shape[2]), 0)
        columns = np.hstack([exterior, parameters, np.where(tied, u.places[coordinates], 0)])
        values = np.concatenate([by_orientation, by_point * tied[:, None, :]], axis=2)
        return rows, Linear(at.v[rows].ravel(), np.repeat(columns, 2, axis=0), values.reshape(2 * len(rows), -1))

    def residuals(self, x: Floats) -> tuple[Floats, Floats]:
        """v (k, 2), mm, and the depths (k), m, in the group's order."""
        u, at = self.unknowns, self.distortion(x)
        projected, depth = project(u.exterior(x), at.interior, u.points(x)[self.point], self.image, u.renamed)
        return projected + at.d - self.xy, depth

    def jacobian(self, x: Floats) -> ImagePointJacobian:
        u, distorted = self.unknowns, self.distortion(x)
        at = linearise(u.exterior(x), distorted.interior, u.points(x)[self.point], self.image, u.renamed)
        self.add_principal_distance(distorted, at.xy)
        return ImagePointJacobian(
            at.xy + distorted.d - self.xy,
            np.concatenate([at.by_exterior, distorted.terms], axis=2),
            at.by_point * self.free,
            at.depth,
        )


def _basis(unknowns: Unknowns, image: Indices, xy: Floats) -> Floats:
    widest = max(len(s.model.parameters) for s in unknowns.sets)
    basis = np.zeros((len(image), 2, widest))
    set_of = unknowns.image_set[image]
    for number, s in enumerate(unknowns.sets):
        rows = set_of == number
        basis[rows, :, : len(s.model.parameters)] = s.model.basis(xy[rows, 0], xy[rows, 1])
    return basis
