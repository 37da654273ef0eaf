"""Curves and tables behind what the paper says in words: correlations with Z0 over r0, and standard errors.

Of one geometry; they hang on no flight.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from adjust import Adjustment, ap_models
from simfield import Truth
from simfield.block import Block
from studies.comparison import format_grid, root_mean_square
from studies.experiments.mauelshagen_1980.experiment import BOTH, CAMERAS, Row, adjusted, middle_images, sub_block

SECOND_ZEROS_MM = tuple(float(r) for r in range(0, 141, 5))
CURVE_FORMATS = {"r0_mm": "g", "mean_abs_r": ".4f"}
ERROR_FORMATS = {"std": ".4e", "effect_um": ".4f"}


def z0_correlations(block: Block, truth: Truth) -> pd.DataFrame:
    """Mean |R(Z0,a3)|, |R(Z0,a4)| over all and over the middle images of each camera, for second zeros from 0 to 140
    mm.
    """
    lines = []
    for aux in (False, True):
        part = sub_block(block, truth, BOTH, aux)
        for r0 in SECOND_ZEROS_MM:
            a = adjusted(part, ap_models.get("optical", r0_mm=r0))
            for camera in CAMERAS:
                own = [i for i, c in zip(truth.image_ids, truth.camera_ids, strict=True) if c == camera]
                for kind, images in (("all", own), ("middle", middle_images(truth, camera))):
                    for name in ("a3", "a4"):
                        lines.append((r0, aux, camera, kind, name, mean_with_z0(a, camera, images, name)))
    return pd.DataFrame(lines, columns=["r0_mm", "aux_points", "camera", "images", "parameter", "mean_abs_r"])


def mean_with_z0(a: Adjustment, camera: str, images: Sequence[str], parameter: str) -> float:
    """The mean over images of |R| between Z0 and a parameter of their camera."""
    r = a.correlation((camera, parameter), *((image, "Z0") for image in images))
    return float(np.mean(np.abs(r[0, 1:])))


def standard_errors(block: Block, truth: Truth, rows: Sequence[Row]) -> pd.DataFrame:
    """The standard error of every additional parameter in each of the 18 adjustments, beside the redundancy.

    effect_um is the rms displacement over the format that the standard error stands for.
    """
    lines = []
    xy = format_grid()
    for row in rows:
        a = adjusted(sub_block(block, truth, row.block, row.aux_points), row.model)
        for s in a.layout.sets:
            terms = s.model.basis(*xy.T)
            size = [root_mean_square(np.hypot(*term.T)) for term in np.moveaxis(terms, 2, 0)]
            for name, std, rms in zip(s.model.parameters, a.ap[s.id].std, size, strict=True):
                lines.append(
                    (
                        row.model,
                        row.block,
                        row.aux_points,
                        s.id,
                        a.redundancy,
                        name,
                        float(std),
                        1000.0 * float(std) * rms,
                    )
                )
    columns = ["model", "block", "aux_points", "camera", "redundancy", "parameter", "std", "effect_um"]
    return pd.DataFrame(lines, columns=columns)


def falling(errors: pd.DataFrame) -> tuple[int, int]:
    """How many standard errors are smaller with auxiliary points (higher redundancy), and how many there are."""
    wide = errors.pivot(index=["model", "block", "camera", "parameter"], columns="aux_points", values="std")
    return int((wide[True] < wide[False]).sum()), len(wide)
