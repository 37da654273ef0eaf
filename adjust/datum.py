"""The datum: what ties a block to its object frame. Images alone leave seven similarity motions free.

ByControl: the control of the block, fixed, weighted or partial; more than seven coordinates strain the block.
MinimumControl: seven coordinates held fixed, chosen for the best geometry. InnerConstraints: no point is held; of all
solutions the one nearest to given coordinates of the datum points, in the sum of squares, with the covariance matrix
of the smallest trace over them (Meissl 1969; Baarda, S-transformations and criterion matrices, Neth. Geod. Comm. 5/1,
1973).

Where distances give the scale, six motions are left, and six coordinates are held.

A free network is solved on minimum control, moved by a similarity, and its cofactors are S-transformed:
Q_S = S Q S^T with S = I - H (H_c^T H_c)^-1 H_c^T, where H (size, 7) are the motions of all unknowns and c the datum
coordinates. Residuals, sigma0, additional parameters and reliability do not depend on the choice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from adjust.adjustment import Adjustment
from adjust.ap_models.catalogue import NoModel
from adjust.model import Similarity, Unknowns, point_motions, station_motions
from adjust.normals import Cofactors, Compiled, Plain
from adjust.observations import Distances, ImagePoints, Observations
from adjust.solution import initial
from simfield.block import Block, Floats, Indices, Points

MOTIONS = 7
COLLINEAR = 1e-6
"""height of the widest triangle over its base below which points lie on a line"""


class Datum(Protocol):
    """How a block is tied to its frame: what is done to it before the adjustment, and to the answer afterwards."""

    def prepared(self, block: Block, scaled: bool = False) -> Block:
        """scaled: distances give the scale. Raises NoStartError or ValueError where this datum cannot be had."""

    def finished(self, a: Adjustment) -> Adjustment: ...


@dataclass(frozen=True)
class ByControl:
    """The control of the block as it stands."""

    def prepared(self, block: Block, scaled: bool = False) -> Block:
        """The block as it is."""
        return block

    def finished(self, a: Adjustment) -> Adjustment:
        """The adjustment as it is."""
        return a


@dataclass(frozen=True)
class MinimumControl:
    """Seven coordinates of three points are held at their given or approximate values, all other control is released;
    six where distances give the scale.

    points: the ids to choose from; none: all that have given coordinates, or all if those are fewer than three.
    """

    points: tuple[str, ...] = ()

    def prepared(self, block: Block, scaled: bool = False) -> Block:
        """The block on seven or six fixed coordinates. Raises ValueError for less than three points, NoStartError."""
        known, rows = _approximate(block, self.points)
        sigma = np.full_like(block.points.sigma, np.nan)
        sigma.ravel()[_least_control(known[rows], rows, scaled)] = 0.0
        role = np.where((sigma == 0.0).any(axis=1), "control", block.points.role)
        coordinates = np.where(np.isin(np.arange(len(known)), rows)[:, None], known, block.points.coordinates)
        return _with_points(block, Points(block.points.ids, role, coordinates, sigma))

    def finished(self, a: Adjustment) -> Adjustment:
        """The adjustment as it is."""
        return a


@dataclass(frozen=True)
class InnerConstraints:
    """A free network: no control holds, the datum points keep their given or approximate coordinates in the mean.

    points: the ids of the datum points, three or more; none: as for MinimumControl.
    """

    points: tuple[str, ...] = ()

    def prepared(self, block: Block, scaled: bool = False) -> Block:
        """The block on minimum control, from which the free network is made. Raises as MinimumControl.prepared."""
        return MinimumControl(self.points).prepared(block, scaled)

    def finished(self, a: Adjustment) -> Adjustment:
        """The adjustment moved onto its datum points, with their covariance; as it is where it failed."""
        if not a.status.ok:
            return a
        given = a.block.points.coordinates
        rows = _chosen(a.block, self.points, np.isfinite(given).all(axis=1) & (a.block.points.role != "check"))
        return free_network(a, rows, given[rows])


def free_network(a: Adjustment, rows: Indices, targets: Floats) -> FreeAdjustment:
    """The S-transformation of an adjustment on minimum control, or of a free one: the points `rows` become the datum
    and move nearest to the targets (k, 3), m. Raises ValueError for an adjustment on more control."""
    a = a.regular
    p = a.block.points
    scaled = any(isinstance(group, Distances) for group in a.groups.stated)
    if int(p.fixed.sum()) != MOTIONS - scaled or p.weighted.any():
        raise ValueError(
            "only an adjustment on minimum control can be given another datum without changing its residuals"
        )
    layout = a.layout
    moved = Similarity.between(layout.points(a.x)[rows], targets - layout.origin, rigid=scaled)
    points = moved.points(layout.points(a.x))
    x = np.concatenate(
        [
            moved.exterior(layout.exterior(a.x), layout.renamed).ravel(),
            a.x[6 * len(a.block.images) : layout.orientation],
            points.ravel(),
        ]
    )
    x[layout.places] = points.ravel()
    coordinates = np.where(p.fixed, points + layout.origin, p.coordinates)
    minimum = _moved(a, x, Points(p.ids, p.role, coordinates, p.sigma))
    released = _with_points(minimum.block, Points(p.ids, p.role, p.coordinates, np.full_like(p.sigma, np.nan)))
    free = layout.free.copy()
    free[layout.places] = True
    whole = replace(layout, block=released, free=free)
    kept = {name: getattr(minimum, name) for name in ("groups", "x", "status", "message", "iterations", "arithmetic")}
    return FreeAdjustment(released, whole, **kept, minimum=minimum, datum_rows=rows, targets=targets)


@dataclass(frozen=True, eq=False)
class FreeAdjustment(Adjustment):
    """A free network: minimum, the same adjustment on minimum control, datum_rows (d), the rows of the datum points,
    and targets (d, 3), the coordinates that they keep in the mean.

    Coordinates and standard deviations in m and radians, as in Adjustment.
    """

    minimum: Adjustment
    datum_rows: Indices
    targets: Floats

    @property
    def redundancy(self) -> int:
        """Observations and the constraints less unknowns."""
        return self.observations - self.unknowns + self.rank_defect

    @property
    def rank_defect(self) -> int:
        """How many motions are free: 7, or 6 where distances give the scale."""
        return int(self.minimum.block.points.fixed.sum())

    @property
    def regular(self) -> Adjustment:
        """The adjustment on minimum control, whose normal equations are regular."""
        return self.minimum

    def tied(self, regular: Adjustment) -> Adjustment:
        """Moved onto the datum points of this one; as it is where it failed."""
        return free_network(regular, self.datum_rows, self.targets) if regular.status.ok else regular

    @cached_property
    def working_cofactors(self) -> Cofactors:
        """Cofactors of all unknowns, for the datum of the datum points, in the units of x (m, rad)."""
        layout = self.layout
        pivot = layout.points(self.x)[self.datum_rows].mean(axis=0)
        motions = np.zeros((len(self.x), MOTIONS))
        motions[: 6 * len(self.block.images)] = station_motions(layout.exterior(self.x), pivot, layout.renamed).reshape(
            -1, MOTIONS
        )
        motions[layout.places] = point_motions(layout.points(self.x), pivot).reshape(-1, MOTIONS)
        motions[:, 3:] /= np.ptp(layout.points(self.x)[self.datum_rows], axis=0).max()
        motions = motions[:, : self.rank_defect]  # the scale stands last
        places = layout.places[(3 * self.datum_rows[:, None] + np.arange(3)).ravel()]
        regular = self.minimum.working_cofactors
        return FreeCofactors(layout, regular.factor, regular, motions, places)


@dataclass(frozen=True, eq=False)
class FreeCofactors(Cofactors):
    """S-transformed cofactors: Q_S = Q - H K - K^T H^T + H L H^T, K = M Q_c, L = M Q_cc M^T, M = (H_c^T H_c)^-1
    H_c^T.
    """

    minimum: Cofactors
    motions: Floats
    places: Indices

    @cached_property
    def _k(self) -> Floats:
        """(7 or 6, size)."""
        fit = np.linalg.pinv(self.motions[self.places])
        return np.asarray(fit @ self.minimum.block(self.places, np.arange(len(self.motions))))

    @cached_property
    def _half(self) -> Floats:
        """(7 or 6, size): H L / 2 - K^T, transposed, so that Q_S = Q + H half + half^T H^T."""
        fit = np.linalg.pinv(self.motions[self.places])
        inner = self._k[:, self.places] @ fit.T
        return np.asarray(0.5 * inner @ self.motions.T - self._k)

    @cached_property
    def orientation(self) -> Floats:
        at = slice(0, self.unknowns.orientation)
        across = self.motions[at] @ self._half[:, at]
        return np.asarray(self.minimum.orientation + across + across.T)

    @cached_property
    def points(self) -> Floats:
        start = self.unknowns.orientation
        motions = self.motions[start:].reshape(-1, 3, self.motions.shape[1])
        across = motions @ self._half[:, start:].T.reshape(motions.shape).transpose(0, 2, 1)
        return np.asarray(self.minimum.points + across + across.transpose(0, 2, 1))

    @cached_property
    def diagonal(self) -> Floats:
        across = np.einsum("rk,kr->r", self.motions, self._half)
        return np.asarray(np.maximum(self.minimum.diagonal + 2.0 * across, 0.0))

    def block(self, rows: Indices, columns: Indices) -> Floats:
        across = self.motions[rows] @ self._half[:, columns]
        back = self.motions[columns] @ self._half[:, rows]
        return np.asarray(self.minimum.block(rows, columns) + across + back.T)


def _moved(a: Adjustment, x: Floats, points: Points) -> Adjustment:
    block = _with_points(a.block, points)
    layout = replace(a.layout, block=block)
    groups = Observations.of(block, layout, a.groups.stated).with_weights(a.groups.weights, a.groups.taken_out)
    arithmetic = Compiled(groups) if isinstance(a.arithmetic, Compiled) else Plain(groups)
    return replace(a, block=block, layout=layout, groups=groups, x=x, arithmetic=arithmetic)


def _with_points(block: Block, points: Points) -> Block:
    return replace(block, points=points)


def _approximate(block: Block, ids: Sequence[str]) -> tuple[Floats, Indices]:
    """Approximate coordinates (n, 3) of all points, m, and the rows of those that may make the datum."""
    p = block.points
    released = _with_points(block, Points(p.ids, p.role, p.coordinates, np.full_like(p.sigma, np.nan)))
    unknowns = Unknowns.of(released, NoModel())
    x = initial.values(unknowns, ImagePoints.of(released, unknowns))
    given = np.isfinite(p.coordinates).all(axis=1) & (p.role != "check")
    return unknowns.points(x) + unknowns.origin, _chosen(block, ids, given)


def _chosen(block: Block, ids: Sequence[str], given: np.typing.NDArray[np.bool_]) -> Indices:
    if ids:
        unknown = [name for name in ids if name not in block.points.ids]
        if unknown:
            raise ValueError(f"point {unknown[0]!r} of the datum is not in the block")
        rows = np.flatnonzero(np.isin(block.points.ids, ids))
    else:
        rows = np.flatnonzero(given & (block.rays >= 2))
        rows = rows if len(rows) >= 3 else np.flatnonzero(block.rays >= 2)
    if len(rows) < 3:
        raise ValueError(f"a datum needs three points or more, there are {len(rows)}")
    return rows


def _least_control(points: Floats, rows: Indices, scaled: bool) -> Indices:
    """The places (among all coordinates) of minimum control: two points far apart, and of a third one far from their
    line the coordinate that a rotation about the line moves most. Where the scale is given, the second point stays free
    along the axis that is nearest to their line."""
    first = int(np.argmax(np.linalg.norm(points - points.mean(axis=0), axis=1)))
    second = int(np.argmax(np.linalg.norm(points - points[first], axis=1)))
    line = points[second] - points[first]
    across = np.cross(line, points - points[first])
    third = int(np.argmax(np.linalg.norm(across, axis=1)))
    if np.linalg.norm(across[third]) < COLLINEAR * (line @ line):
        raise ValueError("the points of the datum lie on a line, a rotation about it stays free")
    axis = int(np.argmax(np.abs(across[third])))
    two = (3 * rows[[first, second]][:, None] + np.arange(3)).ravel()
    if scaled:
        two = np.delete(two, 3 + int(np.argmax(np.abs(line))))
    return np.append(two, 3 * rows[third] + axis)
