"""The twin: what first-order propagation expects is what simulation finds; the measured file goes round."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from simfield import build_world, presets, read_block
from simfield.chain.measure import prepare
from simfield.chain.presets import STAGES, chains
from simfield.files.raw_folder import read_raw, write_raw
from studies.commands import blocks
from studies.commands.program import main
from studies.experiments import published
from studies.experiments.mauelshagen_1980.experiment import Row
from studies.experiments.mauelshagen_1980.trials import run_trials
from studies.experiments.mauelshagen_1980_twin import ap_sets, drawings, fixed, variances
from studies.experiments.mauelshagen_1980_twin.components import Component, all_components, scenario_with
from studies.experiments.mauelshagen_1980_twin.findings import Twin
from studies.experiments.mauelshagen_1980_twin.propagation import LinearRow, expected_squares

TRIALS = 192
ROW = Row("torlegard", "sww", False)


@pytest.fixture(scope="module")
def linear():
    return LinearRow.of(build_world(presets["rheidt-1980"], 1980), ROW)


@pytest.mark.parametrize(
    "component",
    [
        Component("noise", "sww"),
        Component("film", "sww", "cubic", "image"),
        Component("film", "sww", "quadratic", "flight"),
        Component("film", "sww", "affinity", "camera"),
        Component("geodetic"),
    ],
    ids=str,
)
def test_expected_squares_are_those_of_simulated_experiments(linear, component):
    size = 6.0
    sizes = [(component, size)]
    if component.kind != "noise":
        sizes += [(Component("noise", c), 1e-3) for c in ("sww", "ww")]
    else:
        sizes += [(Component("noise", "ww"), 1.0)]
    base = replace(presets["rheidt-1980"], effects=())
    flown = run_trials(build_world(scenario_with(base, "test", sizes), 1980), [ROW], TRIALS, 1, lambda _: None)
    squares = flown[["m0_um", "mu_xy_mm", "mu_z_mm"]].to_numpy(float) ** 2
    expected = linear.expected(component) * size**2
    standard_error = squares.std(axis=0) / np.sqrt(TRIALS)
    # 1e-4 um^2, mm^2: noise of 0.001 um, added where the component is no noise
    assert (np.abs(squares.mean(axis=0) - expected) < 4.0 * standard_error + 0.01 * expected + 1e-4).all()


def test_the_fit_finds_sizes_again(linear):
    components = [c for c in all_components() if c.kind != "film" and c.camera != "ww"]
    components.append(Component("film", "sww", "quadratic", "image"))
    expected = expected_squares([linear], components)
    worlds = variances.sampled([linear], components, 40, 3)
    true = np.array([5.0, 9.0, 6.0])
    fit = variances.fit(np.sqrt(expected @ true**2), expected, worlds, components)
    np.testing.assert_allclose(fit.first, true, rtol=1e-6)
    assert fit.inside == 3
    logs, slopes = worlds.logs(true)
    raised, _ = worlds.logs(true + [0.0, 1e-6, 0.0])
    np.testing.assert_allclose((raised - logs) / 1e-6, slopes[:, :, 1], rtol=1e-3, atol=1e-6)


def test_terms_of_a_fixed_world_are_its_effects():
    world = build_world(presets["rheidt-1980"], 1980)
    terms = (fixed.Term("ww", 0, 0), fixed.Term("sww-after", 1, 6), fixed.Term("ww", 1, 4))
    found = fixed.FixedWorld(terms, np.array([5.0, -3.0, 2.0]), np.zeros(3), np.zeros(3), np.zeros(3))
    fields = fixed._fields(world, terms) @ found.sizes
    total = np.zeros_like(world.distorted)
    for on in fixed.effects_of(found, world):
        acts = [
            on.acts_on(*n) for n in zip(world.plan.camera_ids, world.plan.flight_ids, world.plan.image_ids, strict=True)
        ]
        rows = np.array(acts)[world.image]
        total[rows] += on.effect.displacement(world.distorted[rows])
    np.testing.assert_allclose(total.ravel(), fields, rtol=0, atol=1e-15)


def test_the_f_test_counts_what_the_finer_choice_adds():
    world = build_world(presets["rheidt-1980"], 5)
    steps = ap_sets._steps(world.observe(0)[0], "torlegard")
    assert [step.test.k for step in steps] == [12, 54, 156]


def test_the_measured_file_goes_round(tmp_path):
    raw = prepare(build_world(presets["rheidt-1980"], 6), chains["psk-1969"]).measure(0)
    write_raw(raw, tmp_path / "raw")
    again = read_raw(tmp_path / "raw")
    for name in ("settings", "time", "mark_image", "mark", "mark_time", "mark_settings", "heights"):
        np.testing.assert_array_equal(getattr(again, name), getattr(raw, name))
    assert again.mark_ids == raw.mark_ids
    assert again.machine == raw.machine
    np.testing.assert_array_equal(again.block.observations.point, raw.block.observations.point)


def test_simulate_raw_and_reduce(tmp_path):
    raw, block = str(tmp_path / "raw"), str(tmp_path / "block")
    run = CliRunner()
    assert run.invoke(main, ["simulate", "rheidt-1980", "--seed", "1", "--raw", "-o", raw]).exit_code == 0
    reduced = run.invoke(main, ["reduce", raw, "-o", block, "--without", "lens"])
    assert reduced.exit_code == 0, reduced.output
    assert "refraction" in reduced.output
    assert "lens" not in reduced.output
    assert len(read_block(block).observations) == 3313
    (tmp_path / "raw" / "marks.csv").unlink()
    assert run.invoke(main, ["reduce", raw, "-o", block]).exit_code == 1


@pytest.mark.slow
def test_the_twin_is_written(tmp_path):
    done = CliRunner().invoke(
        main,
        ["reproduce", "mauelshagen-1980", "--world", "twin", "--trials", "20", "--jobs", "1", "--out", str(tmp_path)],
    )
    assert done.exit_code == 0, done.output
    assert {"table1.csv", "table1-fixed.csv", "located.png", "report.md", "provenance.json"} <= {
        f.name for f in tmp_path.iterdir()
    }


def test_stages_left_out_and_sets_by_flight_from_the_command_line(tmp_path):
    raw, block, run = str(tmp_path / "raw"), str(tmp_path / "block"), CliRunner()
    assert set(blocks.stages()) == set(STAGES)
    lacking = ["--without", "refraction", "--without", "curvature", "--without", "settings"]
    done = run.invoke(main, ["simulate", "rheidt-1980", "--seed", "1", "--raw", *lacking, "-o", raw])
    assert done.exit_code == 0, done.output
    assert run.invoke(main, ["simulate", "rheidt-1980", "--seed", "1", *lacking, "-o", raw]).exit_code == 2
    kept = ["--without", "refraction", "--without", "curvature"]
    done = run.invoke(main, ["reduce", raw, "-o", block, *kept])
    assert "one setting            0.00 um" in done.output
    done = run.invoke(main, ["adjust", block, "--ap", "optical", "--ap-by", "flight"])
    assert done.exit_code == 0, done.output
    assert "one AP set a flight against one a camera: F = " in done.output
    assert "ww-after" in done.output


def test_the_figure_of_the_twin_shows_all_published_figures():
    table = published.mauelshagen_table1()
    for column in ("m0_um", "mu_xy_mm", "mu_xy_coordinate_mm", "mu_z_mm"):
        for part in ("", "_lo", "_hi"):
            table[f"sim_{column}{part}"] = 1.0
    twin = Twin("coordinate", None, None, None, None, None, table, table)
    figure = drawings.located(twin)
    drawn = [axes.lines[-3].get_xdata() for axes in figure.axes]
    for found, column in zip(drawn, ("m0_um", "mu_xy_mm", "mu_z_mm"), strict=True):
        np.testing.assert_array_equal(found, table[column])
