"""The numbers of several trials computed together.

Lanes are eight double or sixteen single precision numbers, one vector register wide. `load` takes them from the last
axis of an array, arithmetic acts on all of them, `store` puts them back. In plain Python they are rows of numpy arrays,
so that a kernel can be read and tested without the compiler; for numba `simfield.numerics.lanes_compiled` makes them
vectors, so that loops become vector instructions without the compiler having to prove anything, and sums stay in
registers.
"""

from __future__ import annotations

from typing import Any

import numpy as np

WIDTH, WIDTH_SINGLE = 8, 16
"""numbers in double and in single precision lanes"""


TOGETHER = 32
"""trials that are computed together, always the same, so that their bits do not hang on the block: enough for a matrix
product over them to run at full speed"""


def align_stack() -> None:
    """For the compiler: what of this function's lanes finds no register lies on the stack within lines of the cache.

    Without it chance decides, anew in every process, and what lies across two lines costs a quarter of the speed.
    """


def load(array: Any, *row: Any) -> Any:
    """The numbers array[row], the last axis of the array."""
    return array[row]


def store(array: Any, value: Any, *row: Any) -> None:
    """array[row] = value."""
    array[row] = value


def same(number: float) -> Any:
    """A double precision number in all lanes."""
    return np.full(WIDTH, number)


def narrow(first: Any, second: Any) -> Any:
    """Two double precision lanes as one of single precision."""
    return np.concatenate([first, second]).astype(np.float32)


def widen(value: Any) -> tuple[Any, Any]:
    """The halves of single precision lanes in double precision."""
    return value[:WIDTH].astype(np.float64), value[WIDTH:].astype(np.float64)


def least(a: Any, b: Any) -> Any:
    """The lesser of each two numbers; b where they cannot be compared."""
    return np.where(a < b, a, b)


def root(a: Any) -> Any:
    """Square roots."""
    return np.sqrt(a)


def whole(a: Any) -> Any:
    """The nearest whole numbers."""
    return np.rint(a)


def choose(condition: Any, yes: Any, no: Any) -> Any:
    """yes where the condition is not zero, no elsewhere."""
    return np.where(condition != 0.0, yes, no)


def equal(a: Any, b: Any) -> Any:
    """1 where a = b, 0 elsewhere."""
    return np.where(a == b, 1.0, 0.0)


def not_equal(a: Any, b: Any) -> Any:
    """1 where a != b, 0 elsewhere."""
    return np.where(a != b, 1.0, 0.0)


def greater(a: Any, b: Any) -> Any:
    """1 where a > b, 0 elsewhere."""
    return np.where(a > b, 1.0, 0.0)


def less(a: Any, b: Any) -> Any:
    """1 where a < b, 0 elsewhere."""
    return np.where(a < b, 1.0, 0.0)


def any_above(a: Any, b: float) -> bool:
    """Whether any number is greater than b, or is not a number."""
    return bool(np.any(~(a <= b)))


def sine(a: Any) -> Any:
    """Sines."""
    return np.sin(a)


def cosine(a: Any) -> Any:
    """Cosines."""
    return np.cos(a)


def exponential(a: Any) -> Any:
    """Exponentials."""
    return np.exp(a)


def direction(y: Any, x: Any) -> Any:
    """atan2(y, x)."""
    return np.arctan2(y, x)


def power(a: Any, exponent: Any) -> Any:
    """a to the power of the exponent."""
    return np.power(a, exponent)


def magnitude(a: Any) -> Any:
    """Absolute values."""
    return np.abs(a)
