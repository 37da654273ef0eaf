"""The figures of the gallery, each put together from parts of one simulated experiment."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from adjust import Adjustment, Replicates, adjust_block, adjust_replicates, ap_models
from simfield import Truth, World, build_world, presets
from simfield.block import Block, Floats
from simfield.scenario import changed
from studies import figures
from studies.comparison import CONFIDENCE, block_views, distortion_found
from studies.experiments.mauelshagen_1980 import drawings, experiment, table1, trials
from studies.figures import new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEED, TRIALS, FLIGHTS = 1980, 512, 20
CAMERA, MODEL = "ww", "brown14"


class Example:
    """The experiment of 1980, flown once and adjusted; each part is computed when a figure asks for it."""

    @cached_property
    def world(self) -> World:
        return build_world(presets["rheidt-1980"], SEED)

    @cached_property
    def flown(self) -> tuple[Block, Truth]:
        return self.world.observe(0)

    @property
    def block(self) -> Block:
        return self.flown[0]

    @property
    def truth(self) -> Truth:
        return self.flown[1]

    @cached_property
    def wide(self) -> Block:
        """The block of the wide-angle camera alone."""
        return self.block.select(cameras=[CAMERA])

    def adjusted(self, model: str) -> Adjustment:
        return adjust_block(self.block, ap_models.get(model))

    @cached_property
    def both(self) -> Adjustment:
        return self.adjusted("optical")

    @cached_property
    def full(self) -> Adjustment:
        return self.adjusted(MODEL)

    def many(self, model: str) -> Replicates:
        return adjust_replicates(self.block, ap_models.get(model), self.world.draws(0, TRIALS))


def plan(example: Example) -> Figure:
    figure = new_figure(110, 125)
    figures.field_plan(figure.subplots(), example.block, block_views.footprints(example.block))
    return figure


def rays(example: Example) -> Figure:
    figure = new_figure(110, 92)
    axes = figure.subplots()
    marks = figures.rays_per_point(axes, example.block.points.coordinates[:, :2], example.block.rays)
    figures.rays_bar(figure, axes, marks)
    return figure


def radii(example: Example) -> Figure:
    o, edges = example.wide.observations, np.arange(0.0, 171.0, 10.0)
    main = np.isin(example.wide.points.ids, example.truth.main_points)[o.point]
    counts = {
        label: np.histogram(np.hypot(*o.xy[used].T), edges)[0].astype(float)
        for label, used in {"with auxiliary points": main | True, "without": main}.items()
    }
    figure = new_figure(110, 80)
    figures.radius_histogram(figure.subplots(), counts, edges)
    return figure


def curve(example: Example) -> Figure:
    figure = new_figure(110, 85)
    others = {f"from {MODEL}": distortion_found.radial_curve(example.full, CAMERA, example.truth)}
    figures.radial_curve(figure.subplots(), distortion_found.radial_curve(example.both, CAMERA, example.truth), others)
    return figure


def decentering(example: Example) -> Figure:
    fields = distortion_found.decentering_fields(example.both, CAMERA, example.truth)
    figure = new_figure(110, 118)
    figures.vectors(figure.subplots(), fields.estimated, fields.true, 10.0)
    return figure


def residuals(example: Example) -> Figure:
    figure = new_figure(110, 118)
    figures.vectors(figure.subplots(), block_views.mean_residuals(example.both, CAMERA), None, 5.0)
    return figure


def correlations(example: Example) -> Figure:
    r, names = example.full.ap_correlation(CAMERA), example.full.ap[CAMERA].names
    figure = new_figure(110, 100)
    axes = figure.subplots()
    mesh = figures.correlation_matrix(axes, r, r, names)
    figure.colorbar(mesh, ax=axes, shrink=0.8, label="correlation")
    return figure


def with_exterior(example: Example) -> Figure:
    model = ap_models.get("optical", r0_mm=0.0)
    a = adjust_block(example.block, model)
    image = next(i for i, camera in zip(a.images.ids, example.truth.camera_ids, strict=True) if camera == CAMERA)
    figure = new_figure(110, 65)
    axes = figure.subplots()
    names = (a.ap[CAMERA].names, a.images.names)
    mesh = figures.correlation_rectangle(axes, block_views.ap_exterior_correlations(a, CAMERA, image), *names)
    axes.set_xlabel(f"exterior orientation of image {image}")
    figure.colorbar(mesh, ax=axes, shrink=0.9, label="correlation")
    return figure


def ellipses(example: Example) -> Figure:
    central = np.isin(example.block.points.ids, np.array(example.truth.point_ids)[example.truth.central])
    figure = new_figure(110, 112)
    errors = block_views.point_errors(example.both, central & (example.block.points.role != "control"))
    figures.error_ellipses(figure.subplots(), errors, 20.0, 100.0)
    return figure


def redundancy(example: Example) -> Figure:
    series: dict[str, tuple[Floats, Floats]] = {}
    adjusted = [adjust_block(block, ap_models.get("optical")) for block in _growing(example)]
    for column, name in enumerate(adjusted[0].ap[CAMERA].names):
        x = np.array([float(a.redundancy) for a in adjusted])
        y = np.array([a.ap[CAMERA].std[column] for a in adjusted])
        series[name] = (x, y / y[0])
    figure = new_figure(110, 90)
    axes = figure.subplots()
    figures.falling_errors(axes, series, dashed=False)
    axes.set(xlabel="redundancy", ylabel="standard error, 1 for the smallest block")
    axes.set_xticks([200, 500, 1000, 2000, 4000], ["200", "500", "1000", "2000", "4000"])
    axes.set_yticks([0.2, 0.5, 1.0], ["0.2", "0.5", "1"])
    axes.minorticks_off()
    axes.legend()
    return figure


def _growing(example: Example) -> list[Block]:
    """Ever more points a group and more images: one, two, all points; each without and with the first flight."""
    main = example.wide.select(points=example.truth.main_points)
    flights = {i: f for i, f in zip(example.truth.image_ids, example.truth.flight_ids, strict=True) if f[:2] == CAMERA}
    before = [i for i, flight in flights.items() if flight == "ww-before"]
    return [main.select(images=before), main, example.wide.select(images=before), example.wide]


def coverage(example: Example) -> Figure:
    """With the set that lacks what the film did."""
    from scipy.special import stdtrit

    r = example.many("optical")
    point = int(np.flatnonzero(np.asarray(example.block.points.role) != "control")[0])
    true = example.truth.coordinates[example.truth.point_ids.index(example.block.points.ids[point])]
    column = r.nominal.layout.orientation + 3 * point
    t = float(stdtrit(r.nominal.redundancy, 0.5 + CONFIDENCE / 2.0))
    figure = new_figure(110, 110)
    error = r.points[:, point, 2] - true[2]
    figures.zip_plot(figure.subplots(), error, r.std[:, column + 2], t)
    return figure


def biases(example: Example) -> Figure:
    r = example.many("torlegard")
    image = example.block.images.ids.index(next(i for i in example.truth.image_ids if i.startswith(CAMERA)))
    error = r.images[:, image] - example.truth.exterior[image]
    spread = error.std(axis=0, ddof=1)
    figure = new_figure(110, 80)
    figures.lollipops(
        figure.subplots(), r.nominal.images.names, error.mean(axis=0) / spread, np.full(6, len(r) ** -0.5),
        "bias / standard deviation of the estimate",
    )  # fmt: skip
    return figure


def many_factors(example: Example) -> Figure:
    """Eighteen blocks without noise; the standard errors that their adjustments claim for a height."""
    levels = [(g, h, s) for g in (1, 2, 3) for h in (1, 2, 4) for s in (1, 2)]
    series: dict[str, list[float]] = {"optical": [], MODEL: []}
    for group, headings, strips in levels:
        flight = {
            "flight_id": "ww", "camera_id": "ww", "scale": 10500.0, "sidelap": 0.95, "strips": strips,
            "headings_gon": [100.0 * n for n in range(headings)],
        }  # fmt: skip
        changes = {"flights": [flight], "measurement.counts": {}, "field.group_size": group}
        block, _ = build_world(changed(presets["rheidt-1980"], changes), SEED).observe(0)
        for model, found in series.items():
            a = adjust_block(block, ap_models.get(model))
            found.append(float(1000.0 * np.sqrt(np.mean(a.points.std[block.points.role == "check", 2] ** 2))))
    names = ("points a group", "headings", "strips")
    factors = {name: [str(level[n]) for level in levels] for n, name in enumerate(names)}
    figure = new_figure(130, 100)
    curves = {name: np.array(values) for name, values in series.items()}
    figures.nested_loop(figure.subplots(), factors, curves, "standard error of a height, mm", log=True)
    return figure


def published(example: Example) -> Figure:
    rows = experiment.rows()
    return drawings.table1_figure(
        {"rheidt-1980": table1.table1(rows, trials.run_trials(example.world, rows, FLIGHTS, 1, lambda n: None))}
    )


def over_a_factor(example: Example) -> Figure:
    """Correlations of the radial coefficients with Z0 of an image, from trials, over the place of the second zero."""
    places = np.array([0.0, 40.0, 60.0, 80.0, 100.0, 120.0, 140.0])
    draws = wide_draws(example)
    found = [adjust_replicates(example.wide, ap_models.get("optical", r0_mm=r0), draws) for r0 in places]
    series = {}
    for column, name in enumerate(("a3", "a4")):
        r = np.array([np.corrcoef(each.ap(CAMERA)[:, column], each.images[:, 1, 2])[0, 1] for each in found])
        series[f"R({name}, Z0)"] = (places, r, (1.0 - r**2) / np.sqrt(len(draws)))
    figure = new_figure(110, 85)
    axes = figure.subplots()
    figures.measure_over_factor(axes, series, [], "second zero r0, mm", "correlation over trials", "1")
    axes.legend()
    return figure


def wide_draws(example: Example) -> Floats:
    """(t, k, 2) trials of the wide-angle images."""
    number = next(n for n, camera in enumerate(example.block.cameras) if camera.camera_id == CAMERA)
    own = example.block.images.camera[example.block.observations.image] == number
    return np.asarray(example.world.draws(0, TRIALS)[slice(0, TRIALS)][:, own])
