"""Prior values of additional parameters: what a calibration knew, with its standard deviations.

Weighted parameters cannot run away where the block does not determine them: a cure for over-parametrisation that is
milder than leaving them out. A prior of 0 says that a parameter is not expected.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from adjust.model import Unknowns
from adjust.observations.group import Linear, Name
from simfield.block import Block, Floats, Indices


@dataclass(frozen=True)
class ApPriors:
    """Of one camera: (value, standard deviation) by the parameter's name, both in the parameter's unit."""

    camera_id: str
    values: Mapping[str, tuple[float, float]]

    @property
    def ties_datum(self) -> bool:
        return False

    @property
    def coupled(self) -> tuple[str, ...]:
        return ()

    def restricted(self, names: Collection[Name]) -> ApPriors:
        """Without the priors of parameters that are not among the names (camera, parameter)."""
        kept = {name: both for name, both in self.values.items() if (self.camera_id, name) in names}
        return ApPriors(self.camera_id, kept)

    def unknowns(self, block: Block) -> tuple[Name, ...]:
        """None. Raises ValueError for a standard deviation that is not positive."""
        for name, (value, sigma) in self.values.items():
            if not (np.isfinite(value) and np.isfinite(sigma) and sigma > 0.0):
                raise ValueError(f"prior of {name} of camera {self.camera_id}: {value:g} +- {sigma:g} is not allowed")
        return ()

    def bind(self, layout: Unknowns) -> BoundPriors:
        """Raises KeyError for a parameter that is not estimated."""
        columns = np.array([layout.index(self.camera_id, name) for name in self.values], dtype=np.intp)
        both = np.array(list(self.values.values()), dtype=float).reshape(-1, 2)
        labels = tuple(f"prior of {name} of camera {self.camera_id}" for name in self.values)
        return BoundPriors(f"priors of {self.camera_id}", both[:, 0], 1.0 / both[:, 1] ** 2, columns, labels)


@dataclass(frozen=True, eq=False)
class BoundPriors:
    """See adjust.observations.group.Bound."""

    name: str
    given: Floats
    weight: Floats
    columns: Indices
    labels: tuple[str, ...]

    def at(self, x: Floats) -> Linear:
        return Linear(x[self.columns] - self.given, self.columns[:, None], np.ones((len(self.columns), 1)))

    def with_weight(self, weight: Floats) -> BoundPriors:
        return replace(self, weight=weight)
