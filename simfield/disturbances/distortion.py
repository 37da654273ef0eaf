"""From effects to measured coordinates: what acts on which image point, and the solution of measured = ideal +
d(measured).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from simfield.block import Floats, Indices
from simfield.disturbances.effects import Effect, EffectOn
from simfield.world import FlightPlan

SETTLED = 4.0 * float(np.finfo(np.float64).eps)
"""A step of so small a share of the largest coordinate is rounding, not distortion: 1e-13 mm on a 23 cm film."""


MOST_STEPS = 200
"""Enough for a distortion whose gradient is 0.85; film and lens of an aerial camera need five steps."""


class DistortionError(ArithmeticError):
    """measured = ideal + d(measured) could not be solved."""


def systematic(
    effects: Sequence[EffectOn], plan: FlightPlan, image: Indices, half: Floats | None = None
) -> Callable[[Floats], Floats]:
    """The summed displacement of image points (k, 2) that lie in the images (k).

    half (k, 2) mm, where given, is the half format: outside, and beyond the end of a table, the displacement is the one
    at the edge, so that no polynomial runs wild where nobody looks.
    """
    names = list(zip(plan.camera_ids, plan.flight_ids, plan.image_ids, strict=True))
    parts: list[tuple[Effect, slice | Indices]] = []
    for on in effects:
        acts = np.array([on.acts_on(*name) for name in names], dtype=bool)[image]
        if acts.any():
            parts.append((on.effect, slice(None) if acts.all() else np.flatnonzero(acts)))

    return _Sum(tuple(parts), half)


@dataclass(frozen=True, eq=False)
class _Sum:
    """Effects with the rows that they act on, summed; a class, so that it can travel to another process."""

    parts: tuple[tuple[Effect, slice | Indices], ...]
    half: Floats | None = None

    def __call__(self, xy_mm: Floats) -> Floats:
        xy_mm = xy_mm if self.half is None else np.clip(xy_mm, -self.half, self.half)
        d = np.zeros_like(xy_mm)
        for effect, rows in self.parts:
            at = xy_mm[rows]
            if self.half is not None:
                at = _within_radius(at, getattr(effect, "reach_mm", np.inf))
            d[rows] += effect.displacement(at)
        return d


def _within_radius(xy_mm: Floats, reach_mm: float) -> Floats:
    """(n, 2): places farther out than reach_mm, drawn in to it."""
    r = np.hypot(xy_mm[:, 0], xy_mm[:, 1])
    if not (r > reach_mm).any():
        return xy_mm
    # a hair inside, so that rounding leaves no place beyond
    return np.asarray(xy_mm * np.where(r > reach_mm, (1.0 - 1e-12) * reach_mm / np.maximum(r, reach_mm), 1.0)[:, None])


def measured_from_ideal(ideal: Floats, displacement: Callable[[Floats], Floats], start: Floats | None = None) -> Floats:
    """Solve measured = ideal + d(measured) for (k, 2) mm by fixed-point iteration, down to rounding.

    Where whole steps swing, as under a steep barrel distortion, half steps follow. start, if given, is a guess of the
    measured coordinates. Raises DistortionError where d is too steep to be solved.
    """
    for share in (1.0, 0.5):
        measured = ideal if start is None else start
        for _ in range(MOST_STEPS):
            with np.errstate(over="ignore", invalid="ignore"):
                following = measured + share * (ideal + displacement(measured) - measured)
                step = np.abs(following - measured).max(initial=0.0)
            measured = following
            if not np.isfinite(step):
                break
            if step <= SETTLED * np.abs(measured).max(initial=0.0):
                return measured
    raise DistortionError(
        f"measured = ideal + d(measured) does not converge (last step {step:.3g} mm): the distortion is too steep"
    )
