"""The compiled arithmetic where it can take all observations, else the readable one."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from adjust.arithmetic import Arithmetic
from adjust.compiled_normals import Compiled
from adjust.further import TwoImagesError
from adjust.normals import Plain
from adjust.observations import Observations

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
