"""Observation groups: each gives residuals, Jacobian and weights at given unknowns, and nothing else.

Residuals are corrections, v = f(x) - measured, and weights are 1/sigma^2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from adjust.model import Unknowns
from adjust.observations.control import ControlCoordinates
from adjust.observations.group import Bound, Group, Linear, vpv
from adjust.observations.image_points import ImagePoints
from simfield.block import Block, Floats


@dataclass(frozen=True, eq=False)
class Observations:
    """All observation groups of an adjustment."""

    image_points: ImagePoints
    control: ControlCoordinates
    further: tuple[Bound, ...] = ()
    stated: tuple[Group, ...] = ()
    """the further groups as they were stated, to adjust with other unknowns"""
    taken_out: int = 0
    """how many observations' worth of weight robust estimation took away, beside those of weight 0"""

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
        return int(np.count_nonzero(self.weights)) - self.taken_out

    @property
    def weights(self) -> Floats:
        """(rows) the weights: image coordinates in the order of the block (x, y, x, y, ...), then control, then
        further groups.
        """
        image_points = np.empty_like(self.image_points.weight)
        image_points[self.image_points.order] = self.image_points.weight
        return np.concatenate([image_points.ravel(), self.control.weight, *(group.weight for group in self.further)])

    def with_weights(self, weights: Floats, taken_out: int = 0) -> Observations:
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
            taken_out,
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
    def magnitude(self) -> tuple[float, float]:
        """The norm of the observations in units of their standard deviations, of the image coordinates and of all: what
        rounding errors are relative to.
        """
        points, control = self.image_points, self.control
        images, squares = np.sum(points.weight * points.xy**2), np.sum(control.weight * control.given**2)
        squares = images + squares + sum(np.sum(g.weight * g.given**2) for g in self.further)
        return float(np.sqrt(images + 1.0)), float(np.sqrt(squares + 1.0))
