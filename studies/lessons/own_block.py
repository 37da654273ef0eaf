"""Lesson 6: fly your own block. What accuracy may be expected before anybody flies?

The cofactors Q = N^-1 need the geometry and the sigma of an image coordinate alone. The rules of thumb beside them hold
for the normal case of one stereo pair (Kraus, Photogrammetry): s the scale number, h the flying height, b the base,

    sigma_XY = s sigma,    sigma_Z = sqrt(2) (h / b) s sigma.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from adjust import ap_models
from simfield import Scenario
from simfield.block import Floats, Indices
from simfield.disturbances import Noise
from simfield.world import WW, Control, Flight, Layout, RegularGrid
from studies.comparison import root_mean_square
from studies.lessons.adjusted import adjusted, expected_std, observed, world_of
from studies.lessons.lesson import LessonError

LAYOUTS: dict[str, Layout] = {
    "none": "none",
    "four corners": "corners",
    "corners and centre": "corners-and-centre",
    "all around": "perimeter",
}
SIDE_M = 4000.0
POINTS_A_SIDE = 15
SIDELAP = 0.3
NOISE_UM = 4.0
MOST_IMAGES = 150
SCALES = (6000, 16000)


@dataclass(frozen=True, eq=False)
class Expected:
    """What may be expected: images and strips to be flown; places (n, 2) of the points in m, their standard deviations
    std_mm (n, 3), zero where held fixed, and which points are control.

    lost: points of the field that fewer than two images see; rule_xy_mm, rule_z_mm: the rules of thumb.
    """

    images: int
    strips: int
    base_m: float
    height_m: float
    exterior: Floats
    places: Floats
    std_mm: Floats
    control: npt.NDArray[np.bool_]
    rays: Indices
    lost: int
    rule_xy_mm: float
    rule_z_mm: float

    @property
    def free_mm(self) -> Floats:
        """(f, 3) standard deviations of the points that are no control."""
        return self.std_mm[~self.control]

    @property
    def rms_xy_mm(self) -> float:
        """Of one coordinate in plan."""
        return root_mean_square(self.free_mm[:, :2])

    @property
    def rms_z_mm(self) -> float:
        return root_mean_square(self.free_mm[:, 2])

    @property
    def worst_z_mm(self) -> float:
        return float(self.free_mm[:, 2].max())


def flight(scale: float, overlap: float) -> Flight:
    """A flight over the whole area, with half a base and half a strip over its edge.

    Raises LessonError where it needs more images than can be shown at once.
    """
    format_m = scale * WW.width_mm / 1000.0
    base_m, distance_m = format_m * (1.0 - overlap), format_m * (1.0 - SIDELAP)
    per_strip = int(np.ceil(SIDE_M / base_m)) + 2
    strips = max(1, int(np.ceil((SIDE_M - format_m) / distance_m)) + 1)
    if per_strip * strips > MOST_IMAGES:
        raise LessonError(
            f"{strips} strips of {per_strip} images are {per_strip * strips}, here {MOST_IMAGES} are allowed; "
            "fly higher, or with less overlap"
        )
    return Flight(
        *("block", "ww", scale, (100.0,)),
        strips=strips,
        images_per_strip=per_strip,
        forward_overlap=overlap,
        sidelap=SIDELAP,
        ground_height_m=0.0,
        position_sigma_m=scale / 1000.0,
    )


def scenario(scale: float, overlap: float, layout: str) -> Scenario:
    """The area with its control, flown at that scale number and forward overlap. Raises as `flight`."""
    return Scenario(
        name="own-block",
        field=RegularGrid(nx=POINTS_A_SIDE, ny=POINTS_A_SIDE, spacing_m=SIDE_M / (POINTS_A_SIDE - 1)),
        control=Control(LAYOUTS[layout], rest="tie"),
        cameras=(WW,),
        flights=(flight(scale, overlap),),
        # nothing is measured yet: the expectation needs no errors, only their size
        noise=Noise(image_um=0.0, assumed_um=NOISE_UM),
    )


def expected(scale: float, overlap: float, layout: str) -> Expected:
    """The accuracy to be expected. Raises LessonError where the block would not hold together, and says why."""
    flown = scenario(scale, overlap, layout)
    world = world_of(flown)
    block = observed(world)
    a = adjusted(block, ap_models.get("none"))
    one = flown.flights[0]
    base_m = scale * WW.width_mm * (1.0 - overlap) / 1000.0
    height_m = scale * WW.c_mm / 1000.0
    rule = scale * NOISE_UM / 1000.0
    return Expected(
        images=len(block.images),
        strips=one.strips,
        base_m=base_m,
        height_m=height_m,
        exterior=world.exterior,
        places=world.field.coordinates[world.place, :2],
        std_mm=1000.0 * a.layout.points(expected_std(a)),
        control=np.asarray(block.points.role == "control"),
        rays=block.rays,
        lost=len(world.field) - len(block.points),
        rule_xy_mm=rule,
        rule_z_mm=float(np.sqrt(2.0)) * height_m / base_m * rule,
    )
