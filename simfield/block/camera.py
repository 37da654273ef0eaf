"""The camera of an image: its interior orientation, as a block knows it."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real

from simfield.block.checks import BlockError


@dataclass(frozen=True)
class Camera:
    """A frame camera with known interior orientation.

    c_mm is the principal distance, (x0_mm, y0_mm) the principal point in the fiducial frame, width_mm and height_mm
    the format. Whole numbers become floats. Raises BlockError for what is no number.
    """

    camera_id: str
    c_mm: float
    x0_mm: float
    y0_mm: float
    width_mm: float
    height_mm: float

    def __post_init__(self) -> None:
        for name in ("c_mm", "x0_mm", "y0_mm", "width_mm", "height_mm"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, Real):
                raise BlockError("cameras", f"{value!r} is not a number", column=name)
            object.__setattr__(self, name, float(value))
