"""The reproduction, told as a story: fly and adjust, compare, draw, write."""

from __future__ import annotations

import time
from pathlib import Path

from simfield.files import make_folder, whole_folder
from simfield.scenario import scenario_as_table
from studies.experiments.mauelshagen_1980.findings import MauelshagenFindings, compute
from studies.experiments.mauelshagen_1980.written import write, write_provenance
from studies.experiments.reproduction import Reproduction
from studies.session import provenance

OLDER = ("report.html",)
"""what `simfield report` made of an older reproduction"""


def reproduce(folder: Path, *, trials: int, jobs: int | None, seed: int) -> Reproduction:
    """Write the reproduction into a folder. Raises ReproductionError if there is none, OSError if it cannot write."""
    started = time.monotonic()
    make_folder(folder)
    command = f"simfield reproduce mauelshagen-1980 --trials {trials} --seed {seed}"
    found = compute(trials, jobs, seed)
    with whole_folder(folder, OLDER) as new:
        files = write(found, new, command)
        origin = provenance(command, _parameters(found, seed), time.monotonic() - started)
        files.append(write_provenance(origin, new))
    return Reproduction([folder / path.name for path in files], found.failures)


def _parameters(found: MauelshagenFindings, seed: int) -> dict[str, object]:
    return {
        "trials": found.trials,
        "film_trials": found.film_trials,
        "seed": seed,
        "scenario": scenario_as_table(found.world.scenario),
        "film_scenario": scenario_as_table(found.film_world.scenario),
    }
