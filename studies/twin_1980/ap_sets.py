"""One AP set a camera, a flight, a strip or an image: is the finer choice significant?

The question that the paper leaves open: does the distortion of the flight before differ from that of the flight after?
With vPv of the coarser and the finer choice, F = ((vPv_c - vPv_f) / (u_f - u_c)) / (vPv_f / r_f) follows Fisher's
distribution if the coarser choice is true (Koch 1999, Parameter estimation, section 4.2).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Literal

import numpy as np
import pandas as pd
from scipy import stats

from adjust import Adjustment, ap_models
from adjust.bundle import adjust_block
from simfield.block import Block
from simfield.simulate import World
from simfield.truth import Truth
from studies.reproduce_1980.experiment import SECTIONS

ApBy = Literal["camera", "flight", "strip", "image"]
CHOICES: tuple[ApBy, ...] = ("camera", "flight", "strip", "image")
TRIALS = 20
LEVEL = 0.05


def set_ids(truth: Truth, by: ApBy) -> dict[str, str]:
    """The AP set of every image."""
    owners = {
        "camera": truth.camera_ids,
        "flight": truth.flight_ids,
        "strip": truth.strip_ids,
        "image": truth.image_ids,
    }
    return dict(zip(truth.image_ids, owners[by], strict=True))


def f_test(coarse: Adjustment, fine: Adjustment) -> tuple[float, int, float]:
    """F, its first degrees of freedom, and the probability of a greater value if the coarser choice is true."""
    more = fine.unknowns - coarse.unknowns
    f = (coarse.vpv - fine.vpv) / more / (fine.vpv / fine.redundancy)
    return float(f), more, float(stats.f.sf(f, more, fine.redundancy))


def tests(worlds: Sequence[World]) -> pd.DataFrame:
    """One line for each world, model and step from coarse to fine: the share of significant tests in TRIALS trials."""
    lines = []
    for world in worlds:
        for model in SECTIONS:
            trials = [_steps(*world.observe(trial), model) for trial in range(TRIALS)]
            for step, (coarse, fine) in enumerate(pairwise(CHOICES)):
                done = np.array([trial[step] for trial in trials if trial[step] is not None], dtype=float)
                lines.append(
                    {
                        "world": world.scenario.name,
                        "model": model,
                        "coarse": coarse,
                        "fine": fine,
                        "more_parameters": int(done[0, 1]) if len(done) else 0,
                        "median_f": float(np.median(done[:, 0])) if len(done) else float("nan"),
                        "significant": float(np.mean(done[:, 2] < LEVEL)) if len(done) else float("nan"),
                        "n": len(done),
                    }
                )
    return pd.DataFrame(lines)


def _steps(block: Block, truth: Truth, model: str) -> list[tuple[float, int, float] | None]:
    """The F tests of one block from choice to choice; None where an adjustment is singular."""
    by: Mapping[str, Adjustment] = {
        choice: adjust_block(block, ap_models.get(model), ap_by=set_ids(truth, choice)) for choice in CHOICES
    }
    return [
        f_test(by[coarse], by[fine]) if by[coarse].status.ok and by[fine].status.ok else None
        for coarse, fine in pairwise(CHOICES)
    ]
