"""Trials drawn on demand are the trials of the world, whatever the slice."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from simfield import build_world, presets

SOLVED_OTHERWISE_MM = 1e-10
"""film is solved in a fixed number of steps around an expansion, instead of down to rounding"""


@pytest.mark.parametrize("name", ["rheidt-1980", "rheidt-1980-film", "grid-small"])
def test_a_slice_is_what_single_trials_give(name):
    world = build_world(presets[name], 7)
    draws = world.draws(10, 20)
    assert len(draws) == 10
    single = np.stack([world.image_points(trial) for trial in range(12, 15)])
    if world.scenario.film:
        np.testing.assert_allclose(draws[2:5], single, rtol=0, atol=SOLVED_OTHERWISE_MM)
    else:
        assert np.array_equal(draws[2:5], single)
    assert np.array_equal(draws[2:5], draws[0:9][2:5])
    assert np.array_equal(draws[2:5], pickle.loads(pickle.dumps(draws))[2:5])


def test_the_block_of_a_trial_has_these_coordinates():
    world = build_world(presets["rheidt-1980"], 7)
    block, _ = world.observe(3)
    assert np.array_equal(world.draws(0, 5)[3:4][0], block.observations.xy)


@pytest.mark.parametrize("name", ["rheidt-1980", "rheidt-1980-film"])
def test_some_observations_alone(name):
    world = build_world(presets[name], 7)
    rows = np.array([5, 700, 41])
    draws = world.draws(0, 4)
    assert np.array_equal(draws.only(rows)[1:3], draws[1:3][:, rows])


@pytest.mark.parametrize("first", [0, 4, 16])
@pytest.mark.parametrize("tiles", [3, 4])
def test_lanes_are_the_slice_in_tiles(first, tiles):
    draws = build_world(presets["grid-small"], 1).draws(0, 64)
    lanes = np.empty((tiles, len(draws.base), 2, 8))
    draws.fill_lanes(slice(first, first + 8 * tiles), lanes)
    in_a_row = lanes.transpose(0, 3, 1, 2).reshape(-1, len(draws.base), 2)
    assert np.array_equal(in_a_row, draws[first : first + 8 * tiles])


def test_what_cannot_be_drawn():
    world = build_world(presets["grid-small"], 1)
    with pytest.raises(ValueError, match="step of 2"):
        world.draws(0, 8)[0:8:2]
    for trial in (-1, 2**32):
        with pytest.raises(ValueError, match="numbered from 0"):
            world.image_points(trial)
    assert world.draws(0, 8)[3:3].shape == (0, len(world.image), 2)
