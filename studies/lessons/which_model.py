"""Lesson 3: which model for which distortion? A known distortion, adjusted with five sets of additional parameters.

measured + v = projected + d(measured): what d does not describe goes into the residuals v, into the orientations and
into the points. Only the first part is seen in sigma0 = sqrt(vPv / r) and m0 = sigma0 sigma; the check points see the
rest.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from adjust import Adjustment, adjust_replicates, ap_models
from simfield import Block, Scenario, World
from simfield.block import Floats
from simfield.disturbances import (
    Decentering,
    Effect,
    EffectOn,
    FilmAffine,
    FilmPolynomial,
    Noise,
    RadialPolynomial,
    UnflatFilm,
)
from simfield.world import WW, Flight, Quincunx
from studies.comparison import VectorField, format_grid, root_mean_square
from studies.lessons.adjusted import adjusted, expected_std, observed, world_of
from studies.lessons.lesson import LessonError

SETS = ("none", "optical", "torlegard", "brown14", "ebner12")
TRUTHS: dict[str, tuple[Effect, ...]] = {
    "no distortion": (),
    "lens: radial and decentering": (RadialPolynomial(k1=-1.76e-8, k2=5.4e-13), Decentering(p1=3.0e-7, p2=-2.0e-7)),
    "film: affinity": (FilmAffine(d=8.0e-5),),
    "film: cubic": (FilmPolynomial(dx_xy2=6.5e-9, dy_x2y=-6.5e-9, dy_y3=3.25e-9),),
    "film: off its plane": (UnflatFilm(b6=2.0e-8, b8=-4.0e-8, b9=2.0e-8),),
}
HEADINGS_GON = {1: (0.0,), 4: (0.0, 100.0, 200.0, 300.0)}
NOISE_UM = 4.0
SIZE_UM = 8.0
"""quadratic mean of the distortion over the format"""
CELLS = 7
"""residuals are averaged over so many cells each way"""
TRIALS = 64
"""flights with the same geometry and other noise, so that one lucky flight does not decide"""
HALF_FORMAT_MM = 115.0


@dataclass(frozen=True, eq=False)
class Fitted:
    """What one set says and what is true, as means over TRIALS flights: m0_um, sigma0; rms of the check points' true
    errors (rms_xy_mm of one coordinate) and what the adjustment claims for it, mm. residuals: what the set leaves over
    of the distortion itself, without noise, averaged in the cells of the image.
    """

    model: str
    parameters: int
    m0_um: float
    sigma0: float
    rms_xy_mm: float
    rms_z_mm: float
    claimed_xy_mm: float
    claimed_z_mm: float
    residuals: VectorField


@dataclass(frozen=True, eq=False)
class Compared:
    """All sets on the same block, by name, and the true distortion on the grid of the format."""

    fitted: dict[str, Fitted]
    true: VectorField


def scenario(truth: str, size_um: float, headings: int) -> Scenario:
    """The wide-angle camera over Rheidt with one kind of distortion (a key of TRUTHS), size_um rms over the format."""
    return Scenario(
        name="which-model",
        field=Quincunx(group_size=3),
        cameras=(WW,),
        flights=(Flight("flight", "ww", 10500.0, HEADINGS_GON[headings]),),
        effects=tuple(EffectOn(effect, camera="ww") for effect in scaled(TRUTHS[truth], size_um)),
        noise=Noise(image_um=NOISE_UM),
    )


def scaled(effects: tuple[Effect, ...], size_um: float) -> tuple[Effect, ...]:
    """The effects with coefficients such that all together have size_um rms over the format."""
    rms = _true(effects).rms_um
    return tuple(_times(effect, size_um / rms) for effect in effects)


def compared(truth: str, size_um: float, headings: int) -> Compared:
    """The same block adjusted with every set. Raises LessonError where one of them fails."""
    flown = scenario(truth, size_um, headings)
    world = world_of(flown)
    block = observed(world)
    found = {name: _fitted(world, block, name) for name in SETS}
    return Compared(found, _true(tuple(on.effect for on in flown.effects)))


def _fitted(world: World, block: Block, name: str) -> Fitted:
    model = ap_models.get(name)
    without_noise = adjusted(block.replace_image_points(world.distorted), model)
    try:
        flights = adjust_replicates(block, model, world.draws(0, TRIALS))
    except ValueError as error:
        raise LessonError(f"this block cannot be adjusted with {name}: {error}") from error
    checks = np.asarray(block.points.role == "check")
    missed = 1000.0 * (flights.points[flights.ok] - world.field.coordinates[world.place])[:, checks]
    claimed = 1000.0 * flights.nominal.layout.points(expected_std(flights.nominal))[checks]
    sigma0 = root_mean_square(flights.sigma0[flights.ok])
    return Fitted(
        model=name,
        parameters=len(model.parameters),
        m0_um=sigma0 * flights.nominal.unit_weight_um,
        sigma0=sigma0,
        rms_xy_mm=root_mean_square(missed[:, :, :2]),
        rms_z_mm=root_mean_square(missed[:, :, 2]),
        claimed_xy_mm=sigma0 * root_mean_square(claimed[:, :2]),
        claimed_z_mm=sigma0 * root_mean_square(claimed[:, 2]),
        residuals=mean_residuals(without_noise),
    )


def mean_residuals(a: Adjustment) -> VectorField:
    """The corrections v averaged over all images in CELLS x CELLS cells of the format; cells without points are left
    out. The sign is that of an error, -v: what the measurement still contains.
    """
    xy = a.block.observations.xy
    place = np.clip(((xy + HALF_FORMAT_MM) / (2.0 * HALF_FORMAT_MM) * CELLS).astype(int), 0, CELLS - 1)
    cell = place[:, 0] * CELLS + place[:, 1]
    count = np.bincount(cell, minlength=CELLS**2)
    sums = np.column_stack([np.bincount(cell, -a.residuals[:, i], CELLS**2) for i in (0, 1)])
    middle = (np.arange(CELLS) + 0.5) / CELLS * 2.0 * HALF_FORMAT_MM - HALF_FORMAT_MM
    centres = np.stack(np.meshgrid(middle, middle, indexing="ij"), axis=-1).reshape(-1, 2)
    seen = count > 0
    return VectorField(centres[seen], 1000.0 * sums[seen] / count[seen, None])


def _true(effects: tuple[Effect, ...]) -> VectorField:
    xy = format_grid()
    d: Floats = sum((effect.displacement(xy) for effect in effects), start=np.zeros_like(xy))
    return VectorField(xy, 1000.0 * d)


def _times(effect: Any, factor: float) -> Any:
    """The effect with every coefficient multiplied; lengths such as r0_mm stay."""
    names = [f.name for f in fields(effect) if f.type in (float, "float") and not f.name.endswith("_mm")]
    return replace(effect, **{name: factor * getattr(effect, name) for name in names})
