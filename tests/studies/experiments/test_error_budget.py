"""The error budget: stages that a reduction undoes leave nothing, and squares of single stages make up the whole."""

from __future__ import annotations

import numpy as np
import pytest

from adjust import ap_models
from adjust.reductions.reduction import ReductionPlan
from simfield import presets
from simfield.chain.presets import chains
from studies.experiments.error_budget import EVERYTHING, Budget, stages, table
from studies.experiments.error_budget_page import page

TRIALS = 8
UNDONE = ["refraction", "earth curvature", "comparator"]


@pytest.fixture(scope="module")
def found():
    budget = Budget(presets["rheidt-1980-film"], chains["psk-1969"], ReductionPlan("helmert"), ap_models.get("brown14"))
    assert list(stages(budget))[-1] == EVERYTHING
    return table(budget, TRIALS, 1980).set_index("stage")


def test_what_a_reduction_undoes_leaves_nothing(found):
    assert (found.loc[UNDONE, "put_in_um"] > 1.0).all()
    whole = [name for name in UNDONE if name != "refraction"]
    assert (found.loc[whole, ["left_um", "m0_um", "mu_xy_mm", "mu_z_mm"]].abs() < 1e-3).all(axis=None)


def test_the_formula_of_refraction_leaves_what_the_traced_ray_has_more(found):
    """17 to 19 % of it; as it is radial, the additional parameters take most."""
    share = found.loc["refraction", "left_um"] / found.loc["refraction", "put_in_um"]
    assert 0.14 < share < 0.21
    assert found.loc["refraction", "m0_um"] < found.loc["refraction", "left_um"]


def test_air_puts_in_what_the_literature_says(found):
    # rms over the format of curves that reach 5.4 um at 100 mm (curvature), 2.4 um (refraction), Rheidt, wide angle
    assert 3.0 < found.loc["earth curvature", "put_in_um"] < 8.0
    assert 1.0 < found.loc["refraction", "put_in_um"] < 2.5


@pytest.mark.parametrize("name", ["left_um", "mu_xy_mm", "mu_z_mm"])
def test_squares_of_single_stages_add_up(found, name):
    parts = np.sqrt((found[name].drop(EVERYTHING) ** 2).sum())
    # mu of a trial scatters by 15 %, TRIALS of them by 5 %
    assert abs(parts / found.loc[EVERYTHING, name] - 1.0) < 0.2


def test_noise_is_in_the_residuals(found):
    assert found.loc["image noise", "m0_um"] == pytest.approx(4.0, rel=0.05)
    assert (found["n"] == TRIALS).all()
    assert (found["failures"] == 0).all()


def test_the_page_has_every_mean_with_its_error(found):
    row = next(
        line for line in page(found.reset_index(), TRIALS, 1980).splitlines() if line.startswith("| image noise")
    )
    noise = found.loc["image noise"]
    assert f"{noise['m0_um']:.3f} ± {noise['m0_um_mcse']:.3f}" in row
    assert f"{noise['mu_z_mm']:.2f} ± {noise['mu_z_mm_mcse']:.2f}" in row
    # m0 scatters by sigma0 / sqrt(2 r) from flight to flight, with 6000 to 6100 redundant observations
    known_to = 3.5 / np.sqrt(2.0 * (TRIALS - 1))  # standard errors of a scatter that TRIALS flights give
    assert noise["m0_um_mcse"] == pytest.approx(4.0 / np.sqrt(2.0 * 6010 * TRIALS), rel=known_to)
