"""The answer of the engine: estimates with their quality; the words are those of docs/conventions.md."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from adjust.model import EXTERIOR_NAMES, POINT_NAMES, Flags, Unknowns, angles_by_angles
from adjust.normals import Arithmetic, Cofactors, SingularError, ToldCofactors
from adjust.observations import Observations
from adjust.status import Status
from simfield.block import Block, Floats
from simfield.numerics import one_thread

Name = tuple[str, str]
"""An unknown: its owner (image, camera or point id) and its name, such as ("ww", "a3") or ("sww-1", "Z0")."""


@dataclass(frozen=True, eq=False)
class Estimates:
    """Estimates of one kind: ids (n) of the rows, names (c) of the columns, values (n, c) and standard deviations.

    Metres, and radians for angles. std (n, c) is a posteriori (times sigma0); NaN where the adjustment failed, 0 where
    a value is held fixed.
    """

    ids: tuple[str, ...]
    names: tuple[str, ...]
    values: Floats
    std: Floats


@dataclass(frozen=True, eq=False)
class ApEstimate:
    """The additional parameters of one camera: names (a), values (a) and their standard deviations std (a).

    Each is in the unit that its term asks for, so that value times term is in mm.
    """

    names: tuple[str, ...]
    values: Floats
    std: Floats

    def __getitem__(self, name: str) -> float:
        """The value of one parameter. Raises ValueError for a name that the model does not have."""
        return float(self.values[self.names.index(name)])


@dataclass(frozen=True, eq=False)
class Adjustment:
    """The result of `adjust_block`. Everything derived is computed when it is asked for.

    x (size) is the estimate in the layout of `layout`: orientations (X0, Y0, Z0 in metres, reduced to
    `layout.origin`; omega, phi, kappa in radians, by renamed axes where `layout.renamed` says so), additional
    parameters, what further groups add, points (metres, reduced). status says how the adjustment ended and `message`
    says it in one line; iterations counts the steps.
    """

    block: Block
    layout: Unknowns
    groups: Observations
    x: Floats
    status: Status
    message: str
    iterations: int
    arithmetic: Arithmetic

    @property
    def unknowns(self) -> int:
        """The number of unknowns."""
        return self.layout.count

    @property
    def observations(self) -> int:
        """The number of observations: two a measured image point, one a weighted control coordinate."""
        return self.groups.count

    @property
    def redundancy(self) -> int:
        """Observations minus unknowns."""
        return self.observations - self.unknowns

    @property
    def regular(self) -> Adjustment:
        """The adjustment with regular normal equations and the same residuals: this one, unless the datum is free."""
        return self

    def tied(self, regular: Adjustment) -> Adjustment:
        """Another adjustment of the same block, with regular normal equations, tied to the frame as this one is."""
        return regular

    @cached_property
    def residuals(self) -> Floats:
        """v (k, 2) of the image coordinates, mm, in the order of the block."""
        v, _ = self.groups.image_points.residuals(self.x)
        ordered = np.empty_like(v)
        ordered[self.groups.image_points.order] = v
        return ordered

    @property
    def vpv(self) -> float:
        """The weighted sum of squares of all residuals, free of unit."""
        return self.groups.cost(self.x)

    @cached_property
    def sigma0(self) -> float:
        """sqrt(vPv / redundancy), free of unit; NaN where the adjustment failed."""
        return float(np.sqrt(self.vpv / self.redundancy)) if self.status.ok else float("nan")

    @property
    def unit_weight_um(self) -> float:
        """The standard deviation of unit weight: that of the best measured image coordinate, um."""
        return 1000.0 * float(self.block.observations.sigma.min())

    @property
    def m0_um(self) -> float:
        """sigma0 times the standard deviation of unit weight, um in the image."""
        return self.sigma0 * self.unit_weight_um

    @cached_property
    def cofactors(self) -> Cofactors:
        """The cofactors at the estimate, of the angles as people see them. Raises ValueError where it failed."""
        found, renamed = self.working_cofactors, self.layout.renamed
        return found if renamed is None else self._told_cofactors(found, renamed)

    def _told_cofactors(self, found: Cofactors, renamed: Flags) -> Cofactors:
        turns = angles_by_angles(self.layout.exterior(self.x)[:, 3:], renamed)
        return ToldCofactors(self.layout, found.factor, found, np.flatnonzero(renamed), turns[renamed])

    @cached_property
    def working_cofactors(self) -> Cofactors:
        """The cofactors of x itself. Raises ValueError where the adjustment failed."""
        if not self.status.ok:
            raise ValueError(f"no cofactors: {self.message}")
        try:
            with one_thread():
                return Cofactors(self.layout, self.arithmetic.factorise(self.arithmetic.at(self.x)))
        except SingularError as error:
            raise ValueError("no cofactors: the normal equations are singular at the estimate") from error

    @cached_property
    def std(self) -> Floats:
        """(size) the standard deviation of every unknown, in the layout and the units of x, of angles as people see
        them; NaN where the adjustment failed, 0 where a value is held fixed. Raises ValueError if the normal
        equations are singular at the estimate.
        """
        if not self.status.ok:
            return np.full(len(self.x), np.nan)
        with one_thread():
            return np.asarray(self.sigma0 * np.sqrt(self.cofactors.diagonal))

    @cached_property
    def exterior(self) -> Floats:
        """Exterior orientations (m, 6): X0, Y0, Z0 in m, omega, phi, kappa in rad; without standard deviations."""
        values = self.layout.exterior(self.layout.told(self.x)).copy()
        values[:, :3] += self.layout.origin
        return values

    @cached_property
    def coordinates(self) -> Floats:
        """Adjusted coordinates (n, 3), m; without standard deviations."""
        values = self.layout.points(self.x) + self.layout.origin
        fixed = self.block.points.fixed
        values[fixed] = self.block.points.coordinates[fixed]
        return values

    @cached_property
    def images(self) -> Estimates:
        """Exterior orientations (m, 6) with standard deviations, units as in `exterior`."""
        return Estimates(self.block.images.ids, EXTERIOR_NAMES, self.exterior, self.layout.exterior(self.std))

    @cached_property
    def points(self) -> Estimates:
        """Adjusted coordinates (n, 3) with standard deviations, m."""
        return Estimates(self.block.points.ids, POINT_NAMES, self.coordinates, self.layout.points(self.std))

    @cached_property
    def ap(self) -> dict[str, ApEstimate]:
        """The additional parameters by the id of their set: the camera id, unless `ap_by` said otherwise."""
        return {s.id: ApEstimate(s.model.parameters, self.x[s.columns], self.std[s.columns]) for s in self.layout.sets}

    def covariance(self, *names: Name) -> Floats:
        """The covariance matrix (q, q) of q named unknowns, each (owner, name), in the units of x.

        Raises KeyError for an unknown name and ValueError where the adjustment failed.
        """
        at = np.array([self.layout.index(*name) for name in names], dtype=np.intp)
        return np.asarray(self.sigma0**2 * self.cofactors.block(at, at))

    def correlation(self, *names: Name) -> Floats:
        """The correlation matrix (q, q) of q named unknowns, free of unit; NaN rows for those held fixed.

        Raises KeyError for an unknown name and ValueError where the adjustment failed.
        """
        at = np.array([self.layout.index(*name) for name in names], dtype=np.intp)
        return correlations(self.cofactors.block(at, at))

    def ap_correlation(self, camera_id: str) -> Floats:
        """The correlation matrix (a, a) of all additional parameters of one camera, free of unit.

        Raises KeyError for an id that has none and ValueError where the adjustment failed.
        """
        names: Sequence[str] = self.ap[camera_id].names
        return self.correlation(*((camera_id, name) for name in names))


def correlations(covariance: Floats) -> Floats:
    """The correlations (n, n), free of unit, of a covariance matrix (n, n); NaN where there is no variance."""
    std = np.sqrt(np.diag(covariance))
    std = np.where(std > 0.0, std, np.nan)
    return np.asarray(covariance / std / std[:, None])
