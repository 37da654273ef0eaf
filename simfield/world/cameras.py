"""Named cameras, each with the source of its numbers.

A CameraModel is what the simulator flies; `as_block_camera` is what a surveyor is told about it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from simfield.block import Camera


@dataclass(frozen=True)
class CameraModel:
    """A frame camera: principal distance c, principal point (x0, y0) in the fiducial frame, film format; all in mm."""

    camera_id: str
    c_mm: float
    x0_mm: float = 0.0
    y0_mm: float = 0.0
    width_mm: float = 230.0
    height_mm: float = 230.0
    name: str = ""
    source: str = ""

    def __post_init__(self) -> None:
        if not self.camera_id or self.camera_id != self.camera_id.strip():
            raise ValueError(f"camera_id {self.camera_id!r} is not an id (a text without blanks at its ends)")
        if min(self.c_mm, self.width_mm, self.height_mm) <= 0.0:
            raise ValueError(f"camera {self.camera_id!r}: c_mm, width_mm and height_mm must be > 0")

    def as_block_camera(self) -> Camera:
        """The camera as the block carries it."""
        return Camera(self.camera_id, self.c_mm, self.x0_mm, self.y0_mm, self.width_mm, self.height_mm)


WW = CameraModel(
    "ww",
    c_mm=153.0,
    name="Zeiss RMK A 15/23, Pleogon A, wide angle",
    source="c about 153 mm and 23 cm x 23 cm film: Mauelshagen 1980; the calibrated c is not known",
)

SWW = CameraModel(
    "sww",
    c_mm=85.5,
    name="Zeiss RMK A 8.5/23, S-Pleogon A, super-wide angle (the paper's UeWW)",
    source="c about 85.5 mm and 23 cm x 23 cm film: Mauelshagen 1980; other accounts have 85.2 mm",
)

RC8R = CameraModel(
    "rc8r",
    c_mm=152.0,
    name="Wild RC8R, wide angle with reseau",
    source="camera and format: Ziemann and El-Hakim 1982; c is the nominal 152 mm of the Aviogon (assumption)",
)

RMK_AR = CameraModel(
    "rmk-ar",
    c_mm=153.0,
    name="Zeiss RMK-AR 15/23, wide angle with reseau",
    source="camera and format: Ziemann and El-Hakim 1982; c is the nominal 153 mm of the RMK 15/23 (assumption)",
)

cameras: Mapping[str, CameraModel] = MappingProxyType({c.camera_id: c for c in (WW, SWW, RC8R, RMK_AR)})
"""The named cameras by their id."""
