"""The Rheidt preset has the published numbers of image points, whatever the seed."""

import pytest

from simfield import build_world, changed, presets, simulate
from simfield.world.measurement import CountError

RHEIDT = presets["rheidt-1980"]
CAMERAS = {"sww": ["sww"], "ww": ["ww"], "sww+ww": ["sww", "ww"]}

# Mauelshagen 1980, table 1: parameters; cameras; unknowns and redundancy without and with auxiliary points
TABLE_1 = [
    (4, "sww", 199, 635, 448, 2066),
    (4, "ww", 253, 1111, 502, 3610),
    (4, "sww+ww", 347, 1851, 596, 6030),
    (6, "sww", 201, 633, 450, 2064),
    (6, "ww", 255, 1109, 504, 3608),
    (6, "sww+ww", 351, 1847, 600, 6026),
    (14, "sww", 209, 625, 458, 2056),
    (14, "ww", 263, 1101, 512, 3600),
    (14, "sww+ww", 367, 1831, 616, 6010),
]


def count(block, parameters):
    """Unknowns and redundancy of an adjustment with additional parameters for each camera."""
    free = (block.points.role != "control").sum()
    unknowns = 6 * len(block.images) + parameters * len(block.cameras) + 3 * free
    return unknowns, 2 * len(block.observations) - unknowns


@pytest.mark.parametrize("seed", range(30))
def test_the_published_numbers_of_image_points_for_any_seed(seed):
    block, truth = simulate(RHEIDT, seed)
    assert len(truth.main_points) == 40
    for name, main, total in (("sww", 417, 1257), ("ww", 682, 2056), ("sww+ww", 1099, 3313)):
        whole = block.select(cameras=CAMERAS[name])
        without = block.select(cameras=CAMERAS[name], points=truth.main_points)
        assert (len(without.observations), len(whole.observations)) == (main, total)
        assert (len(without.points), len(whole.points)) == (40, 123)
        assert min(without.rays.min(), whole.rays.min()) >= 3


@pytest.mark.parametrize(("parameters", "name", "u", "r", "u_aux", "r_aux"), TABLE_1)
def test_unknowns_and_redundancy_of_table_1(parameters, name, u, r, u_aux, r_aux):
    block, truth = simulate(RHEIDT, 1980)
    assert count(block.select(cameras=CAMERAS[name], points=truth.main_points), parameters) == (u, r)
    assert count(block.select(cameras=CAMERAS[name]), parameters) == (u_aux, r_aux)


def test_the_block_is_the_published_one():
    block, truth = simulate(RHEIDT, 1980)
    assert len(block.images) == 39
    assert [truth.camera_ids.count(c) for c in ("sww", "ww")] == [15, 24]
    assert (block.points.role == "control").sum() == 5
    assert block.points.fixed.sum() == 15
    assert "52" in block.points.ids, "the unused central point is measured with auxiliary points"
    assert "52" not in truth.main_points
    assert set(truth.flight_ids) == {"sww-before", "sww-after", "ww-before", "ww-after"}


def test_the_points_missed_lie_further_out_than_the_points_measured():
    everything = build_world(changed(RHEIDT, {"measurement.counts": {}}), 1)
    measured = build_world(RHEIDT, 1)
    radius = (everything.distorted**2).sum(axis=1)
    missed = radius.sum() - (measured.distorted**2).sum()
    n_missed = len(everything.ideal) - len(measured.ideal)
    assert n_missed > 0
    assert missed / n_missed > radius.mean()


def test_counts_out_of_reach_are_an_error_with_a_reason():
    with pytest.raises(CountError, match=r"'ww' sees \d+ image points of main points, needed are 9000"):
        simulate(changed(RHEIDT, {"measurement.counts.ww": {"main": 9000, "total": 9001}}), 1)
    with pytest.raises(CountError, match="only 10 are wanted"):
        simulate(changed(RHEIDT, {"measurement.counts.ww": {"main": 10, "total": 20}}), 1)


@pytest.mark.parametrize("name", sorted(presets))
def test_every_preset_makes_a_block(name):
    assert presets[name].name == name
    block, _ = simulate(presets[name], 7)
    assert block.rays.min() >= 1


def test_the_small_grid_has_tie_points_without_coordinates():
    block, _ = simulate(presets["grid-small"], 1)
    assert len(block.images) == 12
    tie = block.points.role == "tie"
    assert tie.any()
    assert (block.points.coordinates[tie] != block.points.coordinates[tie]).all()
