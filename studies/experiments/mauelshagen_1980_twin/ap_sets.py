"""One AP set a camera, a flight, a strip or an image: is the finer choice significant?

The question that the paper leaves open: does the distortion of the flight before differ from that of the flight after?
The test is `adjust.quality.significance.finer_sets`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pandas as pd

from adjust import adjust_block, ap_models
from adjust.model import CHOICES
from adjust.quality import FTest, finer_sets
from simfield import World
from simfield.block import Block
from studies.comparison import geodetic_deviations
from studies.experiments.mauelshagen_1980 import SECTIONS

TRIALS = 50
LEVEL = 0.05


@dataclass(frozen=True)
class Step:
    """From a coarser to a finer choice in one trial: the test, and the error of check points as a share of before."""

    test: FTest
    mu_xy: float
    mu_z: float


def tests(worlds: Sequence[World]) -> pd.DataFrame:
    """One line for each world, model and step from coarse to fine, over TRIALS trials.

    median_f of the tests, significant: the share of them below LEVEL; mu_xy and mu_z: median of the rms at check points
    with the finer choice, divided by that with the coarser one. NaN where no trial could be adjusted.
    """
    lines = []
    for world in worlds:
        for model in SECTIONS:
            found = [_steps(world.observe(trial)[0], model) for trial in range(TRIALS)]
            for number, (coarse, fine) in enumerate(pairwise(CHOICES)):
                done = [s for s in (steps[number] for steps in found) if s is not None]
                lines.append(
                    {
                        "world": world.scenario.name,
                        "model": model,
                        "coarse": coarse,
                        "fine": fine,
                        "more_parameters": done[0].test.k if done else 0,
                        "median_f": _median([s.test.statistic for s in done]),
                        "significant": float(np.mean([s.test.p < LEVEL for s in done])) if done else float("nan"),
                        "mu_xy": _median([s.mu_xy for s in done]),
                        "mu_z": _median([s.mu_z for s in done]),
                        "n": len(done),
                    }
                )
    return pd.DataFrame(lines)


def _steps(block: Block, model: str) -> list[Step | None]:
    """One block from choice to choice; None where an adjustment is singular."""
    by = {choice: adjust_block(block, ap_models.get(model), ap_by=choice) for choice in CHOICES}
    steps: list[Step | None] = []
    for coarse, fine in pairwise(CHOICES):
        if not (by[coarse].status.ok and by[fine].status.ok):
            steps.append(None)
            continue
        before, after = geodetic_deviations(by[coarse]), geodetic_deviations(by[fine])
        test = finer_sets(by[coarse], by[fine])
        steps.append(Step(test, after.rms_xy_m / before.rms_xy_m, after.rms_z_m / before.rms_z_m))
    return steps


def _median(values: list[float]) -> float:
    return float(np.median(values)) if values else float("nan")
