"""Lesson 5: can you hide a gross error? One image coordinate is falsified, and the adjustment looks for it.

With r the redundancy number of the observation and sigma its standard deviation (Baarda 1968): w = v / (sigma sqrt(r))
is N(0, 1) without gross errors; an error g moves w by g sqrt(r) / sigma, and is found at the level alpha with the power
1 - beta from g = delta0 sigma / sqrt(r) on, the minimal detectable bias.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from adjust import Adjustment, ap_models
from adjust.quality import ALPHA, POWER, Reliability, noncentrality, snoop, w_critical
from simfield import Block, Scenario
from simfield.block import Floats
from simfield.disturbances import Noise
from simfield.world import WW, Control, Flight, RegularGrid
from studies.lessons.adjusted import adjusted, observed, world_of
from studies.lessons.lesson import LessonError

MODEL = "optical"
NOISE_UM = 4.0
SIZE_MOST_UM = 100.0
RAYS = {"seen in 2 images": 2, "seen in 3 images": 3, "seen in 6 images": 6}
"""the places that a visitor may choose, by the number of images that see the point"""
ALONG, ACROSS = "x, along the flight", "y, across the flight"
AXES = (ALONG, ACROSS)
CRITICAL = w_critical(ALPHA)
DELTA0 = noncentrality(ALPHA, POWER)


@dataclass(frozen=True, eq=False)
class Planted:
    """A falsified coordinate and what became of it.

    row: its place among the observations (x, y, x, y, ...); w (n) of all image coordinates; redundancy its redundancy
    number; mdb_um its minimal detectable bias; estimated_um the error that the adjustment estimates for it; accused the
    rows taken out by data snooping, in this order, with their names; rays the number of images that see the point;
    shift_mm (3) what the error does to the point if it stays, std_mm (3) the point's a priori standard deviations.
    """

    name: str
    row: int
    size_um: float
    w: Floats
    redundancy: float
    mdb_um: float
    estimated_um: float
    accused: tuple[int, ...]
    accused_names: tuple[str, ...]
    rays: int
    shift_mm: Floats
    std_mm: Floats

    @property
    def found(self) -> bool:
        """Whether data snooping took out the falsified coordinate."""
        return self.row in self.accused

    def power(self, size_um: Floats | float) -> Floats:
        """The probability that an error of this size makes |w| exceed the critical value; both tails."""
        shift = np.asarray(size_um) * np.sqrt(self.redundancy) / NOISE_UM
        return np.asarray(ndtr(shift - CRITICAL) + ndtr(-shift - CRITICAL))


def scenario() -> Scenario:
    """Three strips of four wide-angle images, 169 points of which five are control: a block as it is flown "
    "every day."""
    return Scenario(
        name="gross-error",
        field=RegularGrid(nx=13, ny=13, spacing_m=320.0),
        control=Control("corners-and-centre", rest="tie"),
        cameras=(WW,),
        flights=(Flight("block", "ww", 10000.0, headings_gon=(100.0,), strips=3, images_per_strip=4),),
        noise=Noise(image_um=NOISE_UM),
    )


def planted(place: str, axis: str, size_um: float) -> Planted:
    """Falsify one coordinate (place a key of RAYS, axis one of AXES) by size_um and search for it.

    Raises LessonError for a place, an axis or a size that there is not.
    """
    if place not in RAYS or axis not in AXES:
        raise LessonError(f"there is no coordinate {axis!r} of a point {place!r}")
    if not abs(size_um) <= SIZE_MOST_UM:
        raise LessonError(f"an error of {size_um:g} um would be seen by the eye, take at most {SIZE_MOST_UM:g} um")
    block = observed(world_of(scenario()))
    observation, component = _observation(block, RAYS[place]), AXES.index(axis)
    xy = block.observations.xy.copy()
    xy[observation, component] += size_um / 1000.0
    model = ap_models.get(MODEL)
    clean, a = adjusted(block, model), adjusted(block.replace_image_points(xy), model)
    row, point = 2 * observation + component, int(block.observations.point[observation])
    return _judged(clean, a, row, point, size_um)


def _judged(clean: Adjustment, a: Adjustment, row: int, point: int, size_um: float) -> Planted:
    reliability, search = Reliability.of(a), snoop(a)
    return Planted(
        name=reliability.name(row),
        row=row,
        size_um=size_um,
        w=reliability.w[reliability.image_points],
        redundancy=float(reliability.redundancy[row]),
        mdb_um=1000.0 * float(reliability.mdb[row]),
        estimated_um=1000.0 * float(reliability.estimated_error[row]),
        accused=tuple(each.row for each in search.accused),
        accused_names=tuple(each.name for each in search.accused),
        rays=int(a.block.rays[point]),
        shift_mm=1000.0 * (a.coordinates - clean.coordinates)[point],
        std_mm=1000.0 * np.sqrt(np.diag(a.cofactors.points[point])),
    )


def _observation(block: Block, rays: int) -> int:
    """The image point with that many rays that lies nearest to the middle of its image; control is left out."""
    o = block.observations
    possible = (block.rays[o.point] == rays) & (block.points.role[o.point] != "control")
    radius = np.where(possible, np.hypot(*o.xy.T), np.inf)
    if not np.isfinite(radius.min()):
        raise LessonError(f"no point of this block is seen in {rays} images")
    return int(np.argmin(radius))
