"""The error budget as a table and a stacked figure."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from adjust import ap_models
from adjust.reductions import ReductionPlan
from simfield import presets
from simfield.chain import chains
from simfield.files import make_folder, whole_folder
from studies.experiments.error_budget import EVERYTHING, Budget, table
from studies.figures import BLUE, GREEN, GREY, ORANGE, VERMILION, house_style, new_figure, save
from studies.session import progress_bar, provenance
from studies.texts import markdown, write_csv

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SCENARIO, CHAIN, MODEL = "rheidt-1980-film", "psk-1969", "brown14"
STAGES = 11
SAYS = (
    "Error budget, stage by stage",
    "Left: squares of image coordinates that each stage of the measurement chain puts in, split into what reductions "
    "take out, what parameters take up, and what stays in the residuals. Right: errors left at the check points.",
)
"""title and description of the figure"""
FORMATS = {
    **dict.fromkeys(("put_in_um", "taken_out_um", "left_um", "ap_um", "residual_um", "m0_um"), ".2f"),
    **dict.fromkeys(("mu_xy_mm", "mu_z_mm"), ".1f"),
    **dict.fromkeys(("m0_um_mcse", "mu_xy_mm_mcse", "mu_z_mm_mcse"), ".3f"),
}
WITH_ERROR = {"m0_um": 3, "mu_xy_mm": 2, "mu_z_mm": 2}
"""means over trials, and the digits that they and their standard errors get"""
OLDER = ("report.html",)
"""what `simfield report` made of older results"""


def write(folder: Path, trials: int, seed: int) -> list[Path]:
    """Compute the budget of 1980 (Helmert transformation on the fiducials, model brown14) and write it; the files."""
    started = time.monotonic()
    make_folder(folder)
    budget = Budget(presets[SCENARIO], chains[CHAIN], ReductionPlan("helmert"), ap_models.get(MODEL))
    with progress_bar(STAGES, "stages of the chain") as bar:
        found = table(budget, trials, seed, bar.update)
    origin = provenance(command(trials, seed), {"trials": trials, "seed": seed}, time.monotonic() - started)
    with whole_folder(folder, OLDER) as new:
        write_csv(found, new / "budget.csv", FORMATS)
        (new / "report.md").write_text(page(found, trials, seed), encoding="utf-8")
        with house_style():
            figure = new_figure(180.0, 95.0)
            images, ground = figure.subplots(1, 2, sharey=True, width_ratios=(3, 2))
            draw_images(images, found)
            draw_ground(ground, found)
            drawn = save(figure, new / "budget", *SAYS)
        text = json.dumps(origin, indent=1, allow_nan=False) + "\n"
        (new / "provenance.json").write_text(text, encoding="utf-8")
    return [folder / name for name in ("budget.csv", "report.md", *(path.name for path in drawn), "provenance.json")]


def command(trials: int, seed: int) -> str:
    """What computes the budget again."""
    return f"simfield budget --trials {trials} --seed {seed}"


def draw_images(axes: Axes, found: pd.DataFrame) -> None:
    """Squares, which add up: what reductions take out, what the adjustment takes up, what stays in the residuals."""
    place = -np.arange(len(found))
    put, left, residual = (found[name].to_numpy(float) ** 2 for name in ("put_in_um", "left_um", "residual_um"))
    residual = np.minimum(residual, left)
    parts = (
        (np.maximum(put - left, 0.0), GREEN, "reductions take out"),
        (left - residual, ORANGE, "AP and orientation take up"),
        (residual, VERMILION, "stays in the residuals"),
    )
    start = np.zeros(len(found))
    for width, colour, label in parts:
        axes.barh(place, width, left=start, color=colour, height=0.65, label=label)
        start = start + width
    for y, end, stage_um in zip(place.tolist(), start.tolist(), found["put_in_um"], strict=True):
        axes.text(end, y, f" {stage_um:.1f}", va="center", fontsize=7)
    axes.set_yticks(place, found["stage"])
    axes.set_xlabel("squares of image coordinates, µm² (beside the bars: µm put in)")
    axes.set_xlim(0.0, 1.12 * start.max())
    axes.legend(loc="upper right", fontsize=7)


def draw_ground(axes: Axes, found: pd.DataFrame) -> None:
    """What is left in the check points, mm."""
    place = -np.arange(len(found))
    axes.barh(place + 0.17, found["mu_xy_mm"], height=0.32, color=BLUE, label="mu_xy, 2-D")
    axes.barh(place - 0.17, found["mu_z_mm"], height=0.32, color=GREY, label="mu_z")
    axes.set_xlabel("rms at check points, mm")
    axes.legend(loc="upper right", fontsize=7)


def page(found: pd.DataFrame, trials: int, seed: int) -> str:
    """The budget in Markdown."""
    parts = found[found["stage"] != EVERYTHING]
    together = found[found["stage"] == EVERYTHING].iloc[0]
    root = {name: float(np.sqrt((parts[name] ** 2).sum())) for name in ("left_um", "mu_xy_mm", "mu_z_mm")}
    return (
        "# Error budget of the measurement chain\n\n"
        f"`{command(trials, seed)}`: scenario {SCENARIO}, chain {CHAIN}, Helmert "
        f"transformation on four fiducials, model {MODEL}, both cameras with auxiliary points; "
        "one stage at a time, then all together.\n\n"
        f"{markdown(_with_errors(found), {k: v for k, v in FORMATS.items() if k not in WITH_ERROR})}\n"
        "put_in, left: rms of an image coordinate before and after the reductions, after the best rotation and shift "
        "of each image. taken_out: root of the difference of squares, negative where the reductions put in more than "
        "they take out (the fiducials' own errors). ap: rms of what the model took up. residual: rms of the "
        "residuals. Behind ± stands the Monte-Carlo standard error of a mean over n flights.\n\n"
        f"Root of the sum of squares of the single stages, and all together: left {root['left_um']:.1f} and "
        f"{together['left_um']:.1f} um, mu_xy {root['mu_xy_mm']:.1f} and {together['mu_xy_mm']:.1f} mm, mu_z "
        f"{root['mu_z_mm']:.1f} and {together['mu_z_mm']:.1f} mm.\n\n![Error budget, stage by stage](budget.svg)\n"
    )


def _with_errors(found: pd.DataFrame) -> pd.DataFrame:
    """The table with each mean and its standard error in one cell."""
    shown = found.drop(columns=[f"{name}_mcse" for name in WITH_ERROR])
    for name, digits in WITH_ERROR.items():
        pairs = zip(found[name], found[f"{name}_mcse"], strict=True)
        shown[name] = [f"{mean:.{digits}f} ± {error:.{digits}f}" for mean, error in pairs]
    return shown
