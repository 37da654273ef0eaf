"""The cases of the paper's table, camera by field, and the sets of additional parameters it compares."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from adjust import ApModel, ap_models
from simfield import World
from simfield.block import Block, Floats, Indices

CAMERAS = {"rc8r": "RC8", "rmk-ar": "RMK-A"}
"""our ids and the paper's names"""
FIELDS = {"rheidt": "ziemann-rheidt", "jamijarvi": "ziemann-jamijarvi"}
SETS: Mapping[str, str] = {
    "none": "none",
    "b": "ebner12",
    "c": "elhakim-faig11",
    "f": "gruen12",
    "k": "koelbl-juhl9",
    "l": "mauelshagen14",
    "m": "schut14",
    "n": "salmenpera-kilpela7",
}
"""the paper's letters; set a is not known, its page is not at hand"""
OTHERS = (
    "optical",
    "torlegard",
    "brown14",
    "gruen44",
    "brown1976",
    "jacobsen12",
    "legendre",
    "fourier",
    "chebyshev",
    "zernike",
)
"""sets of the catalogue that the paper does not have"""
LEFT_OUT = {"brown1976": ("a19", "a20", "a21")}


def model_of(name: str) -> ApModel:
    """The set by its id, brown1976 without its interior orientation."""
    left_out = LEFT_OUT.get(name)
    return ap_models.get(name, without=left_out) if left_out else ap_models.get(name)


@dataclass(frozen=True)
class Case:
    """One camera over one field."""

    camera: str
    field: str

    def __str__(self) -> str:
        return f"{CAMERAS[self.camera]} at {self.field.capitalize()}"


def cases() -> list[Case]:
    """In the paper's order."""
    return [Case(camera, field) for camera in CAMERAS for field in ("jamijarvi", "rheidt")]


@dataclass(frozen=True, eq=False)
class CameraBlock:
    """The block of one camera, and where its rays (k), points (n) and images (m) stand in the world."""

    block: Block
    rays: Indices
    points: Indices
    images: Indices


def part_of(world: World, camera: str) -> CameraBlock:
    """The images of one camera, with all points that they show; approximate orientations are the true ones."""
    block, _ = world.observe(0)
    part = block.select(cameras=[camera])
    images = np.flatnonzero(np.array(world.plan.camera_ids) == camera)
    rays = np.flatnonzero(np.isin(world.image, images))
    place = {name: row for row, name in enumerate(block.points.ids)}
    return CameraBlock(part, rays, np.array([place[name] for name in part.points.ids]), images)


def residual_um(vpv: Floats, block: Block) -> Floats:
    """(t) the rms length of the residual vectors, um in the image, of t trials with weighted sums of squares vPv.

    All points are held fixed, so the residual of a ray on the ground, divided by the scale number, is its residual in
    the image; all image coordinates have one standard deviation.
    """
    sigma_um = 1000.0 * float(block.observations.sigma.min())
    return np.asarray(sigma_um * np.sqrt(vpv / len(block.observations)))
