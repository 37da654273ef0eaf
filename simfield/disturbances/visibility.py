"""What the images show: visibility is judged where a point is measured, not where an ideal camera would show it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from simfield.block import Floats, Indices
from simfield.disturbances.distortion import MOST_STEPS, DistortionError, measured_from_ideal, systematic
from simfield.disturbances.effects import EffectOn
from simfield.world import FlightPlan

GRID_POINTS = 17
"""along each axis of a format, where its distortion is looked up"""

EDGE_MARGIN = 1.02
"""for what lies between these points"""

CLEAR_MM = 1e-9
"""Half steps this small decide inside or outside; the points inside are then solved down to rounding."""


def shown(
    ideal: Floats, effects: Sequence[EffectOn], plan: FlightPlan, half_format: Floats
) -> tuple[Indices, Indices, Floats]:
    """Which points the images show: image (k), point (k), and their measured coordinates (k, 2) in mm.

    ideal (m, n, 2) are ideal image coordinates in mm, NaN for points behind the camera; half_format (m, 2) is half of
    each format, mm. What is measured inside the format is shown, wherever its ideal image lies. Raises DistortionError
    where an effect folds the image or cannot be solved, ValueError for a point beyond the end of a table.
    """
    half = _reach(effects, plan, half_format) if effects else half_format
    with np.errstate(invalid="ignore"):
        image, point = np.nonzero((np.abs(ideal) <= half[:, None, :]).all(axis=-1))
    places = ideal[image, point]
    if effects:
        bounded = _by_half_steps(places, systematic(effects, plan, image, half_format[image]))
        inside = _inside(bounded, half_format[image])
        image, point = image[inside], point[inside]
        # and once more without bounds: a table that ends too early is refused, not extended
        places = measured_from_ideal(places[inside], systematic(effects, plan, image), start=bounded[inside])
        inside = _inside(places, half_format[image])
        image, point, places = image[inside], point[inside], places[inside]
    return image, point, places


def _inside(xy_mm: Floats, half: Floats) -> npt.NDArray[np.bool_]:
    return np.asarray((np.abs(xy_mm) <= half).all(axis=1))


def _reach(effects: Sequence[EffectOn], plan: FlightPlan, half_format: Floats) -> Floats:
    """(m, 2) mm: as far out lie the ideal images of what the formats show. Raises DistortionError for a fold."""
    along = np.linspace(-1.0, 1.0, GRID_POINTS)
    grid = np.stack(np.meshgrid(along, along, indexing="ij"), axis=-1)
    image = np.repeat(np.arange(len(plan)), GRID_POINTS**2)
    measured = (half_format[:, None, None, :] * grid).reshape(-1, 2)
    displacement = systematic(effects, plan, image, half_format[image])
    ideal = (measured - displacement(measured)).reshape(len(plan), GRID_POINTS, GRID_POINTS, 2)
    # a negative format, all margin, shows nothing and folds nothing
    rising = (np.diff(ideal[..., 0], axis=1) > 0.0).all() and (np.diff(ideal[..., 1], axis=2) > 0.0).all()
    if not rising and (half_format > 0.0).all():
        raise DistortionError("an effect folds the image: the distortion is too steep inside the format")
    return np.asarray(np.maximum(EDGE_MARGIN * np.abs(ideal).max(axis=(1, 2)), half_format))


def _by_half_steps(ideal: Floats, displacement: Callable[[Floats], Floats]) -> Floats:
    """(k, 2) measured = ideal + d(measured) by half steps, which a steep barrel distortion cannot make swing."""
    measured = np.array(ideal)
    for _ in range(MOST_STEPS):
        step = 0.5 * (ideal + displacement(measured) - measured)
        measured += step
        if np.abs(step).max(initial=0.0) <= CLEAR_MM:
            return measured
    raise DistortionError("measured = ideal + d(measured) does not converge: the distortion is too steep")
