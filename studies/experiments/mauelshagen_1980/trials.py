"""Many flights over one geometry: the 18 adjustments of Table 1 for each trial.

A trial depends on seed and number alone, and each row is computed by itself, so the result is the same for any number
of processes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed

from adjust import adjust_replicates, ap_models
from simfield import World
from simfield.block import Block, Floats, Indices
from studies.experiments.mauelshagen_1980.experiment import Row, sub_block

COUNTS = ("unknowns", "redundancy")
MEASURES = ("m0_um", "mu_xy_mm", "mu_xy_coordinate_mm", "mu_z_mm")


def run_trials(
    world: World, rows: Sequence[Row], trials: int, jobs: int | None, report: Callable[[int], Any]
) -> pd.DataFrame:
    """One line for each trial and row: trial, row (a number), COUNTS, MEASURES, and failure, empty if there was none.

    jobs None takes a process for each processor; `report` is told 1 for every row that is finished.
    """
    given = np.stack([world.given_coordinates(trial) for trial in range(trials)])
    tables = []
    with Parallel(n_jobs=-1 if jobs is None else jobs, return_as="generator_unordered") as parallel:
        for table in parallel(delayed(_run_row)(world, number, row, given) for number, row in enumerate(rows)):
            tables.append(table)
            report(1)
    joined: pd.DataFrame = pd.concat(tables).sort_values(["row", "trial"], ignore_index=True)
    return joined


def _run_row(world: World, number: int, row: Row, given: Floats) -> pd.DataFrame:
    """All trials of one row; given (t, n, 3), m: the coordinates that the geodetic survey of each trial has found."""
    whole, truth = world.observe(0)
    block = sub_block(whole, truth, row.block, row.aux_points)
    observations, points = places(block, whole)
    coordinates = given[:, points]
    draws = world.draws(0, len(given)).only(observations)
    r = adjust_replicates(block, ap_models.get(row.model), draws, coordinates=coordinates)
    check = block.points.role == "check"
    mu = 1000.0 * np.sqrt(np.mean((r.points - coordinates)[:, check] ** 2, axis=1))
    mu_xy = np.hypot(mu[:, 0], mu[:, 1])
    return pd.DataFrame(
        {
            "trial": np.arange(len(given)),
            "row": number,
            "unknowns": r.nominal.unknowns,
            "redundancy": r.nominal.redundancy,
            **dict(zip(MEASURES, (r.m0_um, mu_xy, mu_xy / np.sqrt(2.0), mu[:, 2]), strict=True)),
            "failure": ["" if status.ok else status.value for status in r.status],
        }
    )


def places(part: Block, whole: Block) -> tuple[Indices, Indices]:
    """Where the observations and the points of a sub-block stand in the whole block."""
    place = {point: row for row, point in enumerate(whole.points.ids)}
    points = np.array([place[point] for point in part.points.ids])
    images = np.isin(whole.images.ids, part.images.ids)
    kept = images[whole.observations.image] & np.isin(whole.observations.point, points)
    return np.flatnonzero(kept), points
