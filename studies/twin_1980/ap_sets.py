"""One AP set a camera, a flight, a strip or an image: is the finer choice significant?

The question that the paper leaves open: does the distortion of the flight before differ from that of the flight after?
The test is `adjust.significance.finer_sets`.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pandas as pd

from adjust import ap_models
from adjust.ap_sets import CHOICES
from adjust.bundle import adjust_block
from adjust.significance import finer_sets
from simfield.block import Block
from simfield.simulate import World
from studies.reproduce_1980.experiment import SECTIONS

TRIALS = 20
LEVEL = 0.05


def tests(worlds: Sequence[World]) -> pd.DataFrame:
    """One line for each world, model and step from coarse to fine: the share of significant tests in TRIALS trials."""
    lines = []
    for world in worlds:
        for model in SECTIONS:
            trials = [_steps(world.observe(trial)[0], model) for trial in range(TRIALS)]
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


def _steps(block: Block, model: str) -> list[tuple[float, int, float] | None]:
    """The F tests of one block from choice to choice; None where an adjustment is singular."""
    by = {choice: adjust_block(block, ap_models.get(model), ap_by=choice) for choice in CHOICES}
    found = [
        finer_sets(by[coarse], by[fine]) if by[coarse].status.ok and by[fine].status.ok else None
        for coarse, fine in pairwise(CHOICES)
    ]
    return [None if test is None else (test.statistic, test.k, test.p) for test in found]
