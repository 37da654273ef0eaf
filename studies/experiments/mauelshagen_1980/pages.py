"""The pages of the reproduction in Markdown. Every figure in them is read off the findings."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd

from studies.experiments import published
from studies.experiments.mauelshagen_1980 import claims, drawings, table1, table2, verdicts
from studies.experiments.mauelshagen_1980.experiment import CAMERA_TITLES, CAMERAS
from studies.experiments.mauelshagen_1980.findings import MauelshagenFindings
from studies.pages import scenario_page
from studies.texts import markdown

MEASURED = {"m0_um": "m0", "mu_xy_mm": "mu_xy (2-D)", "mu_z_mm": "mu_z"}
AUX = {False: "without auxiliary points", True: "with auxiliary points"}
VARIANT_TEXT = {
    "corrected": "Brown's terms: b4 x^2 y, (r^2 + 2x^2), (r^2 + 2y^2)",
    "b4_only": "b4 x^2 y corrected, signs as printed",
    "sign_only": "signs corrected, b4 xy as printed",
    "as_printed": "as printed: b4 xy, (r^2 - 2x^2), (r^2 - 2y^2)",
}


def report_page(found: MauelshagenFindings, command: str) -> str:
    """The report, from top to bottom."""
    sections = (_opening(found), _world(found), _table1(found), _table2(found), _erratum(found), _claims(found))
    return "\n".join("\n".join(section) for section in (*sections, _figures(found), _closing(found, command)))


def table1_page(found: MauelshagenFindings) -> str:
    """Table 1 with its explanation and the world it was flown in."""
    return "\n".join(
        ["# Table 1: published and simulated", "", *_table1_body(found), "## The simulated world", "", _page_of(found)]
    )


def table2_page(found: MauelshagenFindings) -> str:
    """Table 2, all four adjustments of the corrected model, and how far every variant is from the print."""
    lines = ["# Table 2: correlations of b1 .. b14", "", published.source("mauelshagen-1980-table2-without-aux"), ""]
    lines += [
        "Each cell: simulated / published, in hundredths. Simultaneous adjustment, 39 images, corrected terms.",
        "",
    ]
    for camera in CAMERAS:
        for aux, label in AUX.items():
            lines += [f"## {CAMERA_TITLES[camera]}, {label}", "", table2.matrix_markdown(found.table2, aux, camera)]
    return "\n".join([*lines, "## Rms of the 91 differences", "", _rms_table(found)])


def _opening(found: MauelshagenFindings) -> Iterator[str]:
    yield "# Mauelshagen 1980, flown and adjusted again\n"
    yield published.source("mauelshagen-1980-table1").split(", Table 1")[0] + ".\n"
    yield (
        "The paper determines distortion parameters of two aerial cameras at once, by bundle adjustment of flights "
        "over the test field Rheidt. Here the flights are simulated and adjusted with the paper's three models of "
        "additional parameters: 3.1 `optical`, 3.2 `torlegard`, 3.3 `brown14`. SWW is the super-wide-angle camera "
        "(the paper's ÜWW), WW the wide-angle camera. The adjustment sees only what a surveyor would have; the "
        "truth is used to judge it.\n"
    )
    yield (
        f"{found.trials} flights over one geometry; image noise and geodetic errors change from flight to flight. "
        "What needs no statistics (table 2, figures) is computed from flight 0.\n"
    )


def _world(found: MauelshagenFindings) -> Iterator[str]:
    yield "## 1  The simulated world\n"
    yield _page_of(found)
    yield (
        "Not known and assumed: whatever the sources in `simfield/world/cameras.py`, `simfield/world/fields.py` and "
        "`simfield/scenario/preset_scenarios.py` call an assumption, above all the distortions, the distance within a "
        "group, and which points were not measured.\n"
    )
    yield _figure("plan")


def _figure(name: str) -> str:
    """A figure with its title as the text that stands for it."""
    return f"![{drawings.ALTERNATIVE[name][0]}]({name}.svg)\n"


def _page_of(found: MauelshagenFindings) -> str:
    scenario = found.world.scenario
    return f"Preset `{scenario.name}`, seed {found.world.seed}.\n\n{scenario_page(scenario)}"


def _table1(found: MauelshagenFindings) -> Iterator[str]:
    yield "## 2  Table 1: unknowns, redundancy, m0 and mu\n"
    yield from _table1_body(found)
    yield _figure("table1")
    yield "### Monte-Carlo standard errors\n"
    yield "Mean over the flights ± its Monte-Carlo standard error, and how many flights could be adjusted.\n"
    yield table1.errors_markdown(found.table1)
    film = found.film_world.scenario
    yield f"### The same with film that changes: `{film.name}`\n"
    yield (
        "Where a simulated figure is too small, the flights of 1969 had errors that this world has not. The preset "
        f"`{film.name}` adds film deformation that no set of constant parameters describes ({found.film_trials} "
        "flights, `table1_film.csv`): "
        + "; ".join(
            [
                f"camera {v.camera}: {v.terms} terms of {v.um_at_100mm:g} um at 100 mm, new in every image"
                for v in film.film
            ]
            + [f"{len(film.effects) - len(found.world.scenario.effects)} constant effects more, see provenance.json"]
        )
        + ".\n"
    )
    yield _inside(found.table1_film)


def _table1_body(found: MauelshagenFindings) -> Iterator[str]:
    table = found.table1
    equal = ((table["unknowns"] == table["sim_unknowns"]) & (table["redundancy"] == table["sim_redundancy"])).sum()
    yield (
        f"Unknowns and redundancy of {equal} of {len(table)} rows are those published. A simulated figure is the "
        f"mean over {found.trials} flights of each flight's own rms, in brackets the range of 95 % of the flights: "
        "the paper's figure is that of one flight. mu are rms deviations at the unknown points from their geodetic "
        "coordinates, which have errors of their own. The paper does not say whether mu_xy is the two-dimensional "
        "point error or that of one coordinate; both are given. `table1.csv` has the Monte-Carlo standard errors "
        "too.\n"
    )
    yield table1.table1_markdown(table)
    yield _inside(table)
    failed = found.failures
    yield f"Adjustments that failed: {len(failed) or 'none'}.\n"
    if failed:
        yield "\n".join(f"- {line}" for line in failed) + "\n"


def _inside(table: pd.DataFrame) -> str:
    """How the simulated figures compare, as sentences."""
    parts = []
    for name, label in MEASURED.items():
        inside = ((table[name] >= table[f"sim_{name}_lo"]) & (table[name] <= table[f"sim_{name}_hi"])).sum()
        ratio = (table[f"sim_{name}"] / table[name]).to_numpy(float)
        parts.append(
            f"- {label}: {inside} of {len(table)} published figures lie inside the range; simulated / published is "
            f"{ratio.mean():.2f} in the mean, {ratio.min():.2f} to {ratio.max():.2f}."
        )
    return "\n".join(parts) + "\n"


def _table2(found: MauelshagenFindings) -> Iterator[str]:
    yield "## 3  Table 2: correlations of b1 .. b14\n"
    fits = []
    for aux, label in AUX.items():
        camera, rms = table2.best_fit(found.table2_rms, aux)
        fits.append(f"{rms:.3f} {label} (camera {camera.upper()})")
    yield (
        "Simultaneous adjustment of 39 images with `brown14`. The paper does not say which camera's parameters the "
        "table shows, nor which of the two figures in a cell belongs to the adjustment with auxiliary points; taken "
        "as in its Table 1 (upper: without), the rms of the 91 differences is, for the camera that fits better, "
        + " and ".join(fits)
        + ". The matrices are in `table2.md`, all pairs in `table2.csv`.\n"
    )
    others = found.geometries.assign(rms=found.geometries[["as_labelled", "swapped"]].min(axis=1))
    best = others.groupby(["aux_points", "seed"])["rms"].min()
    ranges = [f"{best[aux].min():.3f} to {best[aux].max():.3f} {label}" for aux, label in AUX.items()]
    yield (
        "How the flights deviated from plan and which points were not measured is not known, and the correlations "
        f"depend on it: for {others['seed'].nunique()} other geometries (other seeds, `table2_geometries.csv`), camera "
        f"and printed row as they fit best, the rms is {' and '.join(ranges)}.\n"
    )
    for camera in CAMERAS:
        yield _figure(f"table2_{camera}")


def _erratum(found: MauelshagenFindings) -> Iterator[str]:
    yield "## 4  An erratum\n"
    printed = found.table2_rms[found.table2_rms["variant"] == "as_printed"]["as_labelled"]
    yield (
        "The paper prints (r^2 - 2x^2) and (r^2 - 2y^2) in all three models and b4 xy in dy of 3.3. Correlations "
        "do not depend on measured values, only on geometry and model; so Table 2 tells which terms the program "
        f"had. With the printed terms the rms difference is {printed.min():.3f} to {printed.max():.3f}. `swapped` "
        "compares with the other figure of each cell.\n"
    )
    yield _rms_table(found)
    yield _figure("erratum")


def _rms_table(found: MauelshagenFindings) -> str:
    rms = found.table2_rms.assign(terms=found.table2_rms["variant"].map(VARIANT_TEXT))
    rms = rms.assign(aux_points=rms["aux_points"].map({False: "without", True: "with"}))
    columns = ["terms", "aux_points", "camera", "as_labelled", "swapped"]
    return markdown(rms[columns], {"as_labelled": ".3f", "swapped": ".3f"})


def _claims(found: MauelshagenFindings) -> Iterator[str]:
    yield "## 5  What the paper says in words\n"
    met, of = verdicts.reached(found.claims)
    yield (
        f"{met} of {of} figures are reached: as printed, with what was rounded off, they lie in the range found here. "
        "Correlations hang on the geometry alone, their range is from the least to the greatest of several "
        "geometries; crest and corners change from flight to flight, their range has 95 % of the flights over this "
        "geometry. simulated is the mean.\n"
    )
    for number, (claim, lines) in enumerate(found.claims.groupby("claim", sort=False), start=1):
        yield f"### 5.{number}  {claim}\n"
        shown = lines.drop(columns=["claim"])
        used = [c for c in shown.columns if not (shown[c] == "-").all()]
        yield markdown(
            shown[used].assign(aux_points=shown["aux_points"].map({False: "without", True: "with"})), verdicts.FORMATS
        )
        if claim == verdicts.Z0_CLAIM:
            yield '"middle" are the images centred on the field, which see all of it.\n'
            yield _figure("z0_correlations")
    smaller, of = claims.falling(found.errors)
    yield "### 5.4  Standard errors fall as redundancy rises\n"
    yield f"With auxiliary points {smaller} of {of} standard errors of the parameters are smaller than without.\n"
    yield _figure("standard_errors")
    yield (
        "What the adjustment claims for the points themselves, one a group; a true position lies inside its ellipse "
        "with a probability of 39 %:\n"
    )
    yield _figure("ellipses")


def _figures(found: MauelshagenFindings) -> Iterator[str]:
    yield "## 6  Figures 1 to 3\n"
    yield _figure("figure1")
    yield "Figure 1: points of a full image by radius.\n"
    for number, camera in enumerate(CAMERAS, start=2):
        fields = found.fields[camera]
        curve = found.curves[camera][fields.model]
        yield _figure(f"figure{number}")
        inside = abs(curve.estimated_um - curve.true_um) <= 2.0 * curve.std_um
        yield (
            f"Figure {number}, {CAMERA_TITLES[camera]}, model {curve.model}: crest of the radial curve "
            f"{curve.crest_um:.1f} um; the true curve lies within two standard deviations on "
            f"{100 * inside.mean():.0f} % of the radius. Quadratic mean of the decentering vectors "
            f"{fields.estimated.rms_um:.1f} um as estimated, {fields.reduced.rms_um:.1f} um after the perspective "
            f"reduction (true: {fields.true.rms_um:.1f} and {fields.true_reduced.rms_um:.1f} um).\n"
        )
    yield (
        "The perspective reduction takes the tilt of a camera, (c + x^2/c, xy/c) and (xy/c, c + y^2/c), and a shift "
        "of the principal point out of the vectors by least squares over the grid; derivation in "
        "`studies/comparison/perspective.py`. Distortions are those contained in the measurement, radial ones positive "
        "outward.\n"
    )


def _closing(found: MauelshagenFindings, command: str) -> Iterator[str]:
    yield "## 7  Again\n"
    yield f"    {command}\n"
    yield (
        "writes this folder; the figures do not depend on the number of processes. Version, commit, parameters, "
        "packages and duration are in `provenance.json`. Every figure is there as SVG and as PNG.\n"
    )
