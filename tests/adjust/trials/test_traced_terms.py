"""The traced, scalar form of every set is its numpy basis, the centre of the format included."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from adjust import ap_models
from adjust.ap_models import properties
from adjust.ap_models.lookup import MODELS
from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.terms import Term
from adjust.trials import gradient_compiled as kernels
from adjust.trials.traced_terms import Trace, UntraceableError, compile_gradient
from simfield.block.block import Floats
from simfield.numerics import lanes

AGREEMENT = 1e-12
"""of the largest value of each term; the forms differ in the order of their operations"""
EXTREME = {
    "legendre": {"m": 9, "n": 9},
    "zernike": {"n": 9},
    "fourier": {"m": 3, "n": 3},
    "chebyshev": {"m": 5, "n": 4},
}
MODELS_TO_TRACE = [
    *(pytest.param(kind(), id=kind.id) for kind in MODELS),
    *(pytest.param(ap_models.get(name, **settings), id=f"{name}-high") for name, settings in EXTREME.items()),
]


def points() -> tuple[Floats, Floats]:
    """Even and random points of the format, points close to the centre, and the centre itself."""
    x, y = properties.grid(115.0, 7)
    more = np.random.default_rng(3).uniform(-115.0, 115.0, (50, 2))
    near = 1e-9 * np.array([[1.0, 0.0], [0.0, -1.0], [0.0, 0.0], [-0.0, 0.0]])
    return np.concatenate([x, more[:, 0], near[:, 0]]), np.concatenate([y, more[:, 1], near[:, 1]])


def scalar_basis(model: ApModel, x: Floats, y: Floats) -> Floats:
    """(k, 2, a) by the traced lines, run as plain Python one point after the other."""
    trace = Trace.of(model)
    parts = ", ".join(f"({dx or 0.0}, {dy or 0.0})" for dx, dy in trace.parts)
    code = compile("\n".join([*trace.lines, f"found = [{parts}]"]), "trace", "exec")
    rows = []
    for px, py in zip(x.tolist(), y.tolist(), strict=True):
        names = {**vars(lanes), "x": px, "y": py}
        exec(code, names)
        rows.append(np.array(names["found"], dtype=float).reshape(-1, 2).T)
    return np.array(rows)


@pytest.mark.parametrize("model", MODELS_TO_TRACE)
def test_the_trace_is_the_basis(model: ApModel) -> None:
    x, y = points()
    basis = model.basis(x, y)
    size = np.abs(basis).max(axis=(0, 1), initial=0.0)
    wrong = np.abs(scalar_basis(model, x, y) - basis).max(axis=(0, 1), initial=0.0) / size
    assert wrong.max(initial=0.0) <= AGREEMENT


@pytest.mark.parametrize("model", MODELS_TO_TRACE)
def test_no_set_of_the_catalogue_needs_an_arc_tangent(model: ApModel) -> None:
    assert not any("direction(" in line for line in Trace.of(model).lines)


@dataclass(frozen=True)
class Branching(ApModel):
    """A set whose terms look at their coordinates, which cannot be traced."""

    id: ClassVar[str] = "branching"
    title: ClassVar[str] = "A set with a branch"
    author: ClassVar[str] = "nobody"
    year: ClassVar[int] = 2000
    source: ClassVar[str] = "this test"
    certainty: ClassVar[Certainty] = Certainty.MEMORY

    @property
    def parameters(self) -> tuple[str, ...]:
        return ("a1",)

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        return [(0, x * y if np.all(x == 0) else x)]


def test_what_cannot_be_traced_is_refused() -> None:
    with pytest.raises(UntraceableError):
        Trace.of(Branching())


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS_TO_TRACE)
def test_the_compiled_gradient_is_that_of_the_basis(model: ApModel) -> None:
    """One image over points at random: the pull on the parameters is B^T P v, with v of projection and distortion."""
    rng = np.random.default_rng(5)
    k, a = 40, len(model.parameters)
    trials = np.ones((1, 1, 1, lanes.WIDTH))
    coordinates = np.column_stack([rng.uniform(-700.0, 700.0, (k, 2)), rng.uniform(0.0, 40.0, k)])
    station = np.array([3.0, -5.0, 1000.0])
    xy = rng.uniform(-100.0, 100.0, (k, 2))
    xy[0] = 0.0
    basis = model.basis(*xy.T)
    size = np.abs(basis).max(axis=(0, 1), initial=0.0)
    values = rng.standard_normal(a) * 0.01 / size
    c, principal = 150.0, np.array([0.02, -0.01])
    ray = coordinates - station
    v = principal - c * ray[:, :2] / ray[:, 2:] + basis @ values - xy
    weight = np.full((k, 2), 4.0)
    context = np.concatenate([np.eye(3).ravel(), station, values])[None, None, :, None] * trials
    sums, gradient = np.zeros((1, 1, kernels.PULL + a, lanes.WIDTH)), np.zeros((1, 3 * k, lanes.WIDTH))
    compile_gradient(model)(
        np.array([0], np.uint64), np.array([0, k], np.uint64), np.arange(k), weight, np.array([[c, *principal]]),
        context, 0, xy[None, :, :, None] * trials, coordinates.reshape(1, -1, 1) * trials[0], sums, gradient,
    )  # fmt: skip
    wanted = np.einsum("kij,ki->j", basis, weight * v)
    largest = np.einsum("kij,ki->j", np.abs(basis), np.abs(weight * v))
    assert np.abs((sums[0, 0, kernels.PULL :, 7] - wanted) / largest).max(initial=0.0) <= AGREEMENT
    assert sums[0, 0, kernels.VPV, 7] == pytest.approx(np.sum(weight * v**2), rel=AGREEMENT)
