"""Measurements between points on the ground: slope distances and height differences.

    distance + v = |X_b - X_a|,    height difference + v = Z_b - Z_a

in the Cartesian object frame, m; reductions for curvature and refraction are the surveyor's. Such a measurement ties
two points together, so neither can be eliminated alone: their free coordinates stand among the orientation unknowns.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from adjust.model import Unknowns
from adjust.observations.group import Linear, Name
from simfield.block import Block, Floats, Indices


@dataclass(frozen=True, eq=False)
class _Between:
    """ends (q) pairs of point ids, from and to; values and sigma (q), m."""

    ends: tuple[tuple[str, str], ...]
    values: Floats
    sigma: Floats

    kind = "distance"

    @property
    def ties_datum(self) -> bool:
        """Distances give a scale and leave the rest of the datum free; height differences know where up is."""
        return self.kind != "distance"

    @property
    def coupled(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(point for pair in self.ends for point in pair))

    def unknowns(self, block: Block) -> tuple[Name, ...]:
        """None. Raises ValueError for points that the block does not have and for shapes that do not fit."""
        for a, b in self.ends:
            for name in (a, b):
                if name not in block.points.ids:
                    raise ValueError(f"{self.kind} {a} - {b}: there is no point {name!r} in the block")
            if a == b:
                raise ValueError(f"{self.kind} {a} - {b}: the ends are the same point")
        q = len(self.ends)
        if np.shape(self.values) != (q,) or np.shape(self.sigma) != (q,):
            raise ValueError(f"{self.kind}s: {q} pairs of points need {q} values and {q} standard deviations")
        if not (np.isfinite(self.values).all() and (np.asarray(self.sigma) > 0.0).all()):
            raise ValueError(f"{self.kind}s: values must be finite and standard deviations > 0")
        return ()

    def bind(self, layout: Unknowns) -> BoundBetween:
        ids = {name: row for row, name in enumerate(layout.block.points.ids)}
        ends = np.array([[ids[a], ids[b]] for a, b in self.ends], dtype=np.intp).reshape(-1, 2)
        labels = tuple(f"{self.kind} {a} - {b}" for a, b in self.ends)
        values = np.asarray(self.values, dtype=float)
        weight = 1.0 / np.asarray(self.sigma, dtype=float) ** 2
        return BoundBetween(f"{self.kind}s", values, weight, labels, layout, ends, self.kind == "distance")


@dataclass(frozen=True, eq=False)
class Distances(_Between):
    """Slope distances between points."""


@dataclass(frozen=True, eq=False)
class HeightDifferences(_Between):
    """Heights of the second points above the first ones."""

    kind = "height difference"


@dataclass(frozen=True, eq=False)
class BoundBetween:
    """See adjust.observations.group.Bound. ends (q, 2) points; sloping: distances, otherwise height differences."""

    name: str
    given: Floats
    weight: Floats
    labels: tuple[str, ...]
    layout: Unknowns
    ends: Indices
    sloping: bool

    def at(self, x: Floats) -> Linear:
        points = self.layout.points(x)
        line = points[self.ends[:, 1]] - points[self.ends[:, 0]]
        if self.sloping:
            length = np.linalg.norm(line, axis=1)
            direction = line / length[:, None]
        else:
            length, direction = line[:, 2], np.tile([0.0, 0.0, 1.0], (len(line), 1))
        coordinates = 3 * self.ends[:, :, None] + np.arange(3)
        tied = ~self.layout.block.points.fixed.ravel()[coordinates]
        values = np.stack([-direction, direction], axis=1) * tied
        columns = np.where(tied, self.layout.places[coordinates], 0)
        return Linear(length - self.given, columns.reshape(len(line), 6), values.reshape(len(line), 6))

    def with_weight(self, weight: Floats) -> BoundBetween:
        return replace(self, weight=weight)
