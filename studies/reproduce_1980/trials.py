"""Many flights over one geometry: the 18 adjustments of Table 1 for each trial.

A trial depends on seed and number alone, and trials are put in order before anything is computed from them, so the
result is the same for any number of processes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import pandas as pd
from joblib import Parallel, delayed
from threadpoolctl import threadpool_limits

from adjust import adjust_block, ap_models
from simfield.simulate import World
from studies.measures import geodetic_deviations
from studies.reproduce_1980.experiment import Row, sub_block

TRIALS_A_TASK = 4
COUNTS = ("unknowns", "redundancy")
MEASURES = ("m0_um", "mu_xy_mm", "mu_xy_coordinate_mm", "mu_z_mm")


def run_trials(
    world: World, rows: Sequence[Row], trials: int, jobs: int | None, report: Callable[[int], Any]
) -> pd.DataFrame:
    """One line for each trial and row: trial, row (a number), COUNTS, MEASURES, and failure, empty if there was none.

    jobs None takes a process for each processor; `report` is told how many trials have been finished since it was last.
    """
    tasks = [range(first, min(first + TRIALS_A_TASK, trials)) for first in range(0, trials, TRIALS_A_TASK)]
    records: list[dict[str, Any]] = []
    with Parallel(n_jobs=-1 if jobs is None else jobs, return_as="generator_unordered") as parallel:
        for finished in parallel(delayed(_run_task)(world, rows, task) for task in tasks):
            records += finished
            report(len({r["trial"] for r in finished}))
    return pd.DataFrame(records).sort_values(["row", "trial"], ignore_index=True)


def _run_task(world: World, rows: Sequence[Row], trials: Sequence[int]) -> list[dict[str, Any]]:
    # two BLAS threads would change the last bits, and cost more than they bring
    with threadpool_limits(1):
        return [record for trial in trials for record in _run_trial(world, rows, trial)]


def _run_trial(world: World, rows: Sequence[Row], trial: int) -> list[dict[str, Any]]:
    block, truth = world.observe(trial)
    parts = {part: sub_block(block, truth, *part) for part in {(row.block, row.aux_points) for row in rows}}
    records = []
    for number, row in enumerate(rows):
        a = adjust_block(parts[row.block, row.aux_points], ap_models.get(row.model))
        record: dict[str, Any] = {"trial": trial, "row": number, "unknowns": a.unknowns, "redundancy": a.redundancy}
        record |= dict.fromkeys(MEASURES, float("nan"))
        if a.status.ok:
            found = geodetic_deviations(a)
            metres = (found.rms_xy_m, found.rms_xy_coordinate_m, found.rms_z_m)
            record.update(zip(MEASURES, (a.m0_um, *(1000.0 * v for v in metres)), strict=True))
        records.append({**record, "failure": "" if a.status.ok else a.message})
    return records
