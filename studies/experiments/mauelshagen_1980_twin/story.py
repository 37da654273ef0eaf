"""The twin, told as a story: fit the components, fly both worlds, write tables and report."""

from __future__ import annotations

import time
from pathlib import Path

from simfield.files import make_folder, whole_folder
from simfield.scenario import scenario_as_table
from studies.experiments.mauelshagen_1980 import (
    OLDER,
    table1,
    write_provenance,
)
from studies.experiments.mauelshagen_1980_twin import drawings, pages
from studies.experiments.mauelshagen_1980_twin.findings import TwinFindings, compute
from studies.experiments.reproduction import Reproduction
from studies.figures import house_style, save
from studies.session import provenance
from studies.texts import write_csv

MAIN = "2-D"
"""the reading of mu_xy that table1.csv and table1-fixed.csv belong to; the other one's are named after it"""


def reproduce(folder: Path, *, trials: int, jobs: int | None, seed: int) -> Reproduction:
    """Write the twin into a folder. Raises ReproductionError if there is none, OSError if it cannot write."""
    started = time.monotonic()
    make_folder(folder)
    command = f"simfield reproduce mauelshagen-1980 --world twin --trials {trials} --seed {seed}"
    found = compute(trials, jobs, seed)
    with whole_folder(folder, OLDER) as new:
        files = _write(found, new, command)
        origin = provenance(command, _parameters(found, seed), time.monotonic() - started)
        files.append(write_provenance(origin, new))
    return Reproduction([folder / path.name for path in files], found.failures)


def _write(found: TwinFindings, folder: Path, command: str) -> list[Path]:
    written: list[Path] = []
    sizes = dict.fromkeys(("first_fit", "size", "refit_16", "refit_50", "refit_84", "refit_50_mcse"), ".2f")
    tables = {
        "components": (pages.components_table(found), sizes),
        "fixed-terms": (pages.terms_table(found), {"um_at_100mm": ".1f"}),
        "ap-sets": (found.ap_sets, dict.fromkeys(("median_f", "significant", "mu_xy", "mu_z"), ".3f")),
    }
    for reading, twin in found.twins.items():
        ending = "" if reading == MAIN else f"-{reading}"
        tables[f"table1{ending}"] = (twin.table, table1.FORMATS)
        tables[f"table1-fixed{ending}"] = (twin.table_fixed, table1.FORMATS)
        with house_style():
            written += save(drawings.located(twin), folder / f"located{ending}", *drawings.LOCATED_SAYS)
    for name, (table, formats) in tables.items():
        path = folder / f"{name}.csv"
        write_csv(table, path, formats)
        written.append(path)
    report = folder / "report.md"
    report.write_text(pages.report_page(found, command), encoding="utf-8")
    return [*written, report]


def _parameters(found: TwinFindings, seed: int) -> dict[str, object]:
    scenarios = {
        f"{kind}, {reading}": scenario_as_table(scenario)
        for reading, twin in found.twins.items()
        for kind, scenario in (("random", twin.random_scenario), ("fixed", twin.fixed_scenario))
    }
    return {"trials": found.trials, "seed": seed, "scenarios": scenarios}
