"""Everything that the reproduction computes. Nothing here knows a file."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd
from joblib import Parallel, delayed

from simfield import World, build_world, presets
from simfield.disturbances import DistortionError
from simfield.world import CountError
from studies.experiments.reproduction import ReproductionError
from studies.experiments.ziemann_1982 import table
from studies.experiments.ziemann_1982.experiment import FIELDS, cases
from studies.experiments.ziemann_1982.trials import run_case
from studies.session import progress_bar


@dataclass(frozen=True, eq=False)
class ZiemannFindings:
    """worlds by field; the tables of studies.experiments.ziemann_1982.table; a line for each adjustment that failed."""

    worlds: dict[str, World]
    trials: int
    table: pd.DataFrame
    beyond: pd.DataFrame
    ranks: pd.DataFrame
    failures: list[str]


def compute(trials: int, jobs: int | None, seed: int) -> ZiemannFindings:
    """Fly both fields with both cameras. jobs None takes a process for each processor."""
    try:
        worlds = {field: build_world(presets[name], seed) for field, name in FIELDS.items()}
    except (CountError, DistortionError) as error:
        raise ReproductionError(str(error)) from error
    work = [(worlds[case.field], case, trials) for case in cases()]
    parts = []
    with (
        progress_bar(len(work), "cases") as bar,
        Parallel(n_jobs=-1 if jobs is None else jobs, return_as="generator") as parallel,
    ):
        for part in parallel(delayed(run_case)(*one) for one in work):
            parts.append(part)
            bar.update(1)
    flown = pd.concat(parts, ignore_index=True)
    compared = table.table(flown)
    failed = flown[flown["failure"] != ""]
    names = ["camera", "field", "level", "model", "trial", "failure"]
    lines = [", ".join(str(value) for value in row) for row in failed[names].to_numpy().tolist()]
    ranks = table.rank_correlations(compared, flown)
    return ZiemannFindings(worlds, trials, compared, table.beyond(flown), ranks, lines)
