"""Lesson 4: what is a 95 % interval? One flight measured many times, and how often the intervals contain the truth.

The interval of a coordinate is estimate +- t s with s = sigma0 sqrt(q) and Student's t for the redundancy. Of many
such intervals 95 % contain the truth - if the model is right. The share found in n trials has the Monte-Carlo standard
error sqrt(p (1 - p) / n).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

from adjust import adjust_replicates, ap_models
from simfield import Scenario, presets
from simfield.block import Floats
from simfield.disturbances import Noise
from simfield.world import WW, Flight, Measurement, Quincunx
from studies.comparison import CONFIDENCE
from studies.lessons.adjusted import adjusted, observed, world_of
from studies.lessons.lesson import LessonError

SETS = ("none", "optical", "torlegard", "brown14")
QUANTITIES = {
    "height in the middle": ("27", "Z"),
    "height at the edge": ("23", "Z"),
    "plan in the middle": ("27", "Y"),
    "plan at the edge": ("53", "Y"),
}
"""a coordinate by what a visitor calls it: the id of its point and its name"""
MOST_TRIALS = 1000
NOISE_UM = 2.5


@dataclass(frozen=True, eq=False)
class Repeated:
    """A coordinate estimated in t trials: estimate (t) minus truth and half width of its interval (t), mm."""

    model: str
    error_mm: Floats
    half_width_mm: Floats
    sigma0: Floats

    @property
    def inside(self) -> npt.NDArray[np.bool_]:
        """(t): the intervals that contain the truth."""
        return np.asarray(np.abs(self.error_mm) <= self.half_width_mm)

    @property
    def coverage(self) -> float:
        return float(np.mean(self.inside))

    @property
    def coverage_mcse(self) -> float:
        """The Monte-Carlo standard error of the coverage."""
        return float(np.sqrt(self.coverage * (1.0 - self.coverage) / len(self.error_mm)))

    @property
    def bias_mm(self) -> float:
        return float(np.mean(self.error_mm))

    @property
    def bias_mcse_mm(self) -> float:
        return self.scatter_mm / float(np.sqrt(len(self.error_mm)))

    @property
    def scatter_mm(self) -> float:
        """The standard deviation over the trials: what the claimed one should be."""
        return float(np.std(self.error_mm, ddof=1))


def scenario() -> Scenario:
    """The wide-angle camera of 1980 with its lens and film, four strips over the central points of the groups."""
    rheidt = presets["rheidt-1980"]
    return replace(
        rheidt,
        name="interval",
        field=Quincunx(group_size=1),
        cameras=(WW,),
        flights=(Flight("flight", "ww", 10500.0, (0.0, 100.0, 200.0, 300.0)),),
        effects=tuple(on for on in rheidt.effects if on.camera == "ww"),
        noise=Noise(image_um=NOISE_UM),
        measurement=Measurement(),
    )


def repeated(model: str, quantity: str, trials: int, draw: int = 0) -> Repeated:
    """Measure the flight `trials` times and adjust each. draw counts the sets of MOST_TRIALS trials, each a new one.

    Raises LessonError for an unknown quantity, for too few or too many trials, or where the block cannot be adjusted.
    """
    if not 2 <= trials <= MOST_TRIALS:
        raise LessonError(f"{trials} trials are not allowed, take 2 to {MOST_TRIALS}")
    if quantity not in QUANTITIES:
        raise LessonError(f"there is no {quantity!r}, take {', '.join(QUANTITIES)}")
    world = world_of(scenario())
    block, chosen = observed(world), ap_models.get(model)
    nominal = adjusted(block, chosen)
    start = draw * MOST_TRIALS
    found = adjust_replicates(block, chosen, world.draws(start, start + trials))
    point, axis = QUANTITIES[quantity]
    row, column = block.points.ids.index(point), "XYZ".index(axis)
    at = nominal.layout.index(point, axis)
    true = world.field.coordinates[world.place[row], column]
    t = float(stdtrit(nominal.redundancy, 0.5 + CONFIDENCE / 2.0))
    ok = found.ok
    return Repeated(
        model,
        error_mm=1000.0 * (found.points[ok, row, column] - true),
        half_width_mm=1000.0 * t * found.std[ok, at],
        sigma0=found.sigma0[ok],
    )
