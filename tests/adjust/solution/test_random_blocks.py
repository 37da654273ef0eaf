"""No small block is refused that an independent dense least squares solves, and the minimum is the same."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from adjust import adjust_block
from tests.adjust.solution.random_blocks import KINDS, SINGULAR, STARTS, Dense, case

SAME_COST = 1e-8
AT_THE_MINIMUM = 1e-8
"""standard deviations"""


def tried(seeds: range) -> tuple[Counter[str], list[str]]:
    """How many blocks of each kind were solved, and a line for each that was not as it should be."""
    solved: Counter[str] = Counter()
    faults = []
    for seed in seeds:
        made = case(seed)
        if made is None:
            continue
        a = adjust_block(made.block)
        if a.groups.count <= a.unknowns:
            continue
        dense = Dense(made)
        vpv, least = dense.minimum()
        if least < SINGULAR:
            continue
        told = f"{seed}, {made.kind}, start {made.start}: "
        if not a.status.ok:
            faults.append(told + a.message)
        elif a.vpv > vpv * (1.0 + SAME_COST) + 1e-9:
            faults.append(told + f"vPv {a.vpv} instead of {vpv}")
        elif not (distance := dense.distance(a.exterior, a.coordinates)) < AT_THE_MINIMUM:
            faults.append(told + f"{distance} standard deviations away")
        solved[made.kind] += 1
        solved[made.start] += 1
    return solved, faults


def test_blocks_weak_and_strong_are_solved_like_dense_ones() -> None:
    solved, faults = tried(range(90))
    assert faults == []
    assert all(solved[kind] >= 8 for kind in (*KINDS, *STARTS))


@pytest.mark.slow
@pytest.mark.parametrize("part", range(4))
def test_two_thousand_blocks_are_solved_like_dense_ones(part: int) -> None:
    solved, faults = tried(range(1000 + 520 * part, 1520 + 520 * part))
    assert faults == []
    assert sum(solved[kind] for kind in KINDS) >= 480


def test_the_dense_derivatives_are_those_of_its_corrections() -> None:
    """The check is checked: a wrong derivative would find no minimum anywhere."""
    made = next(found for seed in range(50) if (found := case(seed)) and found.kind == "oblique")
    dense = Dense(made)
    _, jacobian = dense.evaluated(made.stations, made.axes, made.points)
    step = 1e-4
    for column in range(3):
        moved = made.stations.copy()
        moved[0, column] += step
        back = made.stations.copy()
        back[0, column] -= step
        by_difference = (
            dense.evaluated(moved, made.axes, made.points)[0] - dense.evaluated(back, made.axes, made.points)[0]
        ) / (2 * step)
        np.testing.assert_allclose(jacobian[:, column], by_difference, rtol=0.0, atol=1e-5 * np.abs(jacobian).max())
