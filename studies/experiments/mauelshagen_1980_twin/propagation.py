"""First-order propagation of errors through the 18 adjustments: what each published square expects of each component.

With A the design matrix of an adjustment, all weights equal and G = (A^T A)^-1 A^T, an error e of the image
coordinates moves the unknowns by G e and leaves the residuals A G e - e. Expected squares of m0 and mu are therefore
linear in the variances of independent components. An error d of the given coordinates acts on the images of control
points as e = -B d and is subtracted from the deviations of the check points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import linalg

from adjust import Adjustment
from adjust.model import linearise
from simfield import World
from simfield.block import Floats, Indices
from studies.experiments.mauelshagen_1980 import Row, adjusted, places, sub_block
from studies.experiments.mauelshagen_1980_twin.components import Component, film_fields

FIGURES = ("m0_um", "mu_xy_mm", "mu_z_mm")
"""m0 in um; the 2-D rms in plan and the rms in height of the check points, mm"""


@dataclass(frozen=True, eq=False)
class Propagated:
    """Errors carried through one adjustment: residuals v (2k, t) um, deviations of check points (c, 3, t) mm."""

    redundancy: int
    v: Floats
    deviations: Floats

    @property
    def squares(self) -> Floats:
        """(3, t): the squares of FIGURES."""
        plan, height = self.deviations[:, :2], self.deviations[:, 2]
        count = len(self.deviations)
        return np.stack(
            [(self.v**2).sum(axis=0) / self.redundancy, (plan**2).sum(axis=(0, 1)) / count, (height**2).mean(axis=0)]
        )


@dataclass(frozen=True, eq=False)
class LinearRow:
    """One linearised adjustment. design (2k, u) and gain G (u, 2k) of the free unknowns, image coordinates in the
    order of the world, mm and m; by_fixed (2k, f) the derivatives by the coordinates held fixed; check (3c) the places
    of check coordinates among the free unknowns; rows (2k), given and fixed: where image coordinates, check and fixed
    coordinates stand in the world.
    """

    world: World
    rows: Indices
    redundancy: int
    design: Floats
    gain: Floats
    by_fixed: Floats
    check: Indices
    given: Indices
    fixed: Indices

    @classmethod
    def of(cls, world: World, row: Row) -> LinearRow:
        whole, truth = world.observe(0)
        block = sub_block(whole, truth, row.block, row.aux_points)
        a = adjusted(block, row.model)
        observations, points = places(block, whole)
        design, by_fixed = _design(a)
        fixed = block.points.fixed.ravel()
        coordinate = (3 * points[:, None] + np.arange(3)).ravel()
        is_check = np.repeat(block.points.role == "check", 3)[~fixed]
        first = int(a.layout.free[: a.layout.orientation].sum())
        normal = linalg.cho_factor(_scaled(design)[0].T @ _scaled(design)[0])
        scaled, scale = _scaled(design)
        gain = linalg.cho_solve(normal, scaled.T) * scale[:, None]
        return cls(
            world,
            (2 * observations[:, None] + np.arange(2)).ravel(),
            a.redundancy,
            design,
            gain,
            by_fixed,
            first + np.flatnonzero(is_check),
            coordinate[~fixed][is_check],
            coordinate[fixed],
        )

    def carry(self, image_errors: Floats, survey_errors: Floats | None = None) -> Propagated:
        """Carry image errors (2K, t) mm of the whole world and errors (3N, t) m of its given coordinates through."""
        e = image_errors[self.rows]
        if survey_errors is not None:
            e = e - self.by_fixed @ survey_errors[self.fixed]
        moved = self.gain @ e
        deviations = moved[self.check]
        if survey_errors is not None:
            deviations = deviations - survey_errors[self.given]
        return Propagated(
            self.redundancy, 1000.0 * (self.design @ moved - e), 1000.0 * deviations.reshape(-1, 3, e.shape[1])
        )

    @cached_property
    def noise(self) -> Floats:
        """(3, 2k): what 1 um of noise in every single image coordinate adds to the squares."""
        residual = 1.0 - np.einsum("ku,uk->k", self.design, self.gain)
        squared = (self.gain[self.check] ** 2).reshape(-1, 3, self.gain.shape[1])
        count = len(squared)
        return np.stack(
            [residual / self.redundancy, squared[:, :2].sum(axis=(0, 1)) / count, squared[:, 2].sum(axis=0) / count]
        )

    def expected(self, component: Component) -> Floats:
        """(3): the squares of FIGURES that a component of size 1 makes, um^2 and mm^2."""
        world = self.world
        if component.kind == "noise":
            own = np.array(world.plan.camera_ids)[np.repeat(world.image, 2)[self.rows]] == component.camera
            return np.asarray(self.noise[:, own].sum(axis=1))
        if component.kind == "film":
            return np.asarray(self.carry(film_fields(world, component)).squares.sum(axis=1))
        units = 1e-3 * np.eye(3 * len(world.place))
        used = np.concatenate([self.given, self.fixed])
        nothing = np.zeros((2 * len(world.image), len(used)))
        return np.asarray(self.carry(nothing, units[:, used]).squares.sum(axis=1))


def expected_squares(rows: Sequence[LinearRow], components: Sequence[Component]) -> Floats:
    """(3 rows, components): the expected square of every published figure per unit variance of every component."""
    return (
        np.array([[row.expected(c) for c in components] for row in rows])
        .transpose(0, 2, 1)
        .reshape(-1, len(components))
    )


def _design(a: Adjustment) -> tuple[Floats, Floats]:
    """The design matrix of the free unknowns and that of the coordinates held fixed, rows in the order of the block."""
    g, layout = a.groups.image_points, a.layout
    k = len(g.image)
    full = np.zeros((k, 2, len(a.x)))
    at = linearise(layout.exterior(a.x), g.interior, layout.points(a.x)[g.point], g.image, layout.renamed)
    sorted_rows = g.order
    for column in range(6):
        full[sorted_rows, :, 6 * g.image + column] = at.by_exterior[:, :, column]
    for column in range(3):
        full[sorted_rows, :, layout.orientation + 3 * g.point + column] = at.by_point[:, :, column]
    for number, s in enumerate(layout.sets):
        own = np.flatnonzero(layout.image_set[g.image] == number)
        full[sorted_rows[own], :, s.columns] = g.basis[own][:, :, : len(s.model.parameters)]
    flat = full.reshape(2 * k, -1)
    return flat[:, layout.free], flat[:, ~layout.free]


def _scaled(design: Floats) -> tuple[Floats, Floats]:
    """The design matrix with columns of unit length, and the factors (u)."""
    scale = 1.0 / np.sqrt((design**2).sum(axis=0))
    return design * scale, scale
