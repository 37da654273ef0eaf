"""Further observations, beside image points and control: what a group of them must say, and how it enters the normals.

A group is a value a user makes, such as adjust.observations.stations.StationPositions. Bound to the layout of a block
it gives corrections v = f(x) - observed, weights, and a few derivatives a row. All of them belong to orientation
unknowns (exterior orientation, additional parameters, and unknowns that the group brings along), so that eliminating
the points stays as it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from adjust.model import Unknowns
from simfield.block import Block, Floats, Indices

Name = tuple[str, str]


@dataclass(frozen=True, eq=False)
class Linear:
    """q observations at some x: v (q), and derivatives values (q, c) by the unknowns columns (q, c); 0 fills up."""

    v: Floats
    columns: Indices
    values: Floats


class Bound(Protocol):
    """A group of q observations, bound to the layout of a block."""

    @property
    def name(self) -> str: ...

    @property
    def weight(self) -> Floats:
        """(q)."""

    @property
    def given(self) -> Floats:
        """(q) the observed values."""

    @property
    def labels(self) -> tuple[str, ...]:
        """(q) each observation in words."""

    def at(self, x: Floats) -> Linear: ...

    def with_weight(self, weight: Floats, /) -> Bound: ...


class Group(Protocol):
    """A group as a user states it."""

    @property
    def ties_datum(self) -> bool:
        """Whether it says where the block is, so that a free network is no longer free."""

    @property
    def coupled(self) -> tuple[str, ...]:
        """The points that the group ties to each other, so that they cannot be eliminated one by one."""

    def unknowns(self, block: Block) -> tuple[Name, ...]:
        """The unknowns (owner, name) that the group brings along. Raises ValueError for what is not in the block."""

    def bind(self, layout: Unknowns) -> Bound: ...


def unknowns_of(groups: Sequence[Group], block: Block) -> tuple[Name, ...]:
    """The unknowns of all groups. Raises ValueError where two have the same name."""
    names = tuple(name for group in groups for name in group.unknowns(block))
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"two groups of observations have an unknown {twice[1]} of {twice[0]}; name one of them")
    return names


class TwoImagesError(ValueError):
    """An observation touches the unknowns of two images, for which normal equations image by image have no place."""


def vpv(groups: Sequence[Bound], x: Floats) -> float:
    return float(sum(np.sum(group.weight * group.at(x).v ** 2) for group in groups))


Forms = Sequence[tuple[Floats, Linear]]
"""weights (q) and linear forms"""


def add_gradient(forms: Forms, gradient: Floats) -> None:
    """Add A^T P v to the gradient of the orientation unknowns (E).

    Raises ValueError for derivatives by coordinates that are eliminated.
    """
    for weight, at in forms:
        if at.columns.max(initial=0) >= len(gradient):
            raise ValueError("a group of observations touches a point that it does not name as coupled")
        np.add.at(gradient, at.columns, (weight * at.v)[:, None] * at.values)


def add_dense(forms: Forms, ee: Floats) -> None:
    """Add A^T P A to the normal equations of the orientation unknowns (E, E)."""
    for weight, at in forms:
        products = weight[:, None, None] * at.values[:, :, None] * at.values[:, None, :]
        np.add.at(ee, (at.columns[:, :, None], at.columns[:, None, :]), products)


def add_blocks(forms: Forms, ee: Floats, ea: Floats, aa: Floats) -> None:
    """Add A^T P A to ee (m, 6, 6) lower triangles, ea (m, 6, A) and aa (A, A), as adjust.normals.normals_compiled
    keeps them.

    Raises TwoImagesError for an observation that touches more than one image.
    """
    images = 6 * len(ee)
    for weight, at in forms:
        products = weight[:, None, None] * at.values[:, :, None] * at.values[:, None, :]
        i = np.broadcast_to(at.columns[:, :, None], products.shape)
        j = np.broadcast_to(at.columns[:, None, :], products.shape)
        used = products != 0.0
        inside = used & (i < images) & (j <= i)
        if (i[inside] // 6 != j[inside] // 6).any():
            raise TwoImagesError("an observation touches two images")
        np.add.at(ee, (i[inside] // 6, i[inside] % 6, j[inside] % 6), products[inside])
        across = used & (i < images) & (j >= images)
        np.add.at(ea, (i[across] // 6, i[across] % 6, j[across] - images), products[across])
        border = used & (i >= images) & (j >= images)
        np.add.at(aa, (i[border] - images, j[border] - images), products[border])
