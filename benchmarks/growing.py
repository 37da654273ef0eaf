"""Blocks of any size for the scaling: regular flights over a growing field, 60 % forward and 30 % side overlap.

About 85 image points an image, as in the block of 39 images; tie points on a disturbed grid; control points at a
constant density. All arrays, no loop over images: 2500 images take less than a second.
"""

from __future__ import annotations

import numpy as np

from adjust.model import project
from simfield.block import Block, Camera, Floats, ImageObservations, Images, Indices, Points

SIZES = {39: (3, 13), 156: (12, 13), 624: (24, 26), 2500: (50, 50)}
"""images: strips, images a strip"""
WIDE = Camera("wide", 153.0, 0.0, 0.0, 230.0, 230.0)
HEIGHT_M, RELIEF_M = 1530.0, 30.0
FORMAT_M = 230.0 * HEIGHT_M / 153.0
BASE_M, STRIP_M = 0.4 * FORMAT_M, 0.7 * FORMAT_M
SPACING_M = FORMAT_M / 10.0
"""of tie points; an image shows the 9 x 9 to 10 x 10 of them that lie inside its format"""
CONTROL_EVERY = 7
"""a control point at every such grid point in both directions: one strip distance, not quite two bases apart, so that
small and large blocks take the same number of iterations"""
NOISE_MM, MARGIN_MM = 0.005, 5.0
START_M, START_RAD = 10.0, 0.01


def growing_block(images: int, seed: int = 1) -> Block:
    """The block of `images` images, noise 5 um, start values off by 10 m and 0.6 degrees. Raises KeyError by size."""
    strips, per_strip = SIZES[images]
    random = np.random.default_rng([seed, images])
    exterior = _exterior(strips, per_strip, random)
    grid, columns = _grid(strips, per_strip, random)
    image, point = _candidates(exterior, columns, len(grid))
    xy, _ = project(exterior, np.tile([WIDE.c_mm, 0.0, 0.0], (images, 1)), grid[point], image)
    inside = (np.abs(xy) < WIDE.width_mm / 2.0 - MARGIN_MM).all(axis=1)
    image, point, xy = image[inside], point[inside], xy[inside]
    rows, across = np.divmod(np.arange(len(grid)), columns)
    control = (rows % CONTROL_EVERY == 0) & (across % CONTROL_EVERY == 0)
    used = np.bincount(point, minlength=len(grid)) >= 2
    kept = used[point]
    measured = xy[kept] + NOISE_MM * random.standard_normal((int(kept.sum()), 2))
    moved = random.standard_normal((images, 6)) * ([START_M] * 3 + [START_RAD] * 3)
    return Block(
        (WIDE,),
        Images(tuple(f"i{i}" for i in range(images)), np.zeros(images, dtype=np.intp), exterior + moved),
        _points(grid[used], control[used]),
        ImageObservations(
            image[kept], (np.cumsum(used) - 1)[point[kept]], measured, np.full((len(measured), 2), NOISE_MM)
        ),
    )


def _exterior(strips: int, per_strip: int, random: np.random.Generator) -> Floats:
    """Strips flown to and fro, one after the other, with the deviations of a piloted aircraft."""
    strip, number = np.divmod(np.arange(strips * per_strip), per_strip)
    back = strip % 2 == 1
    along = np.where(back, per_strip - 1 - number, number) * BASE_M
    nominal = np.column_stack([along, strip * STRIP_M, np.full(len(strip), HEIGHT_M)])
    attitude = np.column_stack([np.zeros((len(strip), 2)), np.where(back, np.pi, 0.0)])
    deviation = random.standard_normal((len(strip), 6)) * [20.0, 20.0, 20.0, 0.01, 0.01, 0.02]
    return np.column_stack([nominal, attitude]) + deviation


def _grid(strips: int, per_strip: int, random: np.random.Generator) -> tuple[Floats, int]:
    """Points by rows over all that is photographed, and the number of columns."""
    reach = FORMAT_M / 2.0
    x = np.arange(-reach, (per_strip - 1) * BASE_M + reach + SPACING_M, SPACING_M)
    y = np.arange(-reach, (strips - 1) * STRIP_M + reach + SPACING_M, SPACING_M)
    places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    places = places + random.uniform(-0.2, 0.2, places.shape) * SPACING_M
    return np.column_stack([places, RELIEF_M * random.standard_normal(len(places))]), len(x)


def _candidates(exterior: Floats, columns: int, count: int) -> tuple[Indices, Indices]:
    """Pairs of image and grid point near enough to be seen, sorted by image."""
    half = 8
    offset = np.arange(-half, half + 1)
    middle = np.rint((exterior[:, :2] + FORMAT_M / 2.0) / SPACING_M).astype(np.intp)
    column = (middle[:, 0, None, None] + offset[None, None, :]).astype(np.intp)
    row = (middle[:, 1, None, None] + offset[None, :, None]).astype(np.intp)
    column, row = np.broadcast_arrays(column, row)
    exists = (column >= 0) & (column < columns) & (row >= 0) & (row < count // columns)
    image = np.broadcast_to(np.arange(len(exterior))[:, None, None], exists.shape)
    return image[exists], (row * columns + column)[exists]


def _points(coordinates: Floats, control: np.ndarray) -> Points:
    given = np.where(control[:, None], coordinates, np.nan)
    return Points(
        tuple(f"p{i}" for i in range(len(coordinates))),
        np.where(control, "control", "tie"),
        given,
        np.where(control[:, None], 0.0, np.nan) * np.ones(3),
    )
