"""Methods ranked within a condition, and what sets are chosen by."""

from __future__ import annotations

import numpy as np
import pytest

from adjust import adjust_block, ap_models
from adjust.model.unknowns import EXTERIOR_NAMES
from adjust.quality import model_choice
from adjust.quality.significance import ap_significance
from simfield import build_world, presets
from studies.design.methods import Method
from studies.summary import ranking
from studies.summary.cells import Cell, measured
from studies.trials.parts import MethodBlock, noise_free_block
from studies.trials.trial_columns import Tracked, nominal_columns, trial_columns

KEY = "m"


def rows(values: dict[str, dict[str, float]]) -> list[dict[str, object]]:
    return [
        {"condition": "c", "method": f"{method}, cameras all, with aux", "measure": measure, "estimate": v, "mcse": 0.1}
        for method, measures in values.items()
        for measure, v in measures.items()
    ]


def test_the_best_comes_first_and_criteria_count_from_their_smallest() -> None:
    values = {"a x=1,2": {"z": 3.0, "aic": 107.0}, "b": {"z": 2.0, "aic": 100.0}, "c": {"z": float("nan")}}
    lines = list(ranking.tables(rows(values), rows({"a x=1,2": {"z": 1.0}}), ["aic", "z"], "z"))
    assert lines == [
        "| rank | method | z | difference | aic |",
        "| --- | --- | ---: | ---: | ---: |",
        "| 1 | b | 2 | – | 0 |",
        "| 2 | a x=1,2 | 3 | +1.00 ± 0.10 | 7 |",
        "",
    ]


def test_ranks_that_the_trials_do_not_rule_out() -> None:
    """Errors of 0.1 and three pairs: apart from 2.39 x 0.2 on."""
    values = {"a": {"z": 1.0}, "b": {"z": 1.4}, "c": {"z": 2.0}}
    lines = list(ranking.tables(rows(values), [], ["z"], "z"))
    ranks = [line.split("|")[1].strip() for line in lines[2:-1]]
    assert ranks == ["1 (1–2)", "2 (1–2)", "3"]


def test_pairs_on_the_same_trials_tell_more_apart() -> None:
    """What all share makes the errors of the values large and those of the differences small."""
    value, error = np.array([1.0, 1.05, 1.2]), np.full(3, 0.5)
    best, worst = ranking.possible_ranks(value, error, np.array([np.nan, 0.01, 0.01]))
    assert best.tolist() == [1, 2, 3]
    assert worst.tolist() == [1, 2, 3]
    best, worst = ranking.possible_ranks(value, error, np.full(3, np.nan))
    assert best.tolist() == [1, 1, 1]
    assert worst.tolist() == [3, 3, 3]


def test_ranks_of_methods_that_are_alike_are_seldom_ruled_out() -> None:
    random = np.random.default_rng(5)
    wrong = 0
    for _ in range(300):
        trials = random.standard_normal((8, 200)) + 3.0 * random.standard_normal(200)
        against = np.append(np.nan, (trials[1:] - trials[0]).std(axis=1, ddof=1) / 200**0.5)
        best, worst = ranking.possible_ranks(trials.mean(axis=1), trials.std(axis=1, ddof=1) / 200**0.5, against)
        wrong += bool((best > 1).any() or (worst < 8).any())
    assert wrong / 300 < 0.05


@pytest.fixture(scope="module")
def trial():
    """One trial of a small block: its cell, and its adjustment by itself."""
    from adjust.trials.replicates import adjust_replicates

    world = build_world(presets["grid-small"], 3)
    part, model = MethodBlock.of(world, noise_free_block(world), Method("brown14")), ap_models.get("brown14")
    xy, given = world.image_points(5)[None], world.given_coordinates(5)[None]
    replicates = adjust_replicates(part.block, model, xy, coordinates=given)
    tracked = Tracked.of(replicates.nominal, part)
    columns = {f"{KEY}|{k}": v for k, v in trial_columns(replicates, part, tracked, given).items()}
    nominal = {f"{KEY}|{k}": v for k, v in nominal_columns(replicates.nominal, tracked).items()}
    alone = adjust_block(part.block.replace_image_points(xy[0]), model)
    return Cell.of(KEY, columns, nominal), alone, replicates.nominal


def test_the_criteria_are_those_of_the_engine(trial) -> None:
    cell, a, _ = trial
    found = {name: float(m.estimate[0]) for name, m in measured(cell).items()}
    assert found["aic"] == pytest.approx(model_choice.aic(a), rel=1e-9)
    assert found["bic"] == pytest.approx(model_choice.bic(a), rel=1e-9)
    tested = ap_significance(a, "ww")
    assert found["significant"] == np.sum(tested.p < 0.05)
    assert found["parameters"] == 14.0


def test_the_largest_correlation_with_the_exterior_orientation(trial) -> None:
    cell, _, nominal = trial
    parameters = [("ww", name) for name in nominal.ap["ww"].names]
    elements = [(image, name) for image in nominal.block.images.ids for name in EXTERIOR_NAMES]
    r = nominal.correlation(*elements, *parameters)[: len(elements), len(elements) :]
    found = float(measured(cell)["largest_ap_exterior"].estimate[0])
    assert found == pytest.approx(np.abs(r).max(), rel=1e-9)
