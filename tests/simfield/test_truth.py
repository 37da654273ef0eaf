"""truth.json: there and back."""

from dataclasses import dataclass, fields, replace

import numpy as np
import pytest

from simfield import Truth, presets, read_truth, simulate, write_truth
from simfield.disturbances.effects import EffectOn, RadialTable


@dataclass(frozen=True)
class Homemade:
    def displacement(self, xy_mm):
        return 0.0 * xy_mm


def test_round_trip(tmp_path):
    scenario = presets["rheidt-1980-film"]
    table = EffectOn(RadialTable((50.0, 170.0), (1.0, -2.0)), camera="ww")
    _, truth = simulate(replace(scenario, effects=(*scenario.effects, table)), 1, trial=2)
    write_truth(truth, tmp_path)
    found = read_truth(tmp_path / "truth.json")
    for f in fields(Truth):
        a, b = getattr(truth, f.name), getattr(found, f.name)
        if isinstance(a, np.ndarray):
            np.testing.assert_array_equal(a, b)
            assert a.dtype == b.dtype
        else:
            assert a == b


def test_distortion_of_image_and_camera():
    _, truth = simulate(presets["rheidt-1980"], 1)
    xy = np.array([[30.0, 40.0]])
    np.testing.assert_array_equal(truth.distortion("ww-after-h0-1", xy), truth.camera_distortion("ww", xy))
    assert (truth.camera_distortion("ww", xy) != truth.camera_distortion("sww", xy)).all()
    for ask in (lambda: truth.distortion("nobody", xy), lambda: truth.camera_distortion("nobody", xy)):
        with pytest.raises(KeyError, match="nobody"):
            ask()


def test_truth_is_read_only():
    _, truth = simulate(presets["rheidt-1980"], 1)
    with pytest.raises(ValueError, match="read-only"):
        truth.exterior[0, 0] = 0.0


def test_a_homemade_effect_simulates_but_has_no_file_form():
    scenario = replace(presets["rheidt-1980"], effects=(EffectOn(Homemade()),))
    _, truth = simulate(scenario, 1)
    np.testing.assert_array_equal(truth.ideal, truth.undisturbed)
    with pytest.raises(ValueError, match="Homemade"):
        truth.to_json()
