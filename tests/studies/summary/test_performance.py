"""Every measure by brute force: its value from the definition, its standard error from many repeated studies."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from studies.summary import performance
from studies.summary.performance import Measured

N = 400
REPEATED = 1500


def study_of(random: np.random.Generator, n: int = N) -> dict[str, np.ndarray]:
    """Errors of two correlated estimators, skewed a little, with claimed standard errors that scatter and are low."""
    shared = random.standard_normal((n, 1))
    first = 0.3 + 2.0 * shared + 0.4 * (random.standard_gamma(4.0, (n, 1)) - 4.0)
    second = 0.1 - 1.5 * shared + random.standard_normal((n, 1))
    std = 1.8 * np.sqrt(random.chisquare(40.0, (n, 1)) / 40.0)
    return {"error": first, "other": second, "std": std, "inside": (np.abs(first) <= 1.96 * std).astype(float)}


def relative_error(error: np.ndarray, std: np.ndarray) -> Measured:
    return performance.model_se_error(performance.model_se(std), performance.empirical_se(error))


MEASURES: dict[str, Callable[[dict[str, np.ndarray]], Measured]] = {
    "bias": lambda s: performance.bias(s["error"]),
    "empirical_se": lambda s: performance.empirical_se(s["error"]),
    "model_se": lambda s: performance.model_se(s["std"]),
    "model_se_error": lambda s: relative_error(s["error"], s["std"]),
    "rmse": lambda s: performance.rmse(s["error"]),
    "coverage": lambda s: performance.coverage(s["inside"]),
    "correlation": lambda s: performance.correlation(s["error"], s["other"]),
    "paired difference of biases": lambda s: performance.difference(
        performance.bias(s["error"]), performance.bias(s["other"])
    ),
    "paired difference of rmse": lambda s: performance.difference(
        performance.rmse(s["error"]), performance.rmse(s["other"])
    ),
}


@pytest.mark.parametrize("name", MEASURES)
def test_the_standard_error_is_what_repeated_studies_scatter(name: str) -> None:
    random = np.random.default_rng(11)
    found = [MEASURES[name](study_of(random)) for _ in range(REPEATED)]
    estimates = np.array([m.estimate[0] for m in found])
    claimed = np.array([m.mcse[0] for m in found])
    # a standard deviation from 1500 studies is good to 2 %; the delta method adds its own error of order 1/n
    assert np.sqrt(np.mean(claimed**2)) == pytest.approx(estimates.std(ddof=1), rel=0.07)


@pytest.mark.parametrize("name", MEASURES)
def test_the_standard_error_agrees_with_the_jackknife(name: str) -> None:
    s = study_of(np.random.default_rng(3), 150)
    n = 150
    left_out = [MEASURES[name]({k: np.delete(v, i, axis=0) for k, v in s.items()}).estimate[0] for i in range(n)]
    jackknife = np.sqrt((n - 1) / n * np.sum((np.array(left_out) - np.mean(left_out)) ** 2))
    assert MEASURES[name](s).mcse[0] == pytest.approx(jackknife, rel=0.05)


def test_the_values_are_those_of_the_definitions() -> None:
    s = study_of(np.random.default_rng(5))
    e, std = s["error"][:, 0].tolist(), s["std"][:, 0].tolist()
    n = len(e)
    mean = sum(e) / n
    emp = (sum((x - mean) ** 2 for x in e) / (n - 1)) ** 0.5
    mod = (sum(v**2 for v in std) / n) ** 0.5
    expected = {
        "bias": mean,
        "empirical_se": emp,
        "model_se": mod,
        "model_se_error": mod / emp - 1.0,
        "rmse": (sum(x**2 for x in e) / n) ** 0.5,
        "coverage": sum(abs(x) <= 1.96 * v for x, v in zip(e, std, strict=True)) / n,
        "correlation": np.corrcoef(s["error"][:, 0], s["other"][:, 0])[0, 1],
        "paired difference of biases": mean - float(np.mean(s["other"])),
    }
    for name, value in expected.items():
        assert MEASURES[name](s).estimate[0] == pytest.approx(value, rel=1e-12), name


def test_the_standard_errors_of_table_6_are_those_of_normal_errors() -> None:
    """Morris, White & Crowther 2019, table 6: bias, empirical SE and coverage have formulas of their own."""
    random = np.random.default_rng(1)
    error = random.standard_normal((200_000, 1))
    n, s = len(error), error.std(ddof=1)
    assert performance.bias(error).mcse[0] == pytest.approx(s / np.sqrt(n), rel=1e-12)
    assert performance.empirical_se(error).mcse[0] == pytest.approx(s / np.sqrt(2 * (n - 1)), rel=0.01)
    inside = (np.abs(error) < 1.96).astype(float)
    share = inside.mean()
    assert performance.coverage(inside).mcse[0] == pytest.approx(np.sqrt(share * (1 - share) / n), rel=1e-3)


def test_columns_do_not_mix() -> None:
    random = np.random.default_rng(2)
    table = random.standard_normal((50, 3))
    for form in (performance.bias, performance.empirical_se, performance.rmse, performance.model_se):
        whole = form(table)
        for column in range(3):
            alone = form(table[:, [column]])
            assert whole.estimate[column] == pytest.approx(alone.estimate[0], rel=1e-13)
            assert whole.mcse[column] == pytest.approx(alone.mcse[0], rel=1e-12)


def test_a_paired_difference_is_sharper_than_an_unpaired_one() -> None:
    random = np.random.default_rng(4)
    shared = random.standard_normal((500, 1))
    first, second = shared + 0.1 * random.standard_normal((500, 1)), shared + 0.1 * random.standard_normal((500, 1))
    a, b = performance.bias(first), performance.bias(second)
    unpaired = np.hypot(a.mcse[0], b.mcse[0])
    assert performance.difference(a, b).mcse[0] < 0.2 * unpaired


@pytest.mark.parametrize("n", [0, 1])
def test_no_trial_and_one_trial_give_no_false_certainty(n: int) -> None:
    nothing = np.ones((n, 2))
    for form in (performance.bias, performance.empirical_se, performance.rmse, performance.model_se, performance.mean):
        assert np.isnan(form(nothing).mcse).all()
    assert np.isnan(relative_error(nothing, nothing).estimate).all()
    assert np.isnan(performance.correlation(nothing, nothing).estimate).all()
    assert np.isnan(performance.bias(nothing).estimate).all() == (n == 0)


def test_where_all_intervals_cover_the_standard_error_is_not_zero() -> None:
    found = performance.coverage(np.ones((500, 1)))
    assert found.estimate[0] == 1.0
    # Agresti & Coull 1998: (500 + 1.92) / (500 + 3.84) of 503.84 trials
    assert found.mcse[0] == pytest.approx(np.sqrt(501.9207 / 503.8415 * 1.9207 / 503.8415 / 503.8415), rel=1e-4)
    assert performance.share_coverage(np.ones((500, 1))).mcse[0] == found.mcse[0]


def test_wrong_standard_errors_and_a_bias_are_exposed() -> None:
    """The power of the measures: claimed standard errors that are 0.8 of the true ones, and a bias of one sigma."""
    random = np.random.default_rng(6)
    error = random.standard_normal((1000, 1))
    honest, low = np.ones((1000, 1)), np.full((1000, 1), 0.8)

    def inside(e: np.ndarray, s: np.ndarray) -> np.ndarray:
        return (np.abs(e) <= 1.96 * s).astype(float)

    right = performance.coverage(inside(error, honest))
    assert abs(right.estimate[0] - 0.95) < 4 * right.mcse[0]
    wrong = performance.coverage(inside(error, low))
    assert wrong.estimate[0] < 0.95 - 4 * wrong.mcse[0]
    ratio = relative_error(error, low)
    assert abs(ratio.estimate[0] + 0.2) < 4 * ratio.mcse[0] < 0.15
    moved = performance.bias(error + 1.0)
    assert moved.estimate[0] > 4 * moved.mcse[0]
    assert performance.coverage(inside(error + 1.0, honest)).estimate[0] < 0.9
