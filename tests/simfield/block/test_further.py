"""Further observations of a block: what is refused, what a selection keeps, and that no file loses a bit of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from simfield.block.block import Block
from simfield.block.checks import SIGMA_LEAST, SIGMA_MOST
from simfield.block.further import ANGLE_MOST, Further, Lines, Priors, Stations, Strips
from simfield.files.block_folder import BlockFolderError, read_block, write_block
from tests.simfield.files.test_block_folder import FILES, bits

FURTHER = {
    "strips.csv": "strip_id,position_bias,attitude_bias\nwest,drift,none\n",
    "stations.csv": "image_id,strip_id,time_s,X0_m,Y0_m,Z0_m,sigma_X0_m,sigma_Y0_m,sigma_Z0_m,"
    "omega_deg,phi_deg,kappa_deg,sigma_omega_deg,sigma_phi_deg,sigma_kappa_deg\n"
    "a,west,12.5,10.0,-20.0,1500.0,0.05,0.05,0.1,0.1,,90.0,0.01,,0.02\n"
    "b,west,20.0,,,1501.0,,,0.1,,,,,,\n",
    "distances.csv": "from_point_id,to_point_id,distance_m,sigma_m\n1,2,5.25,0.003\n1,2,5.254,0.003\n",
    "height_differences.csv": "from_point_id,to_point_id,height_difference_m,sigma_m\n3,1,-0.5,0.002\n",
    "ap_priors.csv": "camera_id,parameter,value,sigma\nww,a3,-1e-08,2e-09\nww,a4,0.0,1e-13\n",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in (FILES | FURTHER).items():
        (tmp_path / name).write_text(text, encoding="utf-8", newline="")
    return tmp_path


def tables(further: Further) -> list[Any]:
    """Everything that a block states, to be compared bit by bit."""
    f = further
    arrays = [f.stations.time_s, f.stations.position, f.stations.sigma_position, f.stations.attitude]
    arrays += [f.stations.sigma_attitude, f.distances.values, f.distances.sigma, f.height_differences.values]
    arrays += [f.height_differences.sigma, f.ap_priors.values, f.ap_priors.sigma]
    indices = [f.stations.image, f.stations.strip, f.distances.start, f.distances.end, f.height_differences.start]
    indices += [f.height_differences.end, f.ap_priors.camera]
    texts = [f.strips.ids, f.strips.position, f.strips.attitude, f.ap_priors.names]
    return [*map(bits, arrays), *(i.tolist() for i in indices), *texts]


def test_they_are_read_in_the_units_of_a_block(folder: Path) -> None:
    f = read_block(folder).further
    assert f.strips.ids == ("west",)
    assert (f.stations.image.tolist(), f.stations.strip.tolist()) == ([0, 1], [0, 0])
    assert f.stations.sigma_attitude[0, 2] == pytest.approx(np.radians(0.02), rel=1e-15)
    assert np.isnan(f.stations.position[1, :2]).all()
    assert f.distances.values.tolist() == [5.25, 5.254]
    assert f.height_differences.start.tolist() == [2]
    assert f.ap_priors.names == ("a3", "a4")
    assert bool(f)


def test_a_folder_with_them_is_written_back_letter_by_letter(folder: Path, tmp_path: Path) -> None:
    write_block(read_block(folder), tmp_path / "copy")
    found = {file.name: file.read_text(encoding="utf-8") for file in (tmp_path / "copy").iterdir()}
    assert found == FILES | FURTHER


def test_a_block_without_them_has_four_files(folder: Path, tmp_path: Path) -> None:
    block = read_block(folder)
    write_block(block.without(), tmp_path / "copy")
    assert {file.name: file.read_text(encoding="utf-8") for file in (tmp_path / "copy").iterdir()} == FILES
    assert not block.without().further
    assert len(block.without("stations").further.strips) == 0
    assert len(block.without("stations").further.distances) == 2
    with pytest.raises(KeyError, match="no further observations named 'gnss', there are stations"):
        block.without("gnss")


def test_a_file_that_would_be_read_with_the_block_is_not_left_there(folder: Path) -> None:
    block = read_block(folder)
    write_block(block.without("stations", "distances"), folder)
    assert not (folder / "strips.csv").exists()
    assert not len(read_block(folder).further.distances)
    write_block(block, folder)
    assert tables(read_block(folder).further) == tables(block.further)


def test_other_image_points_and_points_keep_them(folder: Path) -> None:
    block = read_block(folder)
    assert block.replace_image_points(block.observations.xy + 1.0).further is block.further


positive = st.floats(SIGMA_LEAST, SIGMA_MOST)
number = st.floats(allow_nan=False, allow_infinity=False)


@st.composite
def furthers(draw: st.DrawFn) -> Further:
    """Any numbers whatever for the two images, three points and one camera of the small folder."""

    def pair(values: st.SearchStrategy[float], shape: tuple[int, ...], sigma: Any = positive) -> tuple[Any, Any]:
        size = int(np.prod(shape))
        both = [draw(st.lists(s, min_size=size, max_size=size)) for s in (values, sigma)]
        return np.reshape(both[0], shape), np.reshape(both[1], shape)

    position, attitude = (
        pair(number, (2, 3)),
        pair(st.floats(-ANGLE_MOST, ANGLE_MOST), (2, 3), st.floats(SIGMA_LEAST, ANGLE_MOST)),
    )
    seen = np.array(draw(st.lists(st.booleans(), min_size=6, max_size=6))).reshape(2, 3)
    attitude = tuple(np.where(seen, each, np.nan) for each in attitude)
    clock = draw(st.one_of(st.just([np.nan, np.nan]), st.lists(number, min_size=2, max_size=2, unique=True)))
    station = Stations(np.arange(2), [0, draw(st.sampled_from([-1, 0]))], clock, *position, *attitude)
    biases = ["none", "offset"] if (station.strip == -1).any() else ["none", "offset", "drift"]
    strips = Strips(("s",), (draw(st.sampled_from(biases)),), (draw(st.sampled_from(biases)),))
    distances, heights = pair(positive, (2,)), pair(number, (1,))
    return Further(
        strips, station, Lines([0, 1], [1, 2], *distances), Lines([2], [0], *heights), Priors([0], ("b",), *heights)
    )


@settings(max_examples=60, deadline=None)
@given(further=furthers())
def test_any_come_back_bit_by_bit(tmp_path_factory: pytest.TempPathFactory, further: Further) -> None:
    folder = tmp_path_factory.mktemp("any")
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8", newline="")
    small = read_block(folder)
    block = Block(small.cameras, small.images, small.points, small.observations, further)
    write_block(block, folder / "copy")
    assert tables(read_block(folder / "copy").further) == tables(further)


@pytest.mark.parametrize(
    ("file", "old", "new", "row", "column", "reason"),
    [
        ("stations.csv", "time_s", "time", 1, "time", "unknown column 'time', did you mean time_s?"),
        ("distances.csv", ",sigma_m", "", 1, "sigma_m", "is missing"),
        ("stations.csv", "b,west", "c,west", 3, "image_id", "'c' is not in images.csv"),
        ("stations.csv", "b,west", "a,west", 3, "image_id", "stands there twice"),
        ("stations.csv", "b,west", "b,east", 3, "strip_id", "'east' is not in strips.csv"),
        ("stations.csv", ",20.0,", ",,", 3, "time_s", "is empty while others of its strip are given"),
        ("stations.csv", "1501.0,,,0.1", "1501.0,,,0.0", 3, "sigma_Z0_m", "must be finite and > 0"),
        ("stations.csv", "1501.0,,,0.1", "1501.0,,,", 3, "sigma_Z0_m", "is empty while Z0_m is given"),
        ("stations.csv", "1501.0,,,0.1", ",,,0.1", 3, "Z0_m", "is empty while sigma_Z0_m is given"),
        ("stations.csv", "1501.0,,,0.1", ",,,", 3, None, "has neither a position nor an attitude"),
        ("stations.csv", "0.1,,90.0", "1e3,,90.0", 2, "omega_deg", "|angle| <= 720 degrees"),
        ("strips.csv", "drift", "shift", 2, "position_bias", "'shift' is no bias, allowed are none, offset, drift"),
        ("strips.csv", "west,", "east,", None, None, "is not in strips.csv"),
        ("stations.csv", ",20.0,", ",12.5,", 2, "position_bias", "a drift needs two stations at different times"),
        ("distances.csv", "1,2,5.254", "1,7,5.254", 3, "to_point_id", "'7' is not in points.csv"),
        ("distances.csv", "1,2,5.254", "2,2,5.254", 3, "to_point_id", "both ends are the same point"),
        ("distances.csv", "5.254", "-5.254", 3, "distance_m", "must be > 0"),
        ("distances.csv", "5.254", "", 3, "distance_m", "is empty, a number is needed"),
        ("height_differences.csv", "0.002", "0", 2, "sigma_m", "must be finite and > 0"),
        ("ap_priors.csv", "ww,a4", "x,a4", 3, "camera_id", "'x' is not in cameras.csv"),
        ("ap_priors.csv", "ww,a4", "ww,a3", 3, "parameter", "stands there twice"),
        ("ap_priors.csv", "ww,a4", "ww,", 3, "parameter", "is not the name of a parameter"),
        ("ap_priors.csv", "1e-13", "inf", 3, "sigma", "must be finite"),
    ],
)
def test_a_defect_is_named_with_file_row_and_column(
    folder: Path, file: str, old: str, new: str, row: int | None, column: str | None, reason: str
) -> None:
    text = FURTHER[file]
    assert old in text
    (folder / file).write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(BlockFolderError) as caught:
        read_block(folder)
    assert len(str(caught.value).splitlines()) == 1
    assert reason in caught.value.reason
    if row is not None:
        assert (caught.value.file.name.split(".")[0], caught.value.row, caught.value.column) == (
            "strips" if column == "position_bias" else file.split(".")[0],
            row,
            column,
        )


def test_strips_without_stations(folder: Path) -> None:
    (folder / "stations.csv").unlink()
    with pytest.raises(BlockFolderError, match=r"stations\.csv: is missing, strips\.csv says something"):
        read_block(folder)


@pytest.mark.parametrize(
    ("kept", "stations", "distances", "heights", "bias"),
    [
        (lambda b: b.select(points=["1", "2"]), 2, 2, 0, ("drift",)),
        (lambda b: b.select(points=["2", "3"]), 2, 0, 0, ("drift",)),
    ],
)
def test_a_selection_keeps_what_it_can(
    folder: Path, kept: Callable[[Block], Block], stations: int, distances: int, heights: int, bias: tuple[str, ...]
) -> None:
    f = kept(read_block(folder)).further
    assert (len(f.stations), len(f.distances), len(f.height_differences)) == (stations, distances, heights)
    assert f.strips.position == bias


def test_a_strip_with_one_station_left_has_no_drift(folder: Path) -> None:
    images = np.array([False, True])
    f = read_block(folder).further.select(images, np.ones(3, dtype=bool), np.ones(1, dtype=bool))
    assert (f.strips.position, f.strips.attitude) == (("offset",), ("none",))
    assert (f.stations.image.tolist(), f.stations.strip.tolist()) == ([0], [0])
    assert f.stations.position[0, 2] == 1501.0
