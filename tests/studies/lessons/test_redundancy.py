"""Lesson 1: the counts are those of the paper, and expected standard errors are the scatter of repeated flights."""

import numpy as np
import pytest

from adjust import adjust_replicates, ap_models
from studies.lessons import redundancy
from studies.lessons.adjusted import observed, world_of
from studies.lessons.lesson import LessonError

TRIALS = 800
SCATTER = 0.06
"""relative: 108 points of 800 flights, whose errors are correlated through 12 unknowns of common orientation"""


def test_table_1_is_counted_as_it_is_printed():
    rows = redundancy.table1()
    assert len(rows) == 18
    for row in rows:
        assert (row.counts.unknowns, row.counts.redundancy) == (row.printed_unknowns, row.printed_redundancy)


@pytest.mark.parametrize(("strips", "headings", "size"), [(1, 1, 1), (2, 4, 3)])
def test_the_counts_are_those_of_the_field(strips, headings, size):
    counts = redundancy.flown(strips, headings, size).counts
    assert counts.images == 3 * strips * headings
    assert counts.points == 41 * size - 5
    assert counts.unknowns == 6 * counts.images + 4 + 3 * counts.points
    assert counts.redundancy == 2 * counts.image_points - counts.unknowns


def test_the_expected_standard_errors_are_the_scatter_of_many_flights():
    scenario = redundancy.scenario(1, 2, 1)
    world = world_of(scenario)
    block = observed(world)
    found = adjust_replicates(block, ap_models.get(redundancy.MODEL), world.draws(0, TRIALS))
    free = np.asarray(block.points.role != "control")
    scatter = 1000.0 * np.std(found.points[:, free], axis=0)
    x = redundancy.RADIUS_MM
    a3, a4 = found.ap("ww")[:, :2].T
    radial = 1000.0 * x * (a3 * (x**2 - 100.0**2) + a4 * (x**4 - 100.0**4))
    expected = redundancy.flown(1, 2, 1)
    assert expected.std_z_mm == pytest.approx(np.sqrt(np.mean(scatter[:, 2] ** 2)), rel=SCATTER)
    assert expected.std_xy_mm == pytest.approx(np.sqrt(np.mean(scatter[:, :2] ** 2)), rel=SCATTER)
    assert expected.std_radial_um == pytest.approx(np.std(radial), rel=SCATTER)


@pytest.mark.parametrize("strips", redundancy.STRIPS)
def test_what_the_lesson_says(strips):
    flights = {(f.headings, f.group_size): f for f in redundancy.alternatives(strips)}
    for headings in redundancy.HEADINGS_GON:
        one, three = flights[headings, 1], flights[headings, 3]
        assert three.counts.redundancy > 3.0 * one.counts.redundancy
        assert three.std_z_mm == pytest.approx(one.std_z_mm, rel=0.08)
        assert three.std_radial_um < 0.9 * one.std_radial_um
    for size in redundancy.GROUP_SIZES:
        assert flights[4, size].std_z_mm < 0.5 * flights[1, size].std_z_mm


def test_other_headings_are_refused():
    with pytest.raises(LessonError, match="1, 2 or 4"):
        redundancy.flown(1, 3, 1)
