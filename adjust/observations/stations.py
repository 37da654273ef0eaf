"""Observed exposure stations: positions by GNSS, attitudes by an inertial unit, with offset and drift per strip.

    observed + v = element + offset + drift t

for each of X0, Y0, Z0 or omega, phi, kappa, with t from -1 to 1 along a strip. Positions are those of the projection
centre: lever arms must have been applied. Attitudes are omega, phi, kappa of the block's own convention; the offset
stands for the boresight misalignment, which as an offset of the angles is good for small tilts. (Ackermann: Practical
experience with GPS supported aerial triangulation, Photogrammetric Record 14 (84), 1994, for offsets and drifts per
strip.)
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from adjust.model import EXTERIOR_NAMES, Unknowns, angles_of, rotation_matrices
from adjust.observations.group import Linear, Name
from simfield.block import Block, Floats, Indices

FIRST = {"position": 0, "attitude": 3}


@dataclass(frozen=True, eq=False)
class _Stations:
    """image_ids (q); values and sigma (q, 3), NaN where an element was not observed.

    strip (q): the strip of every image, or none for one strip; offset, drift: whether they are unknown, or the strips
    in which they are; time (q): from -1 to 1 along each strip, by default the order of the images in it.
    """

    image_ids: tuple[str, ...]
    values: Floats
    sigma: Floats
    strip: tuple[str, ...] = ()
    offset: bool | Collection[str] = False
    drift: bool | Collection[str] = False
    time: Floats | None = None

    kind = "position"

    @property
    def ties_datum(self) -> bool:
        return True

    @property
    def coupled(self) -> tuple[str, ...]:
        return ()

    @property
    def strips(self) -> tuple[str, ...]:
        """The strip of every image."""
        return self.strip or ("1",) * len(self.image_ids)

    @property
    def elements(self) -> tuple[str, ...]:
        return EXTERIOR_NAMES[FIRST[self.kind] : FIRST[self.kind] + 3]

    def terms(self, strip: str) -> tuple[str, ...]:
        """The kinds of unknowns of a strip: offset, drift."""
        said = {"offset": self.offset, "drift": self.drift}
        return tuple(term for term, where in said.items() if (where if isinstance(where, bool) else strip in where))

    def unknowns(self, block: Block) -> tuple[Name, ...]:
        """Raises ValueError for images that the block does not have and for shapes that do not fit."""
        missing = [name for name in self.image_ids if name not in block.images.ids]
        if missing:
            raise ValueError(f"{self.kind} of image {missing[0]!r}: there is no such image in the block")
        q = len(self.image_ids)
        if self.values.shape != (q, 3) or self.sigma.shape != (q, 3) or len(self.strips) != q:
            raise ValueError(f"{self.kind}s: {q} images need values and sigma of shape ({q}, 3) and {q} strips")
        if not (np.isnan(self.values) | (self.sigma > 0.0)).all():
            raise ValueError(f"{self.kind}s: every observed element needs a standard deviation > 0")
        strips, seen = np.array(self.strips), np.isfinite(self.values)
        return tuple(
            (f"{self.kind} of strip {name}", f"{term} {element}")
            for name in dict.fromkeys(self.strips)
            for term in self.terms(name)
            for element, observed in zip(self.elements, seen[strips == name].any(axis=0), strict=True)
            if observed
        )

    def times(self) -> Floats:
        """(q) from -1 to 1."""
        if self.time is not None:
            return self.time
        strips, times = np.array(self.strips), np.zeros(len(self.image_ids))
        for name in set(self.strips):
            mine = np.flatnonzero(strips == name)
            times[mine] = np.linspace(-1.0, 1.0, len(mine)) if len(mine) > 1 else 0.0
        return times

    def bind(self, layout: Unknowns) -> BoundStations:
        """Raises ValueError for an attitude along the object's X axis whose angles cannot be taken one by one."""
        seen, element = np.nonzero(np.isfinite(self.values))
        first = FIRST[self.kind]
        values = self._by_own_axes(layout) if self.kind == "attitude" else self.values
        image = np.array([layout.block.images.ids.index(name) for name in self.image_ids], dtype=np.intp)
        columns = [6 * image[seen] + first + element]
        derivatives = [np.ones(len(seen))]
        for term, factor in (("offset", np.ones(len(image))), ("drift", self.times())):
            place, derivative = np.zeros(len(seen), dtype=np.intp), np.zeros(len(seen))
            for row, (i, e) in enumerate(zip(seen, element, strict=True)):
                strip = self.strips[i]
                if term in self.terms(strip):
                    place[row] = layout.index(f"{self.kind} of strip {strip}", f"{term} {self.elements[e]}")
                    derivative[row] = factor[i]
            columns.append(place)
            derivatives.append(derivative)
        origin = layout.origin[element] if self.kind == "position" else 0.0
        labels = tuple(f"{self.elements[e]} of image {self.image_ids[i]}" for i, e in zip(seen, element, strict=True))
        return BoundStations(
            f"{self.kind}s",
            values[seen, element] - origin,
            1.0 / self.sigma[seen, element] ** 2,
            np.column_stack(columns),
            np.column_stack(derivatives),
            labels,
            self.kind == "attitude",
        )

    def _by_own_axes(self, layout: Unknowns) -> Floats:
        """(q, 3) the observed angles, those of images with renamed axes by these."""
        if layout.renamed is None:
            return self.values
        values = self.values.copy()
        for row, name in enumerate(self.image_ids):
            if layout.renamed[layout.block.images.ids.index(name)]:
                alike = np.isfinite(values[row]).all() and np.ptp(self.sigma[row]) == 0.0
                if not alike or self.terms(self.strips[row]):
                    raise ValueError(
                        f"attitude of image {name!r}: it looks along the X axis of the object frame, where omega and "
                        "kappa are one rotation; allowed are all three angles with one standard deviation, and neither "
                        "offset nor drift"
                    )
                values[row] = angles_of(rotation_matrices(values[row : row + 1]), np.ones(1, dtype=bool))[0]
        return values


@dataclass(frozen=True, eq=False)
class StationPositions(_Stations):
    """Observed X0, Y0, Z0, m."""


@dataclass(frozen=True, eq=False)
class StationAttitudes(_Stations):
    """Observed omega, phi, kappa, rad."""

    kind = "attitude"


@dataclass(frozen=True, eq=False)
class BoundStations:
    """See adjust.observations.group.Bound. The observations are sums of unknowns."""

    name: str
    given: Floats
    weight: Floats
    columns: Indices
    values: Floats
    labels: tuple[str, ...]
    angular: bool

    def at(self, x: Floats) -> Linear:
        v = np.sum(self.values * x[self.columns], axis=1) - self.given
        if self.angular:
            v = np.remainder(v + np.pi, 2.0 * np.pi) - np.pi
        return Linear(v, self.columns, self.values)

    def with_weight(self, weight: Floats) -> BoundStations:
        return replace(self, weight=weight)
