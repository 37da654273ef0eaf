"""Test fields: groups of signalised points, their numbers and heights, and which of them are control.

Every field is centred on the origin of the object frame. A group's central point carries the group's own id ("11"), its
auxiliary points a suffix ("11.1", "11.2").
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from simfield.block import Floats, Indices
from simfield.random import stream

MEMBER_OFFSETS = np.array([[0.0, 0.0], [0.5, np.sqrt(0.75)], [-0.5, np.sqrt(0.75)]])
"""Places of a group's points, central point first, in units of their spacing: an equilateral triangle, one side east-
west.
"""

GroupSize = Literal[1, 2, 3]
Layout = Literal["none", "corners", "corners-and-centre", "perimeter", "dense"]


@dataclass(frozen=True, eq=False)
class FieldPoints:
    """The points of a built field with their true coordinates.

    ids (n), coordinates (n, 3) in metres, group (n) index into group_ids, central (n) true for the central point of its
    group, corner (g), middle (g) and edge (g) the groups at the corners, nearest to the centre and on the perimeter.
    """

    ids: tuple[str, ...]
    coordinates: Floats
    group: Indices
    central: npt.NDArray[np.bool_]
    group_ids: tuple[str, ...]
    corner: npt.NDArray[np.bool_]
    middle: npt.NDArray[np.bool_]
    edge: npt.NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.ids)

    def of_groups(self, chosen: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
        """(n): the central points of the chosen (g) groups."""
        return self.central & chosen[self.group]


@dataclass(frozen=True)
class Relief:
    """Heights: one for each group, around mean_m with sigma_m; its points differ from it by member_sigma_m."""

    mean_m: float = 50.0
    sigma_m: float = 3.0
    member_sigma_m: float = 0.3

    def __post_init__(self) -> None:
        if min(self.sigma_m, self.member_sigma_m) < 0.0:
            raise ValueError("sigma_m and member_sigma_m of the relief must be >= 0")

    def heights(self, n_groups: int, group_size: int, seed: int) -> Floats:
        """(n_groups, group_size) heights in metres."""
        ground = self.mean_m + self.sigma_m * stream(seed, "heights").standard_normal((n_groups, 1))
        # Three columns always, so that the heights of central points do not depend on the group size.
        members = self.member_sigma_m * stream(seed, "member-heights").standard_normal((n_groups, 3))
        return np.asarray(ground + members[:, :group_size])


@dataclass(frozen=True)
class Quincunx:
    """A square raster of point groups and the centres of its cells: 5 x 5 + 4 x 4 = 41 groups at Rheidt.

    Source: Mauelshagen 1980 (2 km x 2 km, 41 groups of three); Stark 1973, p. 31, for the raster, for the cell
    centres and for the numbering 11-15, 16-19, 21-25, ... 51-55, here from north to south and from west to east
    (assumption). The distance within a group is not known: 20 m keeps a group inside one stereocomparator field of
    view, and distances of 3 to 60 m leave the correlations of the published block as they are. Relief: "flat test
    area" (Kupfer 1976).
    """

    per_side: int = 5
    spacing_m: float = 500.0
    group_size: GroupSize = 3
    member_spacing_m: float = 20.0
    relief: Relief = Relief()
    kind: Literal["quincunx"] = "quincunx"

    def __post_init__(self) -> None:
        if not 2 <= self.per_side <= 5:
            raise ValueError(f"per_side {self.per_side} is not allowed, the numbering of the quincunx holds for 2 to 5")
        _check_spacings(self.spacing_m, self.group_size, self.member_spacing_m)

    def build(self, seed: int) -> FieldPoints:
        """The field's points; the heights come from the seed."""
        ids, places = [], []
        n, half = self.per_side, (self.per_side - 1) / 2.0
        for row in range(n):
            for column in range(n):
                ids.append(f"{row + 1}{column + 1}")
                places.append((column - half, half - row))
            for column in range(n - 1 if row < n - 1 else 0):
                ids.append(f"{row + 1}{n + column + 1}")
                places.append((column + 0.5 - half, half - row - 0.5))
        xy = self.spacing_m * np.array(places)
        return _with_members(tuple(ids), xy, self.group_size, self.member_spacing_m, self.relief, seed)


@dataclass(frozen=True)
class RegularGrid:
    """nx by ny point groups at one spacing, numbered by row from the north and column from the west: "r1c1", "r1c2",
    ...
    """

    nx: int
    ny: int
    spacing_m: float
    group_size: GroupSize = 1
    member_spacing_m: float = 20.0
    relief: Relief = Relief()
    kind: Literal["grid"] = "grid"

    def __post_init__(self) -> None:
        if min(self.nx, self.ny) < 2:
            raise ValueError(f"a grid of {self.nx} x {self.ny} points is too small, needed are 2 x 2")
        _check_spacings(self.spacing_m, self.group_size, self.member_spacing_m)

    def build(self, seed: int) -> FieldPoints:
        """The field's points; the heights come from the seed."""
        rows, columns = (i.ravel() for i in np.indices((self.ny, self.nx)))
        ids = tuple(f"r{row + 1}c{column + 1}" for row, column in zip(rows, columns, strict=True))
        xy = self.spacing_m * np.column_stack([columns - (self.nx - 1) / 2.0, (self.ny - 1) / 2.0 - rows])
        return _with_members(ids, xy, self.group_size, self.member_spacing_m, self.relief, seed)


Field = Quincunx | RegularGrid
FIELDS = (Quincunx, RegularGrid)
"""the kinds that a scenario may name"""


@dataclass(frozen=True)
class Control:
    """Which points are control, and how well the adjustment is told they are known.

    Layouts take the central point of the groups at the corners, at the corners and nearest to the centre, or on the
    perimeter; "dense" takes every point. sigma 0 is control held fixed, sigma > 0 enters as an observation. All other
    points take the role `rest`.
    """

    layout: Layout = "corners-and-centre"
    sigma_xy_mm: float = 0.0
    sigma_z_mm: float = 0.0
    rest: Literal["check", "tie"] = "check"

    def __post_init__(self) -> None:
        if min(self.sigma_xy_mm, self.sigma_z_mm) < 0.0:
            raise ValueError("sigma_xy_mm and sigma_z_mm of the control must be >= 0")

    def of(self, field: FieldPoints) -> npt.NDArray[np.bool_]:
        """(n): the control points of a field."""
        if self.layout == "none":
            return np.zeros(len(field), dtype=bool)
        if self.layout == "dense":
            return np.ones(len(field), dtype=bool)
        if self.layout == "perimeter":
            return field.of_groups(field.edge)
        return field.of_groups(field.corner | field.middle if self.layout == "corners-and-centre" else field.corner)


def _check_spacings(spacing_m: float, group_size: int, member_spacing_m: float) -> None:
    if spacing_m <= 0.0 or member_spacing_m <= 0.0:
        raise ValueError("spacing_m and member_spacing_m must be > 0")
    if group_size > 1 and member_spacing_m >= 0.5 * spacing_m:
        raise ValueError(
            f"member_spacing_m {member_spacing_m:g} mixes neighbouring groups, allowed is < {spacing_m / 2:g}"
        )


def _with_members(
    group_ids: tuple[str, ...], xy: Floats, size: int, member_spacing_m: float, relief: Relief, seed: int
) -> FieldPoints:
    """The points of groups at xy (g, 2) metres, group by group, central point first."""
    places = xy[:, None, :] + member_spacing_m * MEMBER_OFFSETS[None, :size]
    heights = relief.heights(len(group_ids), size, seed)
    reach, distance = np.abs(xy), np.hypot(xy[:, 0], xy[:, 1])
    on_side = np.isclose(reach, reach.max(axis=0))
    middle = np.zeros(len(group_ids), dtype=bool)
    middle[np.argmin(distance)] = True
    return FieldPoints(
        ids=tuple(g if member == 0 else f"{g}.{member}" for g in group_ids for member in range(size)),
        coordinates=np.dstack([places, heights]).reshape(-1, 3),
        group=np.repeat(np.arange(len(group_ids)), size),
        central=np.tile(np.arange(size) == 0, len(group_ids)),
        group_ids=group_ids,
        corner=on_side.all(axis=1),
        middle=middle,
        edge=on_side.any(axis=1),
    )
