"""The 18 adjustments of the paper's Table 1 and the six blocks they are made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adjust import Adjustment, ApModel, adjust_block, ap_models
from simfield import Truth
from simfield.block import Block
from studies.experiments import published
from studies.experiments.reproduction import ReproductionError

SECTIONS = {"optical": "3.1", "torlegard": "3.2", "brown14": "3.3"}
"""the section of the paper that gives each model"""
CAMERA_TITLES = {"sww": "SWW, RMK A 8.5/23", "ww": "WW, RMK A 15/23"}
CAMERAS = tuple(CAMERA_TITLES)
BOTH = "sww+ww"


@dataclass(frozen=True)
class Row:
    """A row of Table 1: the AP model, the cameras of the block (joined by +), without or with auxiliary points."""

    model: str
    block: str
    aux_points: bool

    def __str__(self) -> str:
        return f"{self.model}, {self.block}, {'with' if self.aux_points else 'without'} auxiliary points"


def rows() -> list[Row]:
    """The rows of Table 1 in the paper's order."""
    table = published.mauelshagen_table1()
    names = table[["model", "block", "aux_points"]].to_numpy().tolist()
    return [Row(str(model), str(block), bool(aux_points)) for model, block, aux_points in names]


def sub_block(block: Block, truth: Truth, name: str, aux_points: bool) -> Block:
    """The part of the block that a row adjusts."""
    cameras = None if name == BOTH else name.split("+")
    return block.select(cameras=cameras, points=None if aux_points else truth.main_points)


def adjusted(block: Block, model: ApModel | str) -> Adjustment:
    """The adjustment. Raises ReproductionError where it fails."""
    chosen = ap_models.get(model) if isinstance(model, str) else model
    a = adjust_block(block, chosen)
    if not a.status.ok:
        raise ReproductionError(f"the adjustment with {chosen.id} failed: {a.message}")
    return a


def middle_images(truth: Truth, camera: str) -> tuple[str, ...]:
    """The middle image of every strip of a camera, the paper's "Vollbild": the one nearest to the field's centre."""
    centre = 0.5 * (truth.coordinates[:, :2].min(axis=0) + truth.coordinates[:, :2].max(axis=0))
    distance = np.hypot(*(truth.exterior[:, :2] - centre).T)
    nearest: dict[str, int] = {}
    for image, strip in enumerate(truth.strip_ids):
        if truth.camera_ids[image] == camera and (strip not in nearest or distance[image] < distance[nearest[strip]]):
            nearest[strip] = image
    return tuple(truth.image_ids[image] for image in nearest.values())
