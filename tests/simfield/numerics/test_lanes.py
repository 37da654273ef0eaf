"""Lanes compiled are lanes in plain Python: arithmetic, functions, and the kernels written with them."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest

import simfield.numerics.lanes_compiled  # noqa: F401  lanes for numba
from adjust import ap_models
from adjust.model.rotation import rotation_matrices
from adjust.trials import gradient_compiled as kernels
from adjust.trials.traced_terms import compile_gradient
from simfield.numerics import lanes
from simfield.numerics.arena import CACHE_LINE, Arena
from simfield.numerics.lanes import WIDTH, load, store

FUSED = 4 * np.finfo(float).eps
"""of results near 1: a product and a sum may be fused"""

# lambdas all, for numba is taught calls of these functions, not what stands in them
ONE = {
    "root": lambda a: lanes.root(lanes.magnitude(a)),
    "magnitude": lambda a: lanes.magnitude(a),
    "whole": lambda a: lanes.whole(10.0 * a),
    "sine": lambda a: lanes.sine(a),
    "cosine": lambda a: lanes.cosine(a),
    "exponential": lambda a: lanes.exponential(a),
    "power": lambda a: lanes.power(lanes.magnitude(a), 2.5),
    "negative": lambda a: -a,
    "sums": lambda a: 1.0 - (a * 2.0 + a / 3.0 - 1.0 / (a + 4.0)),
}
TWO = {
    "least": lambda a, b: lanes.least(a, b),
    "choose": lambda a, b: lanes.choose(lanes.greater(a, b), a, 0.0),
    "equal": lambda a, b: lanes.equal(a, b) + lanes.not_equal(a, 1.0),
    "less": lambda a, b: lanes.less(a, b) + lanes.greater(0.5, b),
    "direction": lambda a, b: lanes.direction(a, b),
}


def rows(seed: int, count: int) -> np.ndarray:
    numbers = np.random.default_rng(seed).uniform(-2.0, 2.0, (count, WIDTH))
    numbers[0, :3] = 0.0, -0.0, 1.0
    return numbers


@pytest.mark.parametrize("name", ONE)
def test_functions_of_one(name):
    function = numba.njit(ONE[name])

    @numba.njit
    def compiled(a, out):
        for row in range(a.shape[0]):
            store(out, function(load(a, row)), row)

    a = rows(1, 5)
    out = np.empty_like(a)
    compiled(a, out)
    np.testing.assert_allclose(out, ONE[name](a), rtol=FUSED, atol=FUSED)


@pytest.mark.parametrize("name", TWO)
def test_functions_of_two(name):
    function = numba.njit(TWO[name])

    @numba.njit
    def compiled(a, b, out):
        for row in range(a.shape[0]):
            store(out, function(load(a, row), load(b, row)), row)

    a, b = rows(1, 5), rows(2, 5)
    b[1] = a[1]
    out = np.empty_like(a)
    compiled(a, b, out)
    np.testing.assert_allclose(out, TWO[name](a, b), rtol=FUSED, atol=FUSED)


@pytest.mark.parametrize("odd", [1.0, 2.5, np.inf, np.nan])
def test_any_above_sees_every_lane(odd):
    @numba.njit
    def compiled(a, b):
        return lanes.any_above(load(a, 0), b)

    for lane in range(WIDTH):
        a = np.zeros((1, WIDTH))
        a[0, lane] = odd
        assert compiled(a, 2.0) == lanes.any_above(a[0], 2.0) == (odd != 1.0)


def test_single_precision_there_and_back():
    @numba.njit
    def compiled(a, single, out):
        store(single, lanes.narrow(load(a, 0), load(a, 1)), 0)
        halves = lanes.widen(load(single, 0) * np.float32(2.0))
        for half in range(2):
            store(out, halves[half], half)

    a, single, out = rows(3, 2), np.empty((1, 2 * WIDTH), dtype=np.float32), np.empty((2, WIDTH))
    compiled(a, single, out)
    assert np.array_equal(single[0], lanes.narrow(*a))
    assert np.array_equal(out, np.array(lanes.widen(2 * single[0])))


def test_sine_and_cosine_over_many_turns():
    @numba.njit
    def compiled(angle, sine, cosine):
        for row in range(angle.shape[0]):
            s, c = kernels.sine_and_cosine(load(angle, row))
            store(sine, s, row)
            store(cosine, c, row)

    quarters = np.arange(-60, 60) * (math.pi / 4)
    angle = np.concatenate([quarters, np.random.default_rng(0).uniform(-50.0, 50.0, 4000)]).reshape(-1, WIDTH)
    sine, cosine = np.empty_like(angle), np.empty_like(angle)
    compiled(angle, sine, cosine)
    assert np.abs(sine - np.sin(angle)).max() <= FUSED
    assert np.abs(cosine - np.cos(angle)).max() <= FUSED


def test_contexts_are_rotations():
    images = 3
    x = np.random.default_rng(4).uniform(-3.0, 3.0, (2, 6 * images + 2, WIDTH))
    contexts, turns = np.zeros((2, images, kernels.PARAMETERS + 2, WIDTH)), np.zeros((2, images, 2, WIDTH))
    renamed = np.array([False, True, False])
    kernels.fill_contexts(np.arange(images).astype(np.uint64), renamed, x, 6 * images, turns, contexts)
    exterior = x[1, : 6 * images, 5].reshape(images, 6)
    matrices = contexts[1, :, :9, 5].reshape(images, 3, 3)
    np.testing.assert_allclose(matrices, rotation_matrices(exterior[:, 3:], renamed), atol=FUSED)
    assert np.array_equal(contexts[1, :, 9:12, 5], exterior[:, :3])
    assert np.array_equal(contexts[1, 0, 12:, 5], x[1, -2:, 5])


def test_the_kernel_runs_without_the_compiler():
    """The readable kernel, without additional parameters, is the compiled one."""
    rng = np.random.default_rng(6)
    k = 6
    contexts = np.zeros((1, 2, kernels.PARAMETERS, WIDTH))
    contexts[:, :, :9] = np.eye(3).ravel()[:, None]
    contexts[:, :, 11] = 1000.0 + rng.standard_normal((1, 2, WIDTH))
    x = rng.uniform(-300.0, 300.0, (1, 3 * 3, WIDTH))
    arguments = (
        np.arange(2).astype(np.uint64), np.array([0, 3, 6], np.uint64), np.tile(np.arange(3), 2), np.ones((k, 2)),
        np.array([[150.0, 0.01, 0.02], [85.0, 0.0, 0.0]]), contexts, 0, rng.uniform(-100.0, 100.0, (1, k, 2, WIDTH)), x,
    )  # fmt: skip
    found = []
    for kernel in (kernels.gradient_block, compile_gradient(ap_models.get("none"))):
        sums, g = np.zeros((1, 2, kernels.PULL, WIDTH)), np.zeros_like(x)
        kernel(*arguments, sums, g)
        found.append((sums, g))
    for readable, compiled in zip(*found, strict=True):
        np.testing.assert_allclose(compiled, readable, rtol=1e-12)


def test_an_arena_begins_its_arrays_with_cache_lines():
    arena = Arena()
    arrays = [arena.array(*shape) for shape in ((3, 5), (7,), (2, 9, 8), (3000, 1000), (2,))]
    for number, array in enumerate(arrays):
        assert array.ctypes.data % CACHE_LINE == 0
        array[:] = number
    assert [array.shape for array in arrays] == [(3, 5), (7,), (2, 9, 8), (3000, 1000), (2,)]
    assert all((array == number).all() for number, array in enumerate(arrays))  # nobody has another's memory
    assert arena.array(4, dtype=np.float32).dtype == np.float32


def test_what_an_arena_takes_back_it_gives_again():
    arena = Arena()
    first = arena.array(3, 5)
    first[:] = np.nan
    arena.take_back()
    again = arena.zeros(3, 5)
    assert np.shares_memory(again, first)
    assert not again.any()
