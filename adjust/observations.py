"""Observation groups: each gives residuals, Jacobian and weights at given unknowns, and nothing else.

Residuals are corrections, v = f(x) - measured, and weights are 1/sigma^2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from adjust.collinearity import linearise, project
from adjust.further import Bound, Group, Linear, vpv
from adjust.unknowns import ApSet, Unknowns
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
        by_point = linearise(u.exterior(x), interior, points[self.point[rows]], self.image[rows]).by_point
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
        projected, depth = project(u.exterior(x), at.interior, u.points(x)[self.point], self.image)
        return projected + at.d - self.xy, depth

    def jacobian(self, x: Floats) -> ImagePointJacobian:
        u, distorted = self.unknowns, self.distortion(x)
        at = linearise(u.exterior(x), distorted.interior, u.points(x)[self.point], self.image)
        self.add_principal_distance(distorted, at.xy)
        return ImagePointJacobian(
            at.xy + distorted.d - self.xy,
            np.concatenate([at.by_exterior, distorted.terms], axis=2),
            at.by_point * self.free,
            at.depth,
        )


@dataclass(frozen=True, eq=False)
class ControlCoordinates:
    """Weighted control: coordinates that are observations of themselves. columns (q) in x, given and weight (q).

    coordinates (q) counts all coordinates of all points, three a point.
    """

    coordinates: Indices
    columns: Indices
    given: Floats
    weight: Floats

    @classmethod
    def of(cls, block: Block, unknowns: Unknowns) -> ControlCoordinates:
        at = np.flatnonzero(block.points.weighted.ravel())
        given = (block.points.coordinates - unknowns.origin).ravel()[at]
        return cls(at, unknowns.places[at], given, 1.0 / block.points.sigma.ravel()[at] ** 2)

    def residuals(self, x: Floats) -> Floats:
        """v (q), m."""
        return x[self.columns] - self.given


@dataclass(frozen=True, eq=False)
class Observations:
    """All observation groups of an adjustment."""

    image_points: ImagePoints
    control: ControlCoordinates
    further: tuple[Bound, ...] = ()
    stated: tuple[Group, ...] = ()
    """the further groups as they were stated, to adjust with other unknowns"""

    @classmethod
    def of(cls, block: Block, unknowns: Unknowns, groups: Sequence[Group] = ()) -> Observations:
        bound = tuple(group.bind(unknowns) for group in groups)
        return cls(ImagePoints.of(block, unknowns), ControlCoordinates.of(block, unknowns), bound, tuple(groups))

    @property
    def rows(self) -> int:
        """The number of observations, those of weight 0 included."""
        more = sum(len(group.weight) for group in self.further)
        return 2 * len(self.image_points.image) + len(self.control.columns) + more

    @property
    def count(self) -> int:
        """The number of observations that count: an observation of weight 0 is rejected."""
        return int(np.count_nonzero(self.weights))

    @property
    def weights(self) -> Floats:
        """(rows) the weights: image coordinates in the order of the block (x, y, x, y, ...), then control, then
        further groups.
        """
        image_points = np.empty_like(self.image_points.weight)
        image_points[self.image_points.order] = self.image_points.weight
        return np.concatenate([image_points.ravel(), self.control.weight, *(group.weight for group in self.further)])

    def with_weights(self, weights: Floats) -> Observations:
        """The same observations with other weights, in the order of `weights`; 0 rejects an observation."""
        k2 = 2 * len(self.image_points.image)
        image_points = weights[:k2].reshape(-1, 2)[self.image_points.order]
        bounds = np.cumsum([k2, len(self.control.weight), *(len(group.weight) for group in self.further)])
        control, *others = (weights[start:stop] for start, stop in pairwise(bounds))
        return Observations(
            replace(self.image_points, weight=image_points),
            replace(self.control, weight=control),
            tuple(group.with_weight(weight) for group, weight in zip(self.further, others, strict=True)),
            self.stated,
        )

    def beside_elimination(self, x: Floats, gradient_only: bool = False) -> tuple[list[tuple[Floats, Linear]], float]:
        """What must be added to the normal equations of the orientation unknowns, as weights and linear forms, and the
        vPv of the further groups.

        The points are eliminated one by one, each with its own rays alone. Two kinds of observations do not fit into
        that and are added here: the further groups, and whatever belongs to coupled points. A point is coupled when a
        group ties it to another one, as a distance does; its coordinates then stay, among the orientation unknowns.
        """
        forms = [(group.weight, group.at(x)) for group in self.further]
        total = float(sum(np.sum(weight * form.v**2) for weight, form in forms))
        if len(self.image_points.unknowns.coupled):
            forms.append(self._control_of_coupled(x))
            forms += self._rays_of_coupled(x, gradient_only)
        return forms, total

    def _control_of_coupled(self, x: Floats) -> tuple[Floats, Linear]:
        """The observed coordinates of coupled points: v = x - given, with a derivative of 1."""
        control = self.control
        tied = control.columns < self.image_points.unknowns.orientation
        v, columns = control.residuals(x)[tied], control.columns[tied][:, None]
        return control.weight[tied], Linear(v, columns, np.ones_like(v)[:, None])

    def _rays_of_coupled(self, x: Floats, gradient_only: bool) -> list[tuple[Floats, Linear]]:
        """What the image coordinates of coupled points add to what the loop over all rays has summed already.

        That loop holds coupled coordinates fixed: of a row (a, b) of the Jacobian, a by orientation and b by the
        coordinates, it has summed a^T p v and a^T p a. To the gradient only b^T p v is to be added. To the normal
        equations belongs (a, b)^T p (a, b) instead of (a, 0)^T p (a, 0): the first is added, the second taken away.
        """
        rows, form = self.image_points.coupled(x)
        weight = self.image_points.weight[rows].ravel()
        if gradient_only:
            return [(weight, Linear(form.v, form.columns[:, -3:], form.values[:, -3:]))]
        by_orientation = form.values.copy()
        by_orientation[:, -3:] = 0.0
        return [(weight, form), (-weight, Linear(form.v, form.columns, by_orientation))]

    def cost(self, x: Floats) -> float:
        """vPv; infinite when a point lies behind a camera."""
        v, depth = self.image_points.residuals(x)
        if not (depth > 0.0).all():
            return float("inf")
        control = self.control.residuals(x)
        squares = np.sum(self.image_points.weight * v**2) + np.sum(self.control.weight * control**2)
        return float(squares) + vpv(self.further, x)

    @property
    def magnitude(self) -> float:
        """The norm of the observations in units of their standard deviations: what rounding errors are relative to."""
        points, control = self.image_points, self.control
        squares = np.sum(points.weight * points.xy**2) + np.sum(control.weight * control.given**2)
        return float(np.sqrt(squares + sum(np.sum(g.weight * g.given**2) for g in self.further) + 1.0))


def _basis(unknowns: Unknowns, image: Indices, xy: Floats) -> Floats:
    widest = max(len(s.model.parameters) for s in unknowns.sets)
    basis = np.zeros((len(image), 2, widest))
    set_of = unknowns.image_set[image]
    for number, s in enumerate(unknowns.sets):
        rows = set_of == number
        basis[rows, :, : len(s.model.parameters)] = s.model.basis(xy[rows, 0], xy[rows, 1])
    return basis
