"""Solved trials of one geometry: estimates, vPv, and how each ended."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from adjust.status import Status
from simfield.block import Floats

STATUSES = tuple(Status)
CHORD, GAUSS_NEWTON = 0, 1
"""routes by which a trial can be solved"""


@dataclass(frozen=True, eq=False)
class SolvedTrials:
    """Solved trials: x (t, size), vPv (t), status (t) indices into STATUSES, iterations (t), route (t).

    cofactors (t, size): the cofactor of every unknown in every trial, None where nobody asked for them.
    """

    x: Floats
    vpv: Floats
    status: npt.NDArray[np.int8]
    iterations: npt.NDArray[np.int16]
    route: npt.NDArray[np.int8]
    cofactors: Floats | None = None

    @classmethod
    def empty(cls, count: int, size: int, with_cofactors: bool) -> SolvedTrials:
        """Room for `count` trials of `size` unknowns."""
        cofactors = np.full((count, size), np.nan) if with_cofactors else None
        x, vpv, status = np.empty((count, size)), np.empty(count), np.empty(count, "i1")
        return cls(x, vpv, status, np.empty(count, "i2"), np.empty(count, "i1"), cofactors)

    def part(self, trials: slice) -> SolvedTrials:
        """Some of the trials, as views."""
        return SolvedTrials(*(None if a is None else a[trials] for a in self._arrays()))  # type: ignore[arg-type]

    @classmethod
    def joined(cls, parts: list[SolvedTrials]) -> SolvedTrials:
        """Parts, at least one, in a row."""
        arrays = zip(*(part._arrays() for part in parts), strict=True)
        return cls(*(None if a[0] is None else np.concatenate(a) for a in arrays))  # type: ignore[arg-type]

    def _arrays(self) -> tuple[npt.NDArray[Any] | None, ...]:
        return self.x, self.vpv, self.status, self.iterations, self.route, self.cofactors
