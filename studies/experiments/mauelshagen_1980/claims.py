"""What the paper says in words, computed: correlations of a3, a4 and Z0, standard errors, crest and corner vectors.

All of one simulated flight; a claim's figure is compared with the paper's where the paper gives one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from adjust import Adjustment, ap_models
from simfield import Truth
from simfield.block import Block
from studies.comparison import decentering_fields, format_grid, radial_curve, root_mean_square
from studies.experiments.mauelshagen_1980.experiment import BOTH, CAMERAS, Row, adjusted, middle_images, sub_block

SECOND_ZEROS_MM = tuple(float(r) for r in range(0, 141, 5))
PUBLISHED_A3_A4 = {False: "-0.92", True: "-0.82"}
PUBLISHED_Z0 = {0.0: "0.80 to 0.85", 100.0: "almost none"}
Z0_CLAIM = "Z0 and a3, a4"
COLUMNS = ["claim", "model", "r0_mm", "aux_points", "camera", "images", "quantity", "published", "simulated"]
FORMATS = {"r0_mm": "g", "simulated": ".3f"}
CURVE_FORMATS = {"r0_mm": "g", "mean_abs_r": ".4f"}
ERROR_FORMATS = {"std": ".4e", "effect_um": ".4f"}


def claims(block: Block, truth: Truth, z0: pd.DataFrame) -> pd.DataFrame:
    """The claims as one table; z0 is `z0_correlations`."""
    lines = [*_a3_a4(block, truth), *_z0(z0), *_crests(block, truth)]
    return pd.DataFrame(lines, columns=COLUMNS)


def _a3_a4(block: Block, truth: Truth) -> list[tuple[object, ...]]:
    lines: list[tuple[object, ...]] = []
    for model in ("optical", "torlegard"):
        for aux in (False, True):
            a = adjusted(sub_block(block, truth, BOTH, aux), model)
            for camera in CAMERAS:
                r = a.correlation((camera, "a3"), (camera, "a4"))[0, 1]
                row = ("a3 and a4", model, 100.0, aux, camera, "-", "R(a3,a4)", PUBLISHED_A3_A4[aux], float(r))
                lines.append(row)
    return lines


def _z0(curves: pd.DataFrame) -> list[tuple[object, ...]]:
    chosen = curves[curves["r0_mm"].isin(PUBLISHED_Z0)]
    return [
        (Z0_CLAIM, "optical", r0, aux, camera, images, f"mean abs R(Z0,{name})", PUBLISHED_Z0[r0], mean)
        for r0, aux, camera, images, name, mean in chosen[
            ["r0_mm", "aux_points", "camera", "images", "parameter", "mean_abs_r"]
        ]
        .to_numpy()
        .tolist()
    ]


def _crests(block: Block, truth: Truth) -> list[tuple[object, ...]]:
    """Crest of the radial curve and longest corner vector, as changes against model 3.1."""
    part = sub_block(block, truth, BOTH, True)
    by_model = {model: adjusted(part, model) for model in ("optical", "torlegard", "brown14")}
    rise = {"torlegard": "1.0", "brown14": "1.5"}
    corner = {("torlegard", "ww"): "-10", ("brown14", "ww"): "-15", ("torlegard", "sww"): "0", ("brown14", "sww"): "20"}
    lines: list[tuple[object, ...]] = []
    for camera in CAMERAS:
        crests = {m: radial_curve(a, camera, truth).crest_um for m, a in by_model.items()}
        corners = {m: decentering_fields(a, camera, truth).estimated.corner_um for m, a in by_model.items()}
        for model in rise:
            change = crests[model] - crests["optical"]
            lines.append(
                ("crest and corners", model, 100.0, True, camera, "-", "rise of the crest, um", rise[model], change)
            )
        for model in rise:
            change = 100.0 * (corners[model] / corners["optical"] - 1.0)
            wanted = corner[model, camera]
            lines.append(
                ("crest and corners", model, 100.0, True, camera, "-", "corner vector longer by, %", wanted, change)
            )
    return lines


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
                        lines.append((r0, aux, camera, kind, name, _mean_with_z0(a, camera, images, name)))
    return pd.DataFrame(lines, columns=["r0_mm", "aux_points", "camera", "images", "parameter", "mean_abs_r"])


def _mean_with_z0(a: Adjustment, camera: str, images: Sequence[str], parameter: str) -> float:
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
