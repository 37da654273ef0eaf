"""A set of additional parameters of which only some are estimated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.terms import Term
from simfield.block import Floats


@dataclass(frozen=True)
class Restricted(ApModel):
    """The parameters `keep` of another set, in that set's order; the others are 0. Not in the catalogue."""

    model: ApModel
    keep: tuple[str, ...]
    id = "restricted"
    title = "Part of another set"
    author = "this project"
    year = 2026
    source = "that of the other set"
    certainty = Certainty.CERTAIN

    def __post_init__(self) -> None:
        """Raises ValueError for names that the set does not have."""
        unknown = [name for name in self.keep if name not in self.model.parameters]
        if unknown:
            raise ValueError(
                f"{self.model.id} has no parameter {unknown[0]!r}, it has: {', '.join(self.model.parameters) or 'none'}"
            )

    @property
    def parameters(self) -> tuple[str, ...]:
        return tuple(name for name in self.model.parameters if name in self.keep)

    @property
    def linear(self) -> bool:
        return self.model.linear

    @property
    def principal_distance(self) -> str:
        return self.model.principal_distance if self.model.principal_distance in self.keep else ""

    @property
    def why_not_estimable(self) -> dict[str, str]:
        return {name: why for name, why in self.model.why_not_estimable.items() if name in self.keep}

    def evaluate(self, x: Floats, y: Floats, values: Floats) -> tuple[Floats, Floats]:
        kept = [self.model.parameters.index(name) for name in self.parameters]
        everything = np.zeros(len(self.model.parameters))
        everything[kept] = values
        d, by_values = self.model.evaluate(x, y, everything)
        return d, by_values[:, :, kept]

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        everything = zip(self.model.parameters, self.model.terms(x, y), strict=True)
        return [term for name, term in everything if name in self.keep]


def without(model: ApModel, *names: str) -> Restricted:
    """The set without these parameters. Raises ValueError for names that it does not have."""
    for name in names:
        if name not in model.parameters:
            raise ValueError(f"{model.id} has no parameter {name!r}, it has: {', '.join(model.parameters) or 'none'}")
    inner = model.model if isinstance(model, Restricted) else model
    return Restricted(inner, tuple(name for name in model.parameters if name not in names))
