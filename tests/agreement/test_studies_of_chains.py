"""A study whose images go through the measurement chain gives, trial by trial, what the readable chain gives."""

from __future__ import annotations

import numpy as np
import pytest

from adjust import adjust_block
from adjust.reductions.reduction import reduce
from simfield import build_world
from simfield.block import Block, ImageObservations
from simfield.chain.measure import prepare
from studies.design.plan import Plan
from studies.design.study import Study, StudyError
from studies.design.study_file import study_from_text
from studies.trials.block_of_trials import compute
from studies.trials.measured_world import MeasuredWorld, world_of

AGREES_MM = 1e-9
AGREES_UM = 1e-6
"""of m0: the chord stops at 1e-8 standard deviations of every unknown"""
STANDARD_ERRORS = 4.5
"""of all coordinates of a block at once, largest of several thousand"""
TEXT = """
[study]
name = "chains"
question = "Is it the same?"
seed = 3

[trials]
max = 64
block = 32

[scenario]
preset = "grid-small"
{said}

[grid]
{grid}

[methods]
ap = ["none", "brown14"]

[report]
measures = ["m0_um"]
"""
PSK = 'chain = "psk-1969"'


def study(said: str = PSK, grid: str = "noise_um = [3.0]") -> Study:
    return study_from_text(TEXT.format(said=said, grid=grid))


@pytest.mark.parametrize(
    ("said", "grid"),
    [
        (PSK, "noise_um = [3.0]"),
        (PSK + '\nreductions = {inner = "helmert", lens = false}', "film_field_um = [3.0]"),
        (PSK, 'chain_without = [["lens", "refraction"]]'),
        ("", 'chain = ["psk-1969"]'),
        (PSK, '"chain.errors.gross_rate" = [0.02]\n"reductions.curvature" = [false]'),
    ],
)
def test_trials_are_those_of_the_readable_chain(said: str, grid: str) -> None:
    plan = Plan.of(study(said, grid))
    (condition,) = plan.conditions
    world = world_of(condition)
    assert isinstance(world, MeasuredWorld)
    assert condition.measuring is not None
    plain = build_world(condition.scenario, condition.seed)
    columns, _, reasons = compute(plan.task(condition, 1, {}))
    assert not reasons
    m0_um = columns[f"{plan.methods[0].key}|m0_um"]
    for trial in (32, 45, 63):
        measured = reduce(prepare(plain, condition.measuring.chain).measure(trial), condition.measuring.plan).block
        assert abs(world.draws(32, 64)[:][trial - 32] - measured.observations.xy).max() < AGREES_MM
        assert abs(world.image_points(trial) - measured.observations.xy).max() < AGREES_MM
        own = plain.block(measured.observations.xy, trial)
        assert m0_um[trial - 32] == pytest.approx(adjust_block(own).m0_um, abs=AGREES_UM)


def test_what_is_not_chance_is_the_mean_of_many() -> None:
    (condition,) = Plan.of(study()).conditions
    world = world_of(condition)
    drawn = world.draws(0, 512)[:]
    spread = drawn.std(axis=0, ddof=1) / np.sqrt(len(drawn))
    assert (abs(drawn.mean(axis=0) - world.distorted) / spread).max() < STANDARD_ERRORS
    assert np.abs(world.distorted - build_world(condition.scenario, condition.seed).distorted).max() > AGREES_MM


def test_a_stage_that_is_left_out_takes_its_reduction_with_it() -> None:
    conditions = Plan.of(study(grid='chain_without = [{label = "nothing", value = []}, "refraction"]')).conditions
    measuring = [c.measuring for c in conditions]
    assert [m and m.plan.refraction for m in measuring] == [True, False]
    assert [m and m.chain.air.refraction for m in measuring] == [True, False]
    assert len({c.id for c in conditions}) == len({c.seed for c in conditions}) == 2
    assert conditions[0].columns == {"chain_without": "nothing"}


def test_a_whole_chain_comes_before_its_values() -> None:
    (condition,) = Plan.of(study("", 'film_field_um = [5.0]\nchain = ["psk-1969"]')).conditions
    assert condition.measuring is not None
    assert condition.measuring.chain.film_field is not None
    assert condition.measuring.chain.film_field.sigma_um == 5.0


def test_without_a_chain_nothing_is_said_of_one() -> None:
    plan = Plan.of(study("", "noise_um = [3.0]"))
    assert "chain" not in plan.base
    assert plan.conditions[0].measuring is None
    assert not isinstance(world_of(plan.conditions[0]), MeasuredWorld)


@pytest.mark.parametrize(
    ("said", "grid", "line"),
    [
        (
            'chain = "psk-1970"',
            "noise_um = [3.0]",
            'scenario.chain: found "psk-1970", allowed: undisturbed, psk-1969',
        ),
        ("chain = 7", "noise_um = [3.0]", "scenario.chain: found 7, allowed: the name of a chain, or a table"),
        ("chain = {air = {wind = 3.0}}", "noise_um = [3.0]", "scenario.chain.air.wind: unknown key"),
        ("chain = {film = 3.0}", "noise_um = [3.0]", "scenario.chain.film: unknown key"),
        (
            'chain = {without = "lense"}',
            "noise_um = [3.0]",
            'scenario.chain.without: found "lense", allowed: refraction, ',
        ),
        ("chain = {without = 3}", "noise_um = [3.0]", "scenario.chain.without: found 3, allowed: stages"),
        ("chain = {errors = {missed_rate = 0.1}}", "noise_um = [3.0]", "scenario.chain.errors.missed_rate: found 0.1"),
        (
            "chain = {errors = {gross_rate = 2.0}}",
            "noise_um = [3.0]",
            "scenario.chain.errors: rates of errors are shares",
        ),
        (
            PSK + "\nreductions = {inner = 3}",
            "noise_um = [3.0]",
            "scenario.reductions.inner: found 3, allowed: 'helmert'",
        ),
        (PSK + "\nreductions = {lenses = true}", "noise_um = [3.0]", "scenario.reductions.lenses: unknown key"),
        (PSK + "\nreductions = 7", "noise_um = [3.0]", "scenario.reductions: found 7, allowed: a table"),
        ("reductions = {lens = true}", "noise_um = [3.0]", "scenario.reductions: there is no chain to reduce"),
        ("", "film_field_um = [3.0]", "grid.film_field_um[0]: chain.film_field.sigma_um: there is no chain"),
        (
            PSK,
            "film_field_um = [-3.0]",
            "condition film_field_um = -3.0: chain.film_field: a random field needs sigma_um",
        ),
        (PSK, '"reductions.inner" = ["round"]', 'grid.reductions.inner[0]: reductions.inner: found "round"'),
        (PSK, 'chain = ["psk-1969", "psk"]', 'grid.chain[1]: chain: found "psk", allowed: '),
    ],
)
def test_a_wrong_chain_is_named_in_a_line(said: str, grid: str, line: str) -> None:
    with pytest.raises(StudyError) as error:
        study(said, grid)
    assert any(found.startswith(line) for found in str(error.value).splitlines()), str(error.value)


def test_the_noise_free_block_of_a_method_is_the_measured_one() -> None:
    plan = Plan.of(study())
    (condition,) = plan.conditions
    _, nominal, _ = compute(plan.task(condition, 0, {}))
    world = world_of(condition)
    o = world.observe(0)[0]
    same = Block(
        o.cameras,
        o.images,
        o.points,
        ImageObservations(o.observations.image, o.observations.point, world.distorted, o.observations.sigma),
    )
    assert nominal  # the constants of the nominal adjustment
    assert adjust_block(same).m0_um < adjust_block(o).m0_um
