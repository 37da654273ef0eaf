"""From effects to measured coordinates: what acts on which image point, and the solution of measured = ideal +
d(measured).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from simfield.block import Floats, Indices
from simfield.effects import EffectOn, FilmAffine, FilmPolynomial
from simfield.flights import FlightPlan
from simfield.streams import stream

SETTLED = 4.0 * float(np.finfo(np.float64).eps)
"""A step of so small a share of the largest coordinate is rounding, not distortion: 1e-13 mm on a 23 cm film."""

MOST_STEPS = 200
"""Enough for a distortion whose gradient is 0.85; film and lens of an aerial camera need five steps."""

REFERENCE_MM = 100.0


class DistortionError(ArithmeticError):
    """measured = ideal + d(measured) could not be solved."""


@dataclass(frozen=True)
class FilmVariation:
    """Film deformation that is new in every image of a camera: all affine, or all quadratic, terms in x and y.

    Every coefficient is normal; um_at_100mm is the standard deviation of one term at 100 mm.
    """

    camera: str
    terms: Literal["affine", "quadratic"]
    um_at_100mm: float

    def __post_init__(self) -> None:
        if self.um_at_100mm < 0.0:
            raise ValueError("um_at_100mm of a film variation must be >= 0")


@dataclass(frozen=True, eq=False)
class DrawnFilm:
    """The film deformation drawn for one trial: coefficients (m, 2, 5) of x, y, x^2, xy, y^2 in dx and dy of each
    image.
    """

    coefficients: Floats

    def displacement(self, xy_mm: Floats, image: Indices) -> Floats:
        """(k, 2) mm at xy (k, 2) mm in the images (k)."""
        x, y = xy_mm.T
        monomials = np.column_stack([x, y, x**2, x * y, y**2])
        return np.asarray(np.einsum("kcj,kj->kc", self.coefficients[image], monomials))

    def effects(self, plan: FlightPlan) -> tuple[EffectOn, ...]:
        """The same, image by image, without the images that have none."""
        found: list[EffectOn] = []
        for image_id, (dx, dy) in zip(plan.image_ids, self.coefficients.tolist(), strict=True):
            if any(dx[:2] + dy[:2]):
                found.append(EffectOn(FilmAffine(*dx[:2], *dy[:2]), image=image_id))
            if any(dx[2:] + dy[2:]):
                quadratic = FilmPolynomial(dx_x2=dx[2], dx_xy=dx[3], dx_y2=dx[4], dy_x2=dy[2], dy_xy=dy[3], dy_y2=dy[4])
                found.append(EffectOn(quadratic, image=image_id))
        return tuple(found)


def draw_film(film: Sequence[FilmVariation], plan: FlightPlan, seed: int, trial: int) -> DrawnFilm:
    """The film of every image in one trial."""
    coefficients = np.zeros((len(plan), 2, 5))
    for variation in film:
        columns, degree = (slice(0, 2), 1) if variation.terms == "affine" else (slice(2, 5), 2)
        sigma = variation.um_at_100mm / 1000.0 / REFERENCE_MM**degree
        for row, image_id in enumerate(plan.image_ids):
            if plan.camera_ids[row] == variation.camera:
                random = stream(seed, "film", trial, variation.terms, image_id)
                coefficients[row, :, columns] += sigma * random.standard_normal((2, columns.stop - columns.start))
    return DrawnFilm(coefficients)


def systematic(effects: Sequence[EffectOn], plan: FlightPlan, image: Indices) -> Callable[[Floats], Floats]:
    """The summed displacement of image points (k, 2) that lie in the images (k)."""
    names = list(zip(plan.camera_ids, plan.flight_ids, plan.image_ids, strict=True))
    parts = []
    for on in effects:
        acts = np.array([on.acts_on(*name) for name in names], dtype=bool)[image]
        if acts.any():
            parts.append((on.effect, slice(None) if acts.all() else np.flatnonzero(acts)))

    def displacement(xy_mm: Floats) -> Floats:
        d = np.zeros_like(xy_mm)
        for effect, rows in parts:
            d[rows] += effect.displacement(xy_mm[rows])
        return d

    return displacement


def measured_from_ideal(ideal: Floats, displacement: Callable[[Floats], Floats], start: Floats | None = None) -> Floats:
    """Solve measured = ideal + d(measured) for (k, 2) mm by fixed-point iteration, down to rounding.

    start, if given, is a guess of the measured coordinates. Raises DistortionError where d is too steep to be solved.
    """
    measured = ideal if start is None else start
    for _ in range(MOST_STEPS):
        with np.errstate(over="ignore", invalid="ignore"):
            following = ideal + displacement(measured)
            step = np.abs(following - measured).max(initial=0.0)
        measured = following
        if not np.isfinite(step):
            break
        if step <= SETTLED * np.abs(measured).max(initial=0.0):
            return measured
    raise DistortionError(
        f"measured = ideal + d(measured) does not converge (last step {step:.3g} mm): the distortion is too steep"
    )
