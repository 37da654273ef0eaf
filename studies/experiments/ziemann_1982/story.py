"""The reproduction, told as a story: fly and adjust, compare, draw, write. Only this module knows file names."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from pathlib import Path

from simfield.files import make_folder, whole_folder
from simfield.scenario import scenario_as_table
from studies.experiments.reproduction import Reproduction
from studies.experiments.ziemann_1982 import drawings
from studies.experiments.ziemann_1982.findings import ZiemannFindings, compute
from studies.experiments.ziemann_1982.pages import report_page
from studies.experiments.ziemann_1982.table import FORMATS, RANK_FORMATS
from studies.figures import house_style, save
from studies.session import provenance
from studies.texts import write_csv

OLDER = ("report.html",)
"""what `simfield report` made of an older reproduction"""


def reproduce(folder: Path, *, trials: int, jobs: int | None, seed: int) -> Reproduction:
    """Write the reproduction into a folder. Raises ReproductionError if there is none, OSError if it cannot write."""
    started = time.monotonic()
    make_folder(folder)
    command = f"simfield reproduce ziemann-1982 --trials {trials} --seed {seed}"
    found = compute(trials, jobs, seed)
    scenarios = {field: scenario_as_table(world.scenario) for field, world in found.worlds.items()}
    parameters = {"trials": trials, "seed": seed, "scenarios": scenarios}
    with whole_folder(folder, OLDER) as new:
        files = [*_tables(found, new), *_figures(found, new), _page(found, new, command), new / "provenance.json"]
        record = provenance(command, parameters, time.monotonic() - started)
        files[-1].write_text(json.dumps(record, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    return Reproduction([folder / path.name for path in files], found.failures)


def _tables(found: ZiemannFindings, folder: Path) -> Iterator[Path]:
    written = {
        "table": (found.table, FORMATS),
        "beyond": (found.beyond, FORMATS),
        "ranks": (found.ranks, RANK_FORMATS),
    }
    for name, (frame, formats) in written.items():
        path = folder / f"{name}.csv"
        write_csv(frame, path, formats)
        yield path


def _figures(found: ZiemannFindings, folder: Path) -> Iterator[Path]:
    with house_style():
        yield from save(drawings.sets_figure(found.table), folder / "sets", *drawings.SETS_SAY)
        yield from save(drawings.levels_figure(found.table), folder / "levels", *drawings.LEVELS_SAY)


def _page(found: ZiemannFindings, folder: Path, command: str) -> Path:
    path = folder / "report.md"
    path.write_text(report_page(found, command), encoding="utf-8")
    return path
