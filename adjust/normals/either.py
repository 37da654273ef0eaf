"""The compiled arithmetic where it can take all observations, else the readable one."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from adjust.normals.arithmetic import Arithmetic
from adjust.normals.normals import Plain
from adjust.normals.normals_compiled import Compiled
from adjust.observations import Observations, TwoImagesError

Answer = TypeVar("Answer")


def by_either(groups: Observations, compiled: bool, work: Callable[[Arithmetic], Answer]) -> Answer:
    """What `work` makes of the compiled arithmetic, or of the readable one if that is wanted or needed.

    Whether an observation touches two images may hang on where it is evaluated, so it is tried and not foretold.
    """
    if compiled:
        try:
            return work(Compiled(groups))
        except TwoImagesError:
            pass
    return work(Plain(groups))
