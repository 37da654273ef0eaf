"""What a set of additional parameters (AP) is: a declaration of terms.

Convention: measured + v = projected + d(measured). d is the distortion contained in the measurement, evaluated at the
measured image coordinates x (flight direction) and y in mm. Every set is linear in its parameters, so the matrix of its
terms (its basis) is also its Jacobian.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, ClassVar

import numpy as np

from simfield.block import Floats

Term = tuple[Any, Any]
"""One parameter's (dx, dy): arrays of the shape of x, or a plain 0."""


class Certainty(StrEnum):
    """How sure the formula of a set is."""

    CERTAIN = "certain"
    READING = "reading"
    RECONSTRUCTION = "reconstruction"
    MEMORY = "memory"


@dataclass(frozen=True)
class ApModel:
    """A set of additional parameters, declared by its terms.

    A subclass is a frozen dataclass. Its fields are the settings, with the unit in the name and
    metadata={"about": ...}; its class variables say what it is and where it comes from; `terms` lists one (dx, dy) for
    each parameter, as literally as the source prints it. `parameters` names them.
    """

    id: ClassVar[str]
    title: ClassVar[str]
    author: ClassVar[str]
    year: ClassVar[int]
    source: ClassVar[str]
    certainty: ClassVar[Certainty]
    formula: ClassVar[str] = ""
    """the terms in plain text, as `simfield models ID` prints them"""

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names of the parameters, in the order of the terms."""
        raise NotImplementedError

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        """The terms at x, y (k), mm: one (dx, dy) a parameter, in mm per unit of the parameter."""
        raise NotImplementedError

    def basis(self, x_mm: Floats, y_mm: Floats) -> Floats:
        """All terms as one array (k, 2, a) at image coordinates x_mm, y_mm (k)."""
        x, y = np.broadcast_arrays(np.asarray(x_mm, float), np.asarray(y_mm, float))
        basis = np.zeros((x.size, 2, len(self.parameters)))
        for j, (dx, dy) in enumerate(self.terms(x.ravel(), y.ravel())):
            basis[:, 0, j] = dx
            basis[:, 1, j] = dy
        return basis

    @property
    def settings(self) -> dict[str, Any]:
        """The settings by name, as given."""
        return {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}

    def __post_init__(self) -> None:
        for name, value in self.settings.items():
            if isinstance(value, float | int) and not isinstance(value, bool) and not np.isfinite(value):
                raise ValueError(f"{self.id}: {name} = {value} is not allowed, it must be finite")


def numbered(letter: str, count: int, start: int = 1) -> tuple[str, ...]:
    """Parameter names such as b1 .. b14."""
    return tuple(f"{letter}{i}" for i in range(start, start + count))
