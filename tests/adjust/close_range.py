"""Close-range calibration blocks with a known truth, made without the product's simulator and without its formulas.

Some twenty convergent images of a flat sheet, taken from all around with every attitude; four corners of the sheet are
fixed control. The lens follows Brown's equations about the true principal point. Radians, metres, millimetres.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from simfield.block.block import Block, Camera, Floats, ImageObservations, Images, Points
from tests.synthetic import rotation

NOMINAL = Camera("slr", 50.0, 0.05, -0.03, 36.0, 24.0)
LENS = {
    "dc": 0.5, "xp": 0.21, "yp": -0.14, "K1": 2.1e-5, "K2": -1.3e-8, "K3": 4.0e-12, "P1": 3.0e-6, "P2": -2.0e-6,
    "B1": 1.5e-4, "B2": -0.8e-4,
}  # fmt: skip
DISTANCE_M = 2.0
SHEET = [(0.1 * i, 0.1 * j, 0.0) for j in range(-4, 5) for i in range(-5, 6)]
CORNERS = (0, 10, 88, 98)


@dataclass(frozen=True, eq=False)
class CloseRange:
    """The block handed over, and what nobody tells the adjustment."""

    block: Block
    exterior: Floats
    coordinates: Floats
    lens: Mapping[str, float]


def measured(exterior: Floats, point: tuple[float, float, float], lens: Mapping[str, float]) -> tuple[float, float]:
    """The image point that Brown's corrections lead back to the collinear one, by fixed-point iteration."""
    r = rotation(*exterior[3:])
    d = [point[i] - exterior[i] for i in range(3)]
    u, v, w = (sum(r[i][j] * d[i] for i in range(3)) for j in range(3))
    c = NOMINAL.c_mm + lens["dc"]
    ideal_x, ideal_y = -c * u / w, -c * v / w
    x, y = ideal_x, ideal_y
    for _ in range(60):
        r2 = x * x + y * y
        g = lens["K1"] * r2 + lens["K2"] * r2**2 + lens["K3"] * r2**3
        to_x = x * g + lens["P1"] * (r2 + 2 * x * x) + 2 * lens["P2"] * x * y + lens["B1"] * x + lens["B2"] * y
        to_y = y * g + lens["P2"] * (r2 + 2 * y * y) + 2 * lens["P1"] * x * y
        x, y = ideal_x - to_x, ideal_y - to_y
    return NOMINAL.x0_mm + lens["xp"] + x, NOMINAL.y0_mm + lens["yp"] + y


def station(rng: np.random.Generator, number: int) -> Floats:
    """(6) a camera about 2 m from the sheet that looks at it from 10 to 55 degrees off the vertical, turned at will."""
    azimuth = 2.0 * math.pi * (number + rng.uniform(-0.3, 0.3)) / 20.0
    off = math.radians(rng.uniform(35.0, 55.0) if number % 2 else rng.uniform(10.0, 40.0))
    direction = np.array([math.sin(off) * math.cos(azimuth), math.sin(off) * math.sin(azimuth), math.cos(off)])
    place = DISTANCE_M * rng.uniform(0.9, 1.15) * direction + np.append(rng.uniform(-0.03, 0.03, 2), 0.0)
    z = place / np.linalg.norm(place)  # the camera looks along -z at the middle of the sheet
    omega, phi = math.atan2(-z[1], z[2]), math.asin(z[0])
    kappa = math.pi * (1.0 + rng.uniform(-0.01, 0.01)) if number % 4 == 0 else rng.uniform(-math.pi, math.pi)
    return np.array([*place, omega, phi, kappa])


def close_range(seed: int, noise_um: float = 0.0, sigma_um: float = 0.5, images: int = 20) -> CloseRange:
    """The block of a seed: start orientations good to 2 degrees and 0.1 m, the principal distance wrong by 1 %."""
    rng = np.random.default_rng(seed)
    exterior = np.array([station(rng, number) for number in range(images)])
    rows = []
    for image in range(images):
        for point, place in enumerate(SHEET):
            x, y = measured(exterior[image], place, LENS)
            if abs(x) < 18.0 and abs(y) < 12.0:
                rows.append((image, point, x, y))
    table = np.array(rows)
    image, point = table[:, 0].astype(int), table[:, 1].astype(int)
    xy = table[:, 2:] + noise_um / 1000.0 * rng.standard_normal((len(table), 2))
    start = exterior + np.repeat([0.1, math.radians(2.0)], 3) * rng.standard_normal(exterior.shape)
    coordinates = np.array(SHEET)
    control = np.isin(np.arange(len(SHEET)), CORNERS)
    points = Points(
        tuple(f"p{i}" for i in range(len(SHEET))),
        np.where(control, "control", "tie"),
        np.where(control[:, None], coordinates, np.nan),
        np.where(control[:, None], np.zeros(3), np.nan),
    )
    block = Block(
        (NOMINAL,),
        Images(tuple(f"i{i}" for i in range(images)), np.zeros(images, dtype=int), start),
        points,
        ImageObservations(image, point, xy, np.full(xy.shape, sigma_um / 1000.0)),
    )
    return CloseRange(block, exterior, coordinates, LENS)
