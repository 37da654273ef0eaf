"""Known distortions in noise-free images come back.

What limits the digits: image coordinates of 100 mm are rounded to 1.4e-14 mm, a distortion of 0.01 mm therefore to a
part in 1e-12, and the residuals of an adjustment to 1e-11 of their standard deviation. The adjustment loses no more
than a digit on top. In national coordinates of 5e6 m the control is rounded to 5e-10 m; that moves and bends the block,
and the additional parameters hardly feel it.
"""

from __future__ import annotations

import numpy as np
import pytest

from adjust import adjust_block, ap_models
from adjust.ap_models.model import ApModel
from simfield.block.block import Floats
from tests import synthetic

RECOVERY = 1e-9
"""of each coefficient; 3e-12 is reached"""


def coefficients(model: ApModel, largest_mm: float) -> Floats:
    """Every term with `largest_mm` at its largest on the film, signs in turn."""
    x, y = np.meshgrid(np.linspace(-80.0, 80.0, 17), np.linspace(-80.0, 80.0, 17))
    size = np.abs(model.basis(x.ravel(), y.ravel())).max(axis=(0, 1))
    return np.asarray(largest_mm / size * np.where(np.arange(len(size)) % 2, -1.0, 1.0))


def distorted_world(
    name: str, per_group: int = 1, shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> synthetic.World:
    model = ap_models.get(name)
    flights = [
        (synthetic.WW, synthetic.fly(synthetic.WW, 10500.0)),
        (synthetic.SWW, synthetic.fly(synthetic.SWW, 9600.0, seed=4)),
    ]
    return synthetic.world(
        flights,
        synthetic.quincunx(per_group=per_group),
        models={"ww": model, "sww": model},
        ap={"ww": coefficients(model, 0.010), "sww": coefficients(model, -0.007)},
        shift=shift,
    )


def roughly_started(w: synthetic.World) -> synthetic.World:
    rng = np.random.default_rng(0)
    spread = np.array([10.0, 10.0, 10.0, 0.02, 0.02, 0.02])
    return w.started_at(w.exterior + spread * rng.uniform(-1.0, 1.0, w.exterior.shape))


def test_the_test_solves_what_it_says() -> None:
    """measured = ideal + d(measured), not d(ideal)."""
    model = ap_models.get("brown14")
    c = coefficients(model, 0.010)
    ideal = np.random.default_rng(1).uniform(-110.0, 110.0, (200, 2))
    measured = synthetic.distort(ideal, model, c)
    np.testing.assert_allclose(measured, ideal + model.basis(measured[:, 0], measured[:, 1]) @ c, rtol=0.0, atol=3e-14)
    assert np.abs(measured - ideal - model.basis(ideal[:, 0], ideal[:, 1]) @ c).max() > 1e-6


@pytest.mark.parametrize("per_group", [1, 3])
@pytest.mark.parametrize("name", ["optical", "torlegard", "brown14"])
def test_noise_free_recovery(name: str, per_group: int) -> None:
    w = roughly_started(distorted_world(name, per_group))
    a = adjust_block(w.block, ap_models.get(name))
    assert a.status.ok, a.message
    for camera_id, truth in w.ap.items():
        np.testing.assert_allclose(a.ap[camera_id].values, truth, rtol=RECOVERY, atol=0.0)
    assert a.sigma0 < 1e-9
    np.testing.assert_allclose(a.images.values[:, :3], w.exterior[:, :3], rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(a.images.values[:, 3:], w.exterior[:, 3:], rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(a.points.values, w.coordinates, rtol=0.0, atol=1e-8)


def test_noise_free_recovery_in_national_coordinates() -> None:
    # Z as on a high plateau, fractions that no binary number has
    w = roughly_started(distorted_world("torlegard", shift=(2_568_123.1, 5_641_987.7, 2345.3)))
    a = adjust_block(w.block, ap_models.get("torlegard"))
    assert a.status.ok, a.message
    for camera_id, truth in w.ap.items():
        np.testing.assert_allclose(a.ap[camera_id].values, truth, rtol=RECOVERY, atol=0.0)


def test_without_the_parameters_the_distortion_stays_in_the_residuals() -> None:
    w = distorted_world("optical")
    a = adjust_block(w.block)
    assert a.status.ok, a.message
    assert a.sigma0 > 0.3
