"""Memory for arrays of lanes that is used again and again."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

CACHE_LINE = 64
"""bytes"""


LARGE_PAGES = 16 << 20
"""bytes; numpy asks for large pages from a quarter of this on"""


class Arena:
    """Memory for arrays of lanes: each begins with a line of the cache, and all lie together in a few large pages.

    numpy asks the system for large pages where it allocates some megabytes at once; arrays on small pages scattered in
    memory were up to a third slower, and by chance.
    """

    def __init__(self, at_once: int = LARGE_PAGES) -> None:
        """at_once: the bytes that the system is asked for at a time."""
        self.at_once = at_once
        self.pages = self.free = np.empty(0, dtype=np.uint8)

    def array(self, *shape: int, dtype: type[np.floating[Any]] = np.float64) -> npt.NDArray[Any]:
        """An array that nobody else has; its numbers are whatever was there."""
        size = math.prod(shape) * np.dtype(dtype).itemsize
        if len(self.free) < size + CACHE_LINE:
            self.pages = self.free = np.empty(max(self.at_once, size + CACHE_LINE), dtype=np.uint8)
        begin = -self.free.ctypes.data % CACHE_LINE
        taken, self.free = self.free[begin : begin + size], self.free[begin + size :]
        return taken.view(dtype).reshape(shape)

    def zeros(self, *shape: int) -> npt.NDArray[np.float64]:
        """The same, of zeros."""
        array = self.array(*shape)
        array[:] = 0.0
        return array

    def take_back(self) -> None:
        """Use the memory again: the arrays that were made in it belong to others from now on."""
        self.free = self.pages
