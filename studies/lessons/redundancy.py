"""Lesson 1: what does redundancy buy? Standard errors of a flight over Rheidt, and the arithmetic of 1980.

u = 6 m + a k + 3 p unknowns (m images, a additional parameters for each of k cameras, p points that are no control),
n = 2 i observations (i image points), redundancy r = n - u. Standard errors are those expected before the flight,
sigma sqrt(q) with the cofactors q and the a priori sigma of an image coordinate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adjust import Adjustment, ap_models
from simfield import Scenario, presets
from simfield.block import Floats
from simfield.disturbances import Noise
from simfield.world import WW, Control, Flight, GroupSize, Quincunx
from studies.comparison import root_mean_square
from studies.experiments import published
from studies.lessons.adjusted import adjusted, expected_std, observed, world_of
from studies.lessons.lesson import LessonError

HEADINGS_GON = {1: (0.0,), 2: (0.0, 100.0), 4: (0.0, 100.0, 200.0, 300.0)}
STRIPS = (1, 2, 3)
GROUP_SIZES: tuple[GroupSize, ...] = (1, 2, 3)
SCALE = 10500.0
SIDELAP = 0.6
NOISE_UM = 4.0
RADIUS_MM = 60.0
"""where the standard error of the radial distortion is given: near the crest of the curve"""
MODEL = "optical"


@dataclass(frozen=True)
class Counts:
    """The arithmetic of a block: images, cameras, additional parameters a camera, unknown points, image points."""

    images: int
    cameras: int
    parameters: int
    points: int
    image_points: int

    @property
    def unknowns(self) -> int:
        return 6 * self.images + self.parameters * self.cameras + 3 * self.points

    @property
    def observations(self) -> int:
        return 2 * self.image_points

    @property
    def redundancy(self) -> int:
        return self.observations - self.unknowns


@dataclass(frozen=True)
class Flown:
    """A flight and what may be expected of it: counts, root mean square standard errors of the points' coordinates in
    mm (std_xy_mm of one coordinate in plan), standard error in um of the radial distortion at RADIUS_MM.
    """

    strips: int
    headings: int
    group_size: int
    counts: Counts
    std_xy_mm: float
    std_z_mm: float
    std_radial_um: float


@dataclass(frozen=True)
class PublishedRow:
    """A row of Table 1 of Mauelshagen 1980: what it is, its counts, and the printed unknowns and redundancy."""

    model: str
    cameras: str
    aux_points: bool
    counts: Counts
    printed_unknowns: int
    printed_redundancy: int


def scenario(strips: int, headings: int, group_size: GroupSize) -> Scenario:
    """The wide-angle camera over the field of Rheidt: so many strips of three images at each of so many headings.

    Raises LessonError for a number of headings that has no place in a right angle.
    """
    if headings not in HEADINGS_GON:
        raise LessonError(f"{headings} headings are not foreseen; fly in 1, 2 or 4, a right angle apart")
    flight = Flight("flight", "ww", SCALE, HEADINGS_GON[headings], strips=strips, sidelap=SIDELAP)
    return Scenario(
        name="redundancy",
        field=Quincunx(group_size=group_size),
        control=Control("corners-and-centre"),
        cameras=(WW,),
        flights=(flight,),
        noise=Noise(image_um=NOISE_UM),
    )


def flown(strips: int, headings: int, group_size: GroupSize) -> Flown:
    """One flight adjusted. Raises LessonError where it cannot be."""
    block = observed(world_of(scenario(strips, headings, group_size)))
    model = ap_models.get(MODEL)
    a = adjusted(block, model)
    free = np.asarray(block.points.role != "control")
    points = 1000.0 * a.layout.points(expected_std(a))[free]
    counts = Counts(len(block.images), 1, len(model.parameters), int(free.sum()), len(block.observations))
    return Flown(
        *(strips, headings, group_size, counts),
        std_xy_mm=root_mean_square(points[:, :2]),
        std_z_mm=root_mean_square(points[:, 2]),
        std_radial_um=_std_radial_um(a),
    )


def alternatives(strips: int) -> list[Flown]:
    """All flights with that many strips, over headings and points a group."""
    return [flown(strips, headings, size) for headings in HEADINGS_GON for size in GROUP_SIZES]


def table1() -> list[PublishedRow]:
    """The 18 rows of Table 1, counted anew from images, parameters and image points."""
    measured = presets["rheidt-1980"].measurement.counts
    rows = []
    for row in published.mauelshagen_table1().to_dict("records"):
        cameras = str(row["block"]).split("+")
        aux = bool(row["aux_points"])
        counts = Counts(
            images=int(row["images"]),
            cameras=len(cameras),
            parameters=len(ap_models.get(str(row["model"])).parameters),
            points=118 if aux else 35,
            image_points=sum(measured[c].total if aux else measured[c].main for c in cameras),
        )
        name = str(row["model"])
        rows.append(PublishedRow(name, str(row["block"]), aux, counts, int(row["unknowns"]), int(row["redundancy"])))
    return rows


def _std_radial_um(a: Adjustment) -> float:
    """The a priori standard error of x (a3 (r^2 - r0^2) + a4 (r^4 - r0^4)) at RADIUS_MM."""
    model = ap_models.get(MODEL)
    columns = [model.parameters.index(name) for name in ("a3", "a4")]
    term: Floats = model.basis(np.array([RADIUS_MM]), np.zeros(1))[0, 0, columns]
    covariance = a.covariance(("ww", "a3"), ("ww", "a4")) / a.sigma0**2
    return 1000.0 * float(np.sqrt(term @ covariance @ term))
