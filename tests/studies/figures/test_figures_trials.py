"""Zip plots, lollipops and nested loops show what their data say."""

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.patches import StepPatch

from studies import figures
from studies.comparison.block_views import PointErrors
from studies.figures.canvas import BLUE, VERMILION, new_figure
from studies.figures.trials import MOST_INTERVALS

T = 1.96


@pytest.fixture
def axes():
    return new_figure(100, 100).subplots()


def segments(axes, colour):
    return [s for c in axes.collections if to_hex(c.get_color()[0]) == colour for s in c.get_segments()]


def test_zip_draws_every_interval_once_and_tells_misses_apart(axes):
    error = np.array([0.1, -3.0, 0.5, 2.5, -0.2])
    figures.zip_plot(axes, error, np.ones(5), T)
    hits, misses = segments(axes, BLUE), segments(axes, VERMILION)
    assert (len(hits), len(misses)) == (3, 2)
    assert min(s[0, 1] for s in misses) > max(s[0, 1] for s in hits)  # the worst on top
    assert sorted(np.mean([s[:, 0] for s in hits + misses], axis=1)) == pytest.approx(sorted(error))
    assert "covered: 60.0 %" in axes.get_xlabel()


def test_zip_thins_out_many_trials_and_counts_them_all(axes):
    error = np.linspace(-3.0, 3.0, 2001)
    figures.zip_plot(axes, error, np.ones(2001), T)
    drawn = len(segments(axes, BLUE)) + len(segments(axes, VERMILION))
    assert drawn == MOST_INTERVALS
    assert f"covered: {100 * np.mean(np.abs(error) <= T):.1f} %" in axes.get_xlabel()


def test_lollipops_say_which_biases_are_beyond_their_error(axes):
    figures.lollipops(axes, ["a", "b", "c"], np.array([0.1, -0.5, 0.02]), np.array([0.1, 0.1, 0.005]), "bias")
    inside, outside = (np.sort([s[1, 0] for s in segments(axes, c) if s[0, 0] == 0.0]) for c in (BLUE, VERMILION))
    assert inside.tolist() == [0.1]
    assert outside.tolist() == [-0.5, 0.02]
    assert axes.get_xscale() == "linear"


def test_one_large_bias_does_not_hide_the_others(axes):
    figures.lollipops(axes, ["a", "b"], np.array([0.1, -9.0]), np.array([0.1, 0.1]), "bias")
    assert axes.get_xscale() == "symlog"
    assert [t.get_text() for t in axes.get_xticklabels()] == ["−10", "−1", "−0.1", "0", "0.1", "1", "10"]


def test_a_nested_loop_has_a_step_line_for_each_series_and_each_factor(axes):
    factors = {"slow": ["x", "x", "y", "y"], "fast": ["1", "2", "1", "2"]}
    values = np.array([1.0, 10.0, 100.0, 1000.0])
    figures.nested_loop(axes, factors, {"one": values, "two": 2.0 * values}, "mm", log=True)
    steps = [p.get_data().values for p in axes.patches if isinstance(p, StepPatch)]
    assert len(steps) == 4
    np.testing.assert_allclose(steps[0], np.log10(values))
    slow, fast = (np.unique(s, return_inverse=True)[1].tolist() for s in steps[2:])
    assert slow == [0, 0, 1, 1]
    assert fast == [0, 1, 0, 1]
    assert max(s.max() for s in steps[2:]) < 0.0  # below the curves
    assert {t.get_text() for t in axes.get_yticklabels()} >= {"1", "10", "100", "1e+03"}


def test_error_ellipses_and_bars_have_the_scale_that_is_written(axes):
    errors = PointErrors(np.zeros((1, 2)), np.array([[0.02, 0.01]]), np.array([0.3]), np.array([0.03]))
    figures.error_ellipses(axes, errors, 10.0, 50.0)
    ellipses, bars = axes.collections[:2]
    np.testing.assert_allclose(ellipses.get_widths(), 2 * 0.1)  # km: 20 mm at 10 mm for 50 m
    np.testing.assert_allclose(np.diff(bars.get_segments()[0][:, 1]), 0.15)
    assert "10 mm is drawn as long as 50 m" in axes.get_xlabel()


def test_weak_points_are_drawn_above_strong_ones(axes):
    marks = figures.rays_per_point(axes, np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]), np.array([3, 9, 5]))
    assert marks.get_array().tolist() == [9, 5, 3]
    np.testing.assert_allclose(marks.get_offsets()[:, 0], [0.001, 0.002, 0.0])


def test_images_are_counted_in_whole_numbers(axes):
    marks = figures.rays_per_point(axes, np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([3, 5]))
    ticks = figures.rays_bar(axes.figure, axes, marks).get_ticks()
    assert len(ticks) > 1
    np.testing.assert_array_equal(ticks, np.round(ticks))
