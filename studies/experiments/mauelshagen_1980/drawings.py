"""The figures of the reproduction, put together from their data; nothing is computed and nothing written here."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from simfield.block import Block, Floats
from studies import figures
from studies.comparison import DecenteringFields, PointErrors, RadialCurve, block_views
from studies.experiments.mauelshagen_1980 import table2
from studies.experiments.mauelshagen_1980.experiment import BOTH, CAMERA_TITLES, CAMERAS, SECTIONS
from studies.figures import COLOURS, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

VECTOR_UNIT_UM = 10.0
"""the paper's"""
REDUCED_UNIT_UM = 2.0
"""five times larger, for what is left is small"""
ELLIPSE_UNIT_MM, ELLIPSE_UNIT_GROUND_M = 20.0, 100.0
AUX = {False: "without auxiliary points", True: "with auxiliary points"}


ALTERNATIVE: Mapping[str, tuple[str, str]] = {
    "plan": (
        "Plan of the field",
        "Left: 41 groups of points with five control points, and the outlines of 39 images on the ground. Right: the "
        "points, coloured by the number of images in which they were measured.",
    ),
    "ellipses": (
        "Errors of the points",
        "One-sigma error ellipses and height bars of one point a group, from model 3.1 and from model 3.3, both "
        "cameras with auxiliary points; they grow towards the edge.",
    ),
    "table1": (
        "Table 1, published and simulated",
        "m0, mu_xy and mu_z of the 18 adjustments: published values as diamonds, mean and 95 % range of the simulated "
        "flights of two worlds as dots and bars.",
    ),
    "table2_sww": (
        "Table 2 and the camera SWW",
        "Heat maps of the correlations of b1 to b14, without and with auxiliary points: simulated above the diagonal, "
        "published below.",
    ),
    "table2_ww": (
        "Table 2 and the camera WW",
        "Heat maps of the correlations of b1 to b14, without and with auxiliary points: simulated above the diagonal, "
        "published below.",
    ),
    "erratum": (
        "Which terms the program had",
        "Rms difference to the published Table 2 for four forms of the model: Brown's terms are nearest in every case, "
        "the terms as printed farthest.",
    ),
    "z0_correlations": (
        "Correlation of the flying height with a3 and a4",
        "Mean amount of the correlation over the place of the second zero, for all images and for the middle ones; it "
        "is large for 0 mm and falls towards 100 mm.",
    ),
    "standard_errors": (
        "Standard errors against redundancy",
        "Standard errors of the parameters of model 3.1; each line goes from without to with auxiliary points, and all "
        "fall.",
    ),
    "figure1": ("Figure 1", "Points of a full image by their radius, with and without auxiliary points, two cameras."),
    "figure2": (
        "Figure 2, SWW",
        "Radial distortion, true and from the additional parameters with its standard deviation, and the vectors of "
        "decentering as estimated and without the camera's tilt, on top of the true ones in grey.",
    ),
    "figure3": (
        "Figure 3, WW",
        "Radial distortion, true and from the additional parameters with its standard deviation, and the vectors of "
        "decentering as estimated and without the camera's tilt, on top of the true ones in grey.",
    ),
}
"""title and description of every figure, for those who cannot see it"""


def plan_figure(block: Block) -> Figure:
    """The field with the footprints of the images, and the rays per point."""
    figure = new_figure(210, 118)
    left, right = figure.subplots(1, 2)
    figures.field_plan(left, block, block_views.footprints(block))
    marks = figures.rays_per_point(right, block.points.coordinates[:, :2], block.rays)
    figures.rays_bar(figure, right, marks, shrink=0.7)
    return figure


def ellipses_figure(errors: Mapping[str, PointErrors]) -> Figure:
    """Error ellipses and height bars, a panel for each model."""
    figure = new_figure(210, 132)
    panels = figure.subplots(1, len(errors), sharey=True)
    for axes, (model, found) in zip(panels, errors.items(), strict=True):
        figures.error_ellipses(axes, found, ELLIPSE_UNIT_MM, ELLIPSE_UNIT_GROUND_M)
        axes.set_title(f"model {SECTIONS[model]} {model}", pad=24.0)
    panels[-1].set_ylabel("")
    return figure


def table1_figure(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Table 1 as ranges; one table for each simulated world."""
    first = next(iter(tables.values()))
    labels = [
        f"{SECTIONS[m]} {m}, {b.replace('+', ' + ').upper()}, {'with' if aux else 'without'}"
        for m, b, aux in first[["model", "block", "aux_points"]].to_numpy().tolist()
    ]
    figure = new_figure(210, 125)
    panels = figure.subplots(1, 3, sharey=True)
    titles = {"m0_um": "m0, µm", "mu_xy_mm": "mu_xy (2-D), mm", "mu_z_mm": "mu_z, mm"}
    for axes, (name, title) in zip(panels, titles.items(), strict=True):
        simulated = {
            world: tuple(t[f"sim_{name}{part}"].to_numpy(float) for part in ("", "_lo", "_hi"))
            for world, t in tables.items()
        }
        figures.ranges(axes, labels, first[name].to_numpy(float), simulated)
        for edge in (5.5, 11.5):
            axes.axhline(edge, color="#d8d8d8", linewidth=0.7)
        axes.set_title(title)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def table2_figure(table: pd.DataFrame, camera: str, rms: pd.DataFrame) -> Figure:
    """Heat maps of Table 2: simulated above the diagonal, published below."""
    figure = new_figure(210, 106)
    panels = figure.subplots(1, 2)
    for axes, aux in zip(panels, AUX, strict=True):
        simulated, paper = (table2.matrix(table, aux, camera, "corrected", c) for c in ("simulated", "published"))
        mesh = figures.correlation_matrix(axes, simulated, paper, [f"b{i + 1}" for i in range(len(paper))])
        fit = rms[(rms["variant"] == "corrected") & (rms["aux_points"] == aux) & (rms["camera"] == camera)]
        axes.set_title(f"{AUX[aux]}\nrms difference {fit['as_labelled'].iloc[0]:.3f}")
    figure.colorbar(mesh, ax=panels, shrink=0.75, label="correlation")
    figure.suptitle(f"{CAMERA_TITLES[camera]}: simulated above the diagonal, published below (hundredths)", fontsize=10)
    return figure


def erratum_figure(rms: pd.DataFrame) -> Figure:
    """How far each form of the model is from the published Table 2."""
    figure = new_figure(150, 75)
    axes = figure.subplots()
    names = {
        "corrected": "Brown's terms",
        "b4_only": "b4 corrected alone",
        "sign_only": "sign corrected alone",
        "as_printed": "as printed",
    }
    groups = [(camera, aux) for camera in CAMERAS for aux in AUX]
    for number, ((camera, aux), colour) in enumerate(zip(groups, COLOURS, strict=False)):
        chosen = rms[(rms["camera"] == camera) & (rms["aux_points"] == aux)].set_index("variant")
        places = np.arange(len(names)) + 0.2 * (number - 1.5)
        label = f"{camera.upper()}, {AUX[aux]}"
        axes.bar(places, chosen.loc[list(names), "as_labelled"], width=0.18, color=colour, label=label)
    axes.set_xticks(np.arange(len(names)), list(names.values()))
    axes.set(ylabel="rms difference to Table 2 (91 pairs)")
    axes.legend(loc="upper left", fontsize=7.5)
    return figure


def z0_figure(curves: pd.DataFrame) -> Figure:
    """Correlations of Z0 with a3 and a4 against the second zero."""
    figure = new_figure(190, 85)
    panels = figure.subplots(1, 2, sharey=True)
    for axes, camera in zip(panels, CAMERAS, strict=True):
        chosen = curves[(curves["camera"] == camera) & curves["aux_points"]]
        series = {
            f"R(Z0,{name}), {images} images": part.sort_values("r0_mm")["mean_abs_r"].to_numpy(float)
            for (name, images), part in chosen.groupby(["parameter", "images"])
        }
        figures.lines(axes, np.unique(chosen["r0_mm"].to_numpy(float)), series)
        axes.axvline(100.0, color="#9a9a9a", linewidth=0.7)
        axes.set(title=CAMERA_TITLES[camera], xlabel="second zero r0, mm", xlim=(0, 140), ylim=(0, 1))
        axes.grid(True)
    panels[0].set_ylabel("mean |R|, with auxiliary points")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=7.5)
    return figure


def errors_figure(errors: pd.DataFrame) -> Figure:
    """Standard errors of model 3.1 against redundancy: each line goes from without to with auxiliary points."""
    figure = new_figure(190, 92)
    panels = figure.subplots(1, 2, sharey=True)
    for axes, camera in zip(panels, CAMERAS, strict=True):
        for block, how in ((camera, "camera alone"), (BOTH, "both cameras")):
            chosen = errors[(errors["camera"] == camera) & (errors["model"] == "optical") & (errors["block"] == block)]
            series = {
                f"{name}, {how}": (part["redundancy"].to_numpy(float), part["effect_um"].to_numpy(float))
                for name, part in chosen.groupby("parameter")
            }
            figures.falling_errors(axes, series, dashed=block != BOTH)
        axes.set(title=CAMERA_TITLES[camera], xlabel="redundancy", xlim=(500, 8000), ylim=(0.3, 2.0))
        axes.set_xticks([500, 1000, 2000, 5000], ["500", "1000", "2000", "5000"])
        axes.set_yticks([0.3, 0.5, 1.0, 2.0], ["0.3", "0.5", "1", "2"])
        axes.minorticks_off()
    panels[0].set_ylabel("standard error of the parameter,\nas rms displacement over the format, µm")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=7.5)
    return figure


def figure1(counts: Mapping[str, Mapping[str, Floats]], edges_mm: Floats) -> Figure:
    """Figure 1: points by radius in a full image, for each camera."""
    figure = new_figure(190, 75)
    panels = figure.subplots(1, len(counts), sharey=True)
    for axes, (camera, series) in zip(panels, counts.items(), strict=True):
        figures.radius_histogram(axes, series, edges_mm)
        axes.set_title(f"{CAMERA_TITLES[camera]}, mean of the middle images")
    panels[1].set_ylabel("")
    return figure


def distortion_figure(curves: Mapping[str, RadialCurve], fields: DecenteringFields) -> Figure:
    """Figures 2 and 3: a true radial distortion, b from the additional parameters, c decentering, d reduced."""
    curve = curves[fields.model]
    figure = new_figure(190, 195)
    (a, b), (c, d) = figure.subplots(2, 2, height_ratios=(1, 1.35))
    figures.true_radial_curve(a, curve)
    figures.radial_curve(b, curve, {f"from model {SECTIONS[m]}": o for m, o in curves.items() if m != fields.model})
    limit = 1.1 * max(np.abs([*a.get_ylim(), *b.get_ylim()]))
    for axes in (a, b):
        axes.set_ylim(-limit, limit)
    a.set_title("a  radial-symmetric, true")
    b.set_title(f"b  radial-symmetric, from model {SECTIONS[curve.model]}")
    figures.vectors(c, fields.estimated, fields.true, VECTOR_UNIT_UM)
    figures.vectors(d, fields.reduced, fields.true_reduced, REDUCED_UNIT_UM)
    phi, omega = fields.tilt_deg * 3600.0
    c.set_title("c  decentering as estimated (grey: true)")
    d.set_title(f"d  the same without the tilt of {phi:.0f}″ and {omega:.0f}″".replace("-", "−"))
    figure.suptitle(f"{CAMERA_TITLES[curve.camera]}, simultaneous adjustment with auxiliary points", fontsize=10)
    return figure
