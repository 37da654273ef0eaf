"""A block that states further observations is adjusted with them: as if they had been given one by one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from adjust import Adjustment, Status, adjust_block, adjust_replicates, ap_models
from adjust.datum import InnerConstraints, MinimumControl
from adjust.observations.ap_priors import ApPriors
from adjust.observations.ground import Distances, HeightDifferences
from adjust.observations.stations import StationAttitudes, StationPositions
from adjust.quality.model_choice import delete_stepwise
from adjust.quality.reliability import Reliability
from adjust.quality.variance import groups_by_camera
from simfield.block.block import Block
from simfield.block.further import Further, Lines, Priors, Stations, Strips
from tests import synthetic
from tests.adjust import dense

MODEL = ap_models.get("torlegard")
STRIP = np.repeat([0, 1, 2, -1], 3)
NAMES = ("s1", "s2", "s3")
CLOCK = np.array([0.0, 3.0, 8.0, 10.0, 11.0, 12.0, np.nan, np.nan, np.nan, 5.0, np.nan, 1.0])
"""of the third strip the order is the time, the last three images belong to no strip"""
ENDS = (("11", "16"), ("16", "33"), ("48", "12"))


def further(w: synthetic.World, seed: int = 3) -> Further:
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal((12, 6))
    position = w.exterior[:, :3] + 0.05 * noise[:, :3] - np.where(STRIP >= 1, 0.7, 0.0)[:, None]
    attitude = w.exterior[:, 3:] + 1e-4 * noise[:, 3:]
    sigma_position, sigma_attitude = np.full((12, 3), 0.05), np.full((12, 3), 1e-4)
    position[STRIP == 2, :2] = sigma_position[STRIP == 2, :2] = np.nan
    attitude[5:] = sigma_attitude[5:] = np.nan
    stations = Stations(np.arange(12), STRIP, CLOCK, position, sigma_position, attitude, sigma_attitude)
    strips = Strips(NAMES, ("none", "drift", "offset"), ("none", "none", "none"))
    ids = w.block.points.ids
    start, end = np.array([[ids.index(name) for name in pair] for pair in ENDS]).T
    line = w.coordinates[end] - w.coordinates[start]
    distances = Lines(start, end, np.linalg.norm(line, axis=1) + rng.normal(0.0, 0.01, 3), np.full(3, 0.01))
    heights = Lines(start[:2], end[:2], line[:2, 2] + rng.normal(0.0, 0.01, 2), np.full(2, 0.01))
    return Further(strips, stations, distances, heights, Priors([0, 0], ("a1", "a5"), [0.0, 1e-6], [1e-5, 2e-5]))


@pytest.fixture(scope="module")
def block(ww_world: synthetic.World) -> Block:
    w = ww_world.with_noise(np.random.default_rng(5)).controlled(synthetic.CONTROL, (0.02, 0.02, 0.02))
    return replace(w.block, further=further(ww_world))


@pytest.fixture(scope="module")
def a(block: Block) -> Adjustment:
    found = adjust_block(block, MODEL)
    assert found.status.ok, found.message
    return found


def test_as_if_they_had_been_given_one_by_one(block: Block, a: Adjustment) -> None:
    s, ids = block.further.stations, block.images.ids
    time = np.array([-1.0, -0.25, 1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    names = tuple(NAMES[i] if i >= 0 else "" for i in STRIP)
    positions = StationPositions(
        ids, s.position, s.sigma_position, names, offset=("s2", "s3"), drift=("s2",), time=time
    )
    attitudes = StationAttitudes(ids, s.attitude, s.sigma_attitude)
    f = block.further
    ground = (Distances(ENDS, f.distances.values, f.distances.sigma),)
    heights = HeightDifferences(ENDS[:2], f.height_differences.values, f.height_differences.sigma)
    priors = ApPriors("ww", {"a1": (0.0, 1e-5), "a5": (1e-6, 2e-5)})
    alone = adjust_block(block.without(), MODEL, observations=[positions, attitudes, *ground, heights, priors])
    assert a.layout.further == alone.layout.further
    np.testing.assert_array_equal(a.x, alone.x)
    assert a.sigma0 == alone.sigma0


def test_unknowns_where_something_was_observed(a: Adjustment) -> None:
    """The third strip has heights alone, so it has an offset of heights alone."""
    said = {(owner.removeprefix("position of strip "), name) for owner, name in a.layout.further}
    second = {("s2", f"{term} {e}") for term in ("offset", "drift") for e in ("X0", "Y0", "Z0")}
    assert said == second | {("s3", "offset Z0")}
    counts = {name: len(rows) for name, rows in groups_by_camera(a).items()}
    assert {k: v for k, v in counts.items() if k not in ("images of ww", "control")} == {
        "positions": 30,
        "attitudes": 15,
        "distances": 3,
        "height differences": 2,
        "priors of ww": 2,
    }
    for owner, name in a.layout.further:
        at = a.layout.index(owner, name)
        assert abs(a.x[at] - (-0.7 if "offset" in name else 0.0)) < 4.5 * a.std[at]


def test_drift_by_the_clock(block: Block, ww_world: synthetic.World) -> None:
    """Without any noise the offset and the drift that were put in come back, at unequal times."""
    w = ww_world.controlled(synthetic.CONTROL)
    f = further(ww_world)
    time = np.array([-1.0, -0.25, 1.0])
    position = w.exterior[:, :3].copy()
    position[:3] += [2.0, -1.0, 0.5] + time[:, None] * [0.3, 0.2, -0.4]
    nothing = np.full((12, 3), np.nan)
    exact = {"position": position, "sigma_position": np.full((12, 3), 0.05)}
    stations = replace(f.stations, **exact, attitude=nothing, sigma_attitude=nothing)
    strips = Strips(NAMES, ("drift", "none", "none"), ("none",) * 3)
    a = adjust_block(replace(w.block, further=Further(strips, stations).select(*all_of(w.block))))
    assert a.status.ok, a.message
    found = [a.x[a.layout.index("position of strip s1", f"{term} {e}0")] for term in ("offset", "drift") for e in "XYZ"]
    np.testing.assert_allclose(found, [2.0, -1.0, 0.5, 0.3, 0.2, -0.4], rtol=0.0, atol=1e-6)


def all_of(block: Block) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return tuple(np.ones(len(t), dtype=bool) for t in (block.images, block.points, block.cameras))  # type: ignore[return-value]


def test_every_redundancy_number(a: Adjustment) -> None:
    quality = Reliability.of(a)
    assert quality.redundancy.sum() == pytest.approx(a.redundancy, abs=len(quality) * dense.SAME)
    by_group = {name: quality.redundancy[rows].sum() for name, rows in groups_by_camera(a).items()}
    assert sum(by_group.values()) == pytest.approx(a.redundancy, abs=len(quality) * dense.SAME)


def test_two_lists_are_one_group(block: Block) -> None:
    more = Distances(ENDS[:1], np.array([block.further.distances.values[0]]), np.array([0.02]))
    a = adjust_block(block, MODEL, observations=[more])
    groups = groups_by_camera(a)
    assert len(groups["distances"]) == 4
    assert sum(map(len, groups.values())) == a.groups.rows


def test_stepwise_deletion_keeps_them(a: Adjustment) -> None:
    found = delete_stepwise(a, alpha=1e-6)
    assert found.deleted
    assert found.adjustment.layout.further == a.layout.further
    left = set(found.adjustment.ap["ww"].names)
    lost = sum(name not in left for name in ("a1", "a5"))
    assert found.adjustment.observations == a.observations - lost


def test_other_datums(block: Block) -> None:
    for datum in (InnerConstraints(), MinimumControl()):
        a = adjust_block(block, MODEL, datum=datum)
        assert a.status is Status.NO_START
        assert "a free network cannot hold observed stations" in a.message
        priors = adjust_block(block.without("stations", "distances", "height_differences"), MODEL, datum=datum)
        assert priors.status.ok, priors.message
        assert [group.name for group in priors.regular.groups.further] == ["priors of ww"]


def test_what_does_not_fit_the_model(block: Block) -> None:
    with pytest.raises(ValueError, match="the set optical of camera ww has no parameter 'a1', it has"):
        adjust_block(block, ap_models.get("optical"))
    with pytest.raises(ValueError, match="of camera ww has no parameter 'a1', it has none; take the set"):
        adjust_block(block)


def test_trials_refuse_them(block: Block) -> None:
    with pytest.raises(ValueError, match="trials know image points and control only"):
        adjust_replicates(block, MODEL, block.observations.xy[None])
