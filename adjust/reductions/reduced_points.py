"""What a reduction returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simfield.block import Floats


@dataclass(frozen=True, eq=False)
class Reduced:
    """Reduced coordinates xy (k, 2) and what was removed (k, 2), mm: given = xy + removed."""

    xy: Floats
    removed: Floats

    @classmethod
    def by(cls, given: Floats, xy: Floats) -> Reduced:
        return cls(xy, given - xy)

    @property
    def rms_um(self) -> float:
        """The rms of what was removed from a coordinate, um."""
        return 1000.0 * float(np.sqrt(np.mean(self.removed**2))) if self.removed.size else 0.0
