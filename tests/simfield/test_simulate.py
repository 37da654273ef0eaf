"""The story as a whole: what belongs to the seed, what to the trial, and that concerns do not touch each other."""

from dataclasses import replace

import numpy as np
import pytest

from simfield import build_world, changed, presets, simulate
from simfield.disturbances.film import FilmVariation
from simfield.disturbances.noise import Noise
from simfield.scenario.scenario import ScenarioError

RHEIDT = presets["rheidt-1980"]
WITH_FILM = presets["rheidt-1980-film"]
EXACT_MM = 1e-13
"""A few units in the last place of 100 mm."""


def noise_of(scenario, seed=1, trial=0):
    """{(image, point): noise} of a simulated block, mm."""
    block, truth = simulate(scenario, seed, trial)
    o = block.observations
    keys = [(block.images.ids[i], block.points.ids[p]) for i, p in zip(o.image, o.point, strict=True)]
    return dict(zip(keys, o.xy - truth.undisturbed, strict=True))


def assert_same_noise(a, b):
    common = a.keys() & b.keys()
    assert len(common) > 500
    # The sum of a coordinate and its noise is rounded at 100 mm.
    np.testing.assert_allclose([a[k] for k in common], [b[k] for k in common], rtol=0, atol=EXACT_MM)


def test_same_seed_same_block():
    a, b = (simulate(RHEIDT, 3, trial=2)[0] for _ in range(2))
    assert a.points.ids == b.points.ids
    np.testing.assert_array_equal(a.observations.xy, b.observations.xy)
    np.testing.assert_array_equal(a.observations.image, b.observations.image)
    np.testing.assert_array_equal(a.points.coordinates, b.points.coordinates)
    np.testing.assert_array_equal(a.images.exterior, b.images.exterior)


def test_another_trial_has_the_same_geometry_and_other_errors():
    (a, true_a), (b, true_b) = simulate(RHEIDT, 3, trial=0), simulate(RHEIDT, 3, trial=1)
    np.testing.assert_array_equal(true_a.exterior, true_b.exterior)
    np.testing.assert_array_equal(true_a.coordinates, true_b.coordinates)
    np.testing.assert_array_equal(true_a.undisturbed, true_b.undisturbed)
    np.testing.assert_array_equal(a.observations.point, b.observations.point)
    np.testing.assert_array_equal(a.images.exterior, b.images.exterior)
    assert (a.observations.xy != b.observations.xy).all()
    assert (a.points.coordinates != b.points.coordinates).all()


def test_another_seed_is_another_world():
    a, b = simulate(RHEIDT, 3)[1], simulate(RHEIDT, 4)[1]
    assert (a.exterior != b.exterior).any(axis=1).all()


def test_a_world_observes_what_simulate_returns():
    world = build_world(WITH_FILM, 5)
    block, truth = simulate(WITH_FILM, 5, trial=3)
    np.testing.assert_array_equal(world.image_points(3), block.observations.xy)
    np.testing.assert_array_equal(world.given_coordinates(3), block.points.coordinates)
    np.testing.assert_array_equal(world.undisturbed_image_points(3), truth.undisturbed)


@pytest.mark.parametrize("name", ["rheidt-1980", "rheidt-1980-film", "convergent"])
def test_measured_is_ideal_plus_distortion_at_the_measured(name):
    _, truth = simulate(presets[name], 6, trial=1)
    for row, image_id in enumerate(truth.image_ids):
        own = truth.image == row
        d = truth.distortion(image_id, truth.undisturbed[own])
        np.testing.assert_allclose(truth.undisturbed[own], truth.ideal[own] + d, rtol=0, atol=EXACT_MM)
        assert np.abs(d).max() > 1e-4


def test_film_is_new_in_every_trial_and_image_only_where_it_is_asked_for():
    world = build_world(WITH_FILM, 1)
    assert np.abs(world.undisturbed_image_points(0) - world.undisturbed_image_points(1)).max() > 1e-3
    still = build_world(replace(WITH_FILM, film=()), 1)
    np.testing.assert_array_equal(still.undisturbed_image_points(0), still.undisturbed_image_points(1))


def test_image_noise_has_its_standard_deviation():
    block, truth = simulate(RHEIDT, 8)
    v = block.observations.xy - truth.undisturbed
    for camera, sigma in (("sww", 0.0057), ("ww", 0.0037)):
        own = v[np.array(truth.camera_ids)[truth.image] == camera]
        standard_error = sigma / np.sqrt(2 * own.size)
        assert abs(own.std() - sigma) < 3 * standard_error
        assert abs(own.mean()) < 3 * sigma / np.sqrt(own.size)
        np.testing.assert_array_equal(truth.noise_sigma[np.array(truth.camera_ids)[truth.image] == camera], sigma)


def test_geodetic_noise_is_in_all_given_coordinates_and_in_no_image():
    quiet = changed(RHEIDT, {"noise.geodetic_mm": 0.0})
    (a, truth), (b, _) = simulate(RHEIDT, 9), simulate(quiet, 9)
    np.testing.assert_array_equal(a.observations.xy, b.observations.xy)
    np.testing.assert_array_equal(b.points.coordinates, truth.coordinates)
    errors = a.points.coordinates - truth.coordinates
    assert (errors != 0.0).all(), "control included"
    assert abs(errors.std() - 0.009) < 3 * 0.009 / np.sqrt(2 * errors.size)


def test_one_survey_serves_all_trials_if_asked():
    world = build_world(changed(RHEIDT, {"noise.one_survey": True}), 1)
    np.testing.assert_array_equal(world.given_coordinates(0), world.given_coordinates(1))


@pytest.mark.parametrize(
    "changes",
    [
        {"noise.geodetic_mm": 0.0},
        {"measurement.counts": {}},
        {"measurement.edge_preference": 0.0},
        {"field.relief.sigma_m": 1.0},
        {"effects": []},
        {"control.layout": "perimeter"},
        {"start.position_sigma_m": 1.0},
        {"flights[*].position_sigma_m": 20.0},
        {"film": [{"camera": "ww", "terms": "affine", "um_at_100mm": 5.0}]},
        {"noise.image_um.sww": 3.7, "measurement.counts": {}},
    ],
    ids=str,
)
def test_image_noise_does_not_feel_other_settings(changes):
    a, b = noise_of(RHEIDT), noise_of(changed(RHEIDT, changes))
    if "noise.image_um.sww" in changes:
        a, b = ({k: v for k, v in n.items() if k[0].startswith("ww")} for n in (a, b))
    assert_same_noise(a, b)


def test_image_noise_does_not_feel_further_images():
    fewer = changed(
        RHEIDT,
        {"flights": [f for f in _flights(RHEIDT) if f["flight_id"] != "sww-after"], "measurement.counts": {}},
    )
    assert_same_noise(noise_of(fewer), noise_of(RHEIDT))


def test_the_geometry_does_not_feel_the_errors():
    a, b = simulate(RHEIDT, 1)[1], simulate(changed(RHEIDT, {"noise.image_um": 1.0, "noise.geodetic_mm": 0.0}), 1)[1]
    np.testing.assert_array_equal(a.undisturbed, b.undisturbed)
    np.testing.assert_array_equal(a.exterior, b.exterior)


def test_start_values_are_near_the_truth_or_the_flight_plan():
    block, truth = simulate(RHEIDT, 1)
    moved = block.images.exterior - truth.exterior
    n = moved[:, :3].size
    assert abs(moved[:, :3].std() - 10.0) < 3 * 10.0 / np.sqrt(2 * n)
    assert abs(np.rad2deg(moved[:, 3:].std()) - 1.0) < 3 / np.sqrt(2 * n)
    planned, _ = simulate(changed(RHEIDT, {"start.come_from": "flight-plan"}), 1)
    assert (planned.images.exterior[:, 3:5] == 0.0).all()


def test_control_sigma_reaches_the_block():
    block, _ = simulate(changed(RHEIDT, {"control.sigma_xy_mm": 5.0, "control.sigma_z_mm": 0.0}), 1)
    assert block.points.weighted.sum() == 10
    assert block.points.fixed.sum() == 5
    np.testing.assert_array_equal(block.points.sigma[block.points.role == "check"], 0.009)


def test_nothing_lies_outside_the_format():
    block, _ = simulate(changed(RHEIDT, {"measurement.counts": {}, "measurement.margin_mm": 5.0}), 1)
    five_noise_sigmas_mm = 0.03
    assert np.abs(block.observations.xy).max() < 110.0 + five_noise_sigmas_mm


def test_a_share_of_the_points_can_be_missing():
    full = simulate(changed(RHEIDT, {"measurement.counts": {}}), 1)[0]
    less = simulate(changed(RHEIDT, {"measurement.counts": {}, "measurement.missing_share": 0.1}), 1)[0]
    assert len(less.observations) == pytest.approx(0.9 * len(full.observations), abs=4)


@pytest.mark.parametrize("seed", [-1, 1.5])
def test_seeds_are_whole_numbers_from_zero(seed):
    with pytest.raises((ValueError, TypeError)):
        simulate(RHEIDT, seed)


def test_a_seed_may_be_numpys():
    a, b = simulate(RHEIDT, np.int64(4), trial=np.int64(1)), simulate(RHEIDT, 4, trial=1)
    np.testing.assert_array_equal(a[0].observations.xy, b[0].observations.xy)
    assert a[1].to_json() == b[1].to_json()


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (lambda: replace(RHEIDT, flights=()), "at least one flight"),
        (lambda: replace(RHEIDT, flights=RHEIDT.flights * 2), "named twice"),
        (lambda: replace(RHEIDT, cameras=RHEIDT.cameras[:1]), "no camera named 'ww'"),
        (lambda: replace(RHEIDT, noise=Noise(image_um={"ww": 3.0})), "names the cameras"),
        (lambda: replace(RHEIDT, film=(FilmVariation("x", "affine", 1.0),)), r"film\[0\]"),
        (lambda: changed(RHEIDT, {"effects[1].image": "x"}), r"effects\[1\].image"),
        (lambda: changed(RHEIDT, {"measurement.unused_groups": ["99"]}), "no group named '99'"),
    ],
)
def test_a_scenario_that_contradicts_itself_is_refused(make, reason):
    with pytest.raises(ScenarioError, match=reason):
        make()


def _flights(scenario):
    from simfield.scenario.scenario_file import scenario_as_table

    return scenario_as_table(scenario)["flights"]
