"""Observations that the compiled arithmetic has no place for are adjusted by the readable one, with the same result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from adjust import Adjustment, adjust_block, ap_models
from adjust.datum import MinimumControl
from adjust.model.unknowns import Unknowns
from adjust.normals.normals import Plain
from adjust.observations.group import Group, Linear, Name
from adjust.quality.gross_errors import snoop
from adjust.quality.robust_estimation import robust
from adjust.quality.variance import groups_by_camera, variance_components
from simfield.block.block import Block, Floats, Indices
from tests import synthetic

MODEL = ap_models.get("optical")
SAME = 1e-9
"""of a standard deviation: two ways through the same normal equations"""


@dataclass(frozen=True, eq=False)
class BoundSum:
    """Weighted sums of orientation unknowns as observations: coefficients (q, c) on columns (q, c)."""

    columns: Indices
    coefficients: Floats
    given: Floats
    weight: Floats
    from_second_on: bool = False
    """leave the derivatives by all but the first unknown out at the first evaluation, as a group may at some x"""

    name = "sums"

    @property
    def labels(self) -> tuple[str, ...]:
        return tuple(f"sum {i}" for i in range(len(self.given)))

    def at(self, x: Floats) -> Linear:
        values = self.coefficients.copy()
        if self.from_second_on and not SEEN:
            values[:, 1:] = 0.0
        SEEN.append(1)
        return Linear((self.coefficients * x[self.columns]).sum(axis=1) - self.given, self.columns, values)

    def with_weight(self, weight: Floats, /) -> BoundSum:
        return replace(self, weight=weight)


SEEN: list[int] = []


@dataclass(frozen=True, eq=False)
class Sum:
    """The sum of some unknowns (owner, name), as observed."""

    members: tuple[tuple[str, str], ...]
    coefficients: tuple[float, ...]
    value: float
    sigma: float
    late: bool = False

    ties_datum = False
    coupled: tuple[str, ...] = ()

    def unknowns(self, block: Block) -> tuple[Name, ...]:
        return ()

    def bind(self, layout: Unknowns) -> BoundSum:
        columns = np.array([[layout.index(*member) for member in self.members]])
        origin = np.array(
            [layout.origin["XYZ".index(n[0])] if n in ("X0", "Y0", "Z0") else 0.0 for _, n in self.members]
        )
        given = np.array([self.value - float(np.dot(self.coefficients, origin))])
        return BoundSum(columns, np.array([self.coefficients]), given, np.array([self.sigma**-2]), self.late)


@pytest.fixture(scope="module")
def w(ww_world: synthetic.World) -> synthetic.World:
    return ww_world.with_noise(np.random.default_rng(3)).controlled(synthetic.CONTROL, (0.02, 0.02, 0.02))


def between_two(w: synthetic.World, late: bool = False) -> Sum:
    """The height difference of two stations."""
    ids, z = w.block.images.ids, w.exterior[:, 2]
    return Sum(((ids[0], "Z0"), (ids[5], "Z0")), (1.0, -1.0), float(z[0] - z[5]) + 0.03, 0.02, late)


def between_three(w: synthetic.World) -> Sum:
    ids, z = w.block.images.ids, w.exterior[:, 2]
    value = float(z[0] - 2.0 * z[4] + z[8])
    return Sum(((ids[0], "Z0"), (ids[4], "Z0"), (ids[8], "Z0")), (1.0, -2.0, 1.0), value, 0.02)


def with_parameter(w: synthetic.World) -> Sum:
    """Two images and an additional parameter."""
    ids, z = w.block.images.ids, w.exterior[:, 2]
    members = ((ids[0], "Z0"), (ids[5], "Z0"), ("ww", MODEL.parameters[0]))
    return Sum(members, (1.0, -1.0, 100.0), float(z[0] - z[5]), 0.02)


def of_one_image(w: synthetic.World) -> Sum:
    """An image and a parameter: the compiled arithmetic takes it."""
    return Sum(
        ((w.block.images.ids[0], "Z0"), ("ww", MODEL.parameters[0])), (1.0, 100.0), float(w.exterior[0, 2]), 0.02
    )


KINDS: dict[str, Callable[[synthetic.World], Group]] = {
    "two images": between_two,
    "three images": between_three,
    "two images and a parameter": with_parameter,
    "one image and a parameter": of_one_image,
}


def same(one: Adjustment, other: Adjustment) -> None:
    assert one.status.ok, one.message
    assert (one.observations, one.unknowns, one.redundancy) == (other.observations, other.unknowns, other.redundancy)
    std = np.sqrt(other.cofactors.diagonal)
    free = std > 0.0
    assert np.max(np.abs(one.x - other.x)[free] / std[free]) < SAME
    np.testing.assert_allclose(np.sqrt(one.cofactors.diagonal), std, rtol=1e-8, atol=0.0)
    np.testing.assert_allclose(one.sigma0, other.sigma0, rtol=1e-11)


@pytest.mark.parametrize("kind", list(KINDS))
def test_both_arithmetics_agree(w: synthetic.World, kind: str) -> None:
    group = KINDS[kind](w)
    plain = adjust_block(w.block, MODEL, observations=[group], compiled=False)
    found = adjust_block(w.block, MODEL, observations=[group])
    same(found, plain)
    assert isinstance(found.arithmetic, Plain) == kind.startswith(("two", "three"))
    without = adjust_block(w.block, MODEL)
    assert np.max(np.abs(found.x - without.x)) > 1e-6, "the observation does something"


def test_a_group_that_ties_images_only_later_is_adjusted_too(w: synthetic.World) -> None:
    SEEN.clear()
    found = adjust_block(w.block, MODEL, observations=[between_two(w, late=True)])
    same(found, adjust_block(w.block, MODEL, observations=[between_two(w)], compiled=False))


@pytest.mark.parametrize("again", ["snoop", "robust", "variance components", "minimum control"])
def test_what_adjusts_again_goes_the_same_way(w: synthetic.World, again: str) -> None:
    group = between_two(w)

    def run(compiled: bool) -> Any:
        datum = MinimumControl() if again == "minimum control" else None
        a = adjust_block(w.block, MODEL, observations=[group], compiled=compiled, datum=datum)
        if again == "snoop":
            return snoop(a).adjustment
        if again == "robust":
            return robust(a).adjustment
        if again == "variance components":
            return variance_components(a, groups_by_camera(a)).adjustment
        return a

    same(run(True), run(False))


def test_a_group_that_touches_a_point_without_saying_so_is_refused(w: synthetic.World) -> None:
    @dataclass(frozen=True, eq=False)
    class Undeclared(Sum):
        def bind(self, layout: Unknowns) -> BoundSum:
            column = np.array([[layout.orientation]])
            return BoundSum(column, np.array([[1.0]]), np.zeros(1), np.ones(1))

    with pytest.raises(ValueError, match="does not name as coupled"):
        adjust_block(w.block, MODEL, observations=[Undeclared((), (), 0.0, 1.0)])
