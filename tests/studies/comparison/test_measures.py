"""Measures against brute force."""

import math

import numpy as np
import pytest
from scipy.stats import t as student

from adjust import adjust_block, ap_models
from simfield import presets, simulate
from studies.comparison import measures


@pytest.fixture(scope="module")
def flown():
    block, truth = simulate(presets["rheidt-1980"], seed=11)
    part = block.select(cameras=["ww"], points=truth.main_points)
    return adjust_block(part, ap_models.get("torlegard")), truth


def test_check_points_by_hand(flown):
    a, truth = flown
    found = measures.check_points(a, truth)
    squares, true_squares, inside = np.zeros(3), np.zeros(3), np.zeros(3)
    n = 0
    quantile = student.ppf(0.975, a.redundancy)
    for row, name in enumerate(a.block.points.ids):
        if a.block.points.role[row] != "check":
            continue
        n += 1
        true = truth.coordinates[truth.point_ids.index(name)]
        for axis in range(3):
            estimate = a.points.values[row, axis]
            squares[axis] += (estimate - a.block.points.coordinates[row, axis]) ** 2
            true_squares[axis] += (estimate - true[axis]) ** 2
            inside[axis] += abs(estimate - true[axis]) <= quantile * a.points.std[row, axis]
    x, y, z = (math.sqrt(s / n) for s in squares)
    assert found.n == n == 35
    got = (found.rms_x_m, found.rms_y_m, found.rms_z_m, found.rms_xy_m, found.rms_xy_coordinate_m)
    assert got == pytest.approx((x, y, z, math.hypot(x, y), math.hypot(x, y) / math.sqrt(2)))
    assert (found.true.rms_x_m, found.true.rms_z_m) == pytest.approx(
        (math.sqrt(true_squares[0] / n), math.sqrt(true_squares[2] / n))
    )
    assert (found.coverage_x, found.coverage_y, found.coverage_z) == pytest.approx(tuple(inside / n))


def test_geodetic_deviations_need_no_standard_deviations(flown):
    a, truth = flown
    assert measures.geodetic_deviations(a) == measures.check_points(a, truth).geodetic


def test_missing_coordinates_are_not_counted():
    d = measures.Deviations.of(np.array([[3.0, np.nan, np.nan], [4.0, 2.0, np.nan], [np.nan, np.nan, np.nan]]))
    assert d.n == 2
    assert (d.rms_x_m, d.rms_y_m) == pytest.approx((math.sqrt(12.5), 2.0))
    assert math.isnan(d.rms_z_m)


def test_coverage_of_known_errors():
    std = np.ones((4, 1))
    error = np.array([[0.0], [1.95], [1.97], [5.0]])
    assert measures.covered(error, std, 10**9)[0] == pytest.approx(0.5)
    assert math.isnan(measures.covered(np.empty((0, 1)), np.empty((0, 1)), 10)[0])
