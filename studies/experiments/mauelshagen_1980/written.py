"""Writes the reproduction: tables, figures, report.md and provenance.json. Only this module knows file names."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from studies.experiments.mauelshagen_1980 import claims, drawings, table1, table2, verdicts
from studies.experiments.mauelshagen_1980.experiment import CAMERAS
from studies.experiments.mauelshagen_1980.findings import RADIUS_EDGES_MM, MauelshagenFindings
from studies.experiments.mauelshagen_1980.pages import report_page, table1_page, table2_page
from studies.figures import house_style, save
from studies.texts import write_csv

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write(found: MauelshagenFindings, folder: Path, command: str) -> list[Path]:
    """Write tables, figures and pages; the files."""
    return [*_tables(found, folder), *_figures(found, folder), *_pages(found, folder, command)]


def write_provenance(origin: Mapping[str, Any], folder: Path) -> Path:
    """Write provenance.json."""
    path = folder / "provenance.json"
    path.write_text(json.dumps(origin, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    return path


def _tables(found: MauelshagenFindings, folder: Path) -> Iterator[Path]:
    written = {
        "table1": (found.table1, table1.FORMATS),
        "table1_film": (found.table1_film, table1.FORMATS),
        "table2": (found.table2, table2.FORMATS),
        "table2_rms": (found.table2_rms, table2.RMS_FORMATS),
        "table2_geometries": (found.geometries, table2.RMS_FORMATS),
        "claims": (found.claims, verdicts.FORMATS),
        "z0_correlations": (found.z0, claims.CURVE_FORMATS),
        "standard_errors": (found.errors, claims.ERROR_FORMATS),
    }
    for name, (table, formats) in written.items():
        path = folder / f"{name}.csv"
        write_csv(table, path, formats)
        yield path


def figures(found: MauelshagenFindings) -> Iterator[tuple[str, Figure]]:
    """Every figure with its name."""
    yield "plan", drawings.plan_figure(found.block)
    yield "ellipses", drawings.ellipses_figure(found.point_errors)
    tables = {found.world.scenario.name: found.table1, found.film_world.scenario.name: found.table1_film}
    yield "table1", drawings.table1_figure(tables)
    for camera in CAMERAS:
        yield f"table2_{camera}", drawings.table2_figure(found.table2, camera, found.table2_rms)
    yield "erratum", drawings.erratum_figure(found.table2_rms)
    yield "z0_correlations", drawings.z0_figure(found.z0)
    yield "standard_errors", drawings.errors_figure(found.errors)
    yield "figure1", drawings.figure1(found.radii, RADIUS_EDGES_MM)
    for number, camera in enumerate(CAMERAS, start=2):
        yield f"figure{number}", drawings.distortion_figure(found.curves[camera], found.fields[camera])


def _figures(found: MauelshagenFindings, folder: Path) -> Iterator[Path]:
    with house_style():
        for name, figure in figures(found):
            yield from save(figure, folder / name, *drawings.ALTERNATIVE[name])


def _pages(found: MauelshagenFindings, folder: Path, command: str) -> Iterator[Path]:
    pages = {"table1": table1_page(found), "table2": table2_page(found), "report": report_page(found, command)}
    for name, text in pages.items():
        path = folder / f"{name}.md"
        path.write_text(text, encoding="utf-8")
        yield path
