"""Many flights over one geometry: every set at every level of reseau correction, for one camera over one field.

The paper's strategy: correct the image deformation by the reseau, then either self-calibrate at once (its table, "no
lens-distortion correction") or first determine and remove what all images of the camera have in common.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from adjust import adjust_replicates
from adjust.trials import Replicates
from simfield import World
from simfield.block import Floats
from studies.experiments.reproduction import ReproductionError
from studies.experiments.ziemann_1982.experiment import (
    OTHERS,
    SETS,
    CameraBlock,
    Case,
    model_of,
    part_of,
    residual_um,
)
from studies.experiments.ziemann_1982.reseau import LEVELS, LocalFilm, corrected, measured_crosses

CELL_MM = 23.0
"""side of the cells of the format within which the system's distortion is averaged: 10 x 10 of them"""
LEAST_IN_CELL = 3


ENDS = (min(LEVELS), max(LEVELS))
"""the levels at which the system's distortion is removed"""


def run_case(world: World, case: Case, trials: int) -> pd.DataFrame:
    """All flights of a camera over a field: camera, field, level, system, model, trial, rms_um, failure.

    The paper's sets at every level, without and (at both ends) with the system's distortion removed, and the other sets
    of the catalogue at the highest level.
    """
    with threadpool_limits(1):  # two BLAS threads would change the last bits
        part = part_of(world, case.camera)
        by_level = flown(world, part, trials)
        given = np.stack([world.given_coordinates(trial)[part.points] for trial in range(trials)])
        lines = []
        for level, xy in by_level.items():
            models = [*SETS.values(), *(OTHERS if level == max(LEVELS) else ())]
            lines += [_lines(part, case, (level, False), model, xy, given) for model in models]
            if level in ENDS:
                reduced = without_system(part, xy, given)
                lines += [_lines(part, case, (level, True), model, reduced, given) for model in SETS.values()]
    return pd.concat(lines, ignore_index=True)


def flown(world: World, part: CameraBlock, trials: int) -> dict[int, Floats]:
    """(t, k, 2) mm for every level: the image points of one camera, corrected by the reseau."""
    found = {level: np.empty((trials, len(part.rays), 2)) for level in LEVELS}
    image = world.image[part.rays]
    for trial in range(trials):
        local = LocalFilm.draw(world, trial)
        points = world.image_points(trial)[part.rays]
        points = points + local.displacement(points, image)
        crosses = measured_crosses(world, trial, local, part.images)
        for level, xy in found.items():
            xy[trial] = corrected(points, image, crosses, level)
    return found


def without_system(part: CameraBlock, xy: Floats, given: Floats) -> Floats:
    """(t, k, 2) mm: the image points less the distortion that all images of a trial have in common.

    It is the mean residual, in cells of the format, of the adjustment without additional parameters.
    """
    found = adjusted(part, "none", xy, given)
    side = int(np.ceil(2.0 * 115.0 / CELL_MM))
    result = xy.copy()
    for trial, points in enumerate(xy):
        v = residuals(found, points, trial)
        column, row = np.clip(np.floor((points + 115.0) / CELL_MM).astype(int), 0, side - 1).T
        cell = side * column + row
        count = np.bincount(cell, minlength=side * side)
        sums = np.column_stack([np.bincount(cell, v[:, axis], minlength=side * side) for axis in range(2)])
        mean = np.where(count[:, None] >= LEAST_IN_CELL, sums / np.maximum(count, 1)[:, None], 0.0)
        result[trial] += mean[cell]
    return result


def residuals(found: Replicates, xy: Floats, trial: int) -> Floats:
    """(k, 2) mm: the corrections v of one trial without additional parameters, in the order of the block."""
    points = found.nominal.groups.image_points
    v, _ = replace(points, xy=xy[points.order]).residuals(found.trials.x[trial])
    ordered = np.empty_like(v)
    ordered[points.order] = v
    return ordered


def adjusted(part: CameraBlock, model: str, xy: Floats, given: Floats) -> Replicates:
    """All trials with one set. Raises ReproductionError where the block cannot be adjusted at all."""
    block = part.block.replace_image_points(xy[0])
    try:
        return adjust_replicates(block, model_of(model), xy, coordinates=given)
    except ValueError as error:
        raise ReproductionError(f"{model}: {error}") from error


def _lines(part: CameraBlock, case: Case, how: tuple[int, bool], model: str, xy: Floats, given: Floats) -> pd.DataFrame:
    found = adjusted(part, model, xy, given)
    return pd.DataFrame(
        {
            "camera": case.camera,
            "field": case.field,
            "level": how[0],
            "system": how[1],
            "model": model,
            "trial": np.arange(len(xy)),
            "rms_um": residual_um(found.trials.vpv, part.block),
            "failure": ["" if s.ok else s.value for s in found.status],
        }
    )
