"""The block refuses every defect with its table, row and column, and cannot be changed afterwards."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from simfield.block.block import Block, BlockError, Camera, ImageObservations, Images, Points

CAMERA = Camera("ww", 153.0, 0.01, -0.02, 230.0, 230.0)
NAN, INF = np.nan, np.inf


def small_block(**changes: Any) -> Block:
    """Two images, one of them without start values, of a control, a check and a tie point; changes replace tables."""
    tables: dict[str, Any] = {
        "cameras": (CAMERA,),
        "images": Images(("a", "b"), np.array([0, 0]), np.array([[0, 0, 1500, 0, 0, 1], [NAN] * 6])),
        "points": Points(
            ("p", "q", "r"),
            np.array(["control", "check", "tie"]),
            np.array([[1.0, 2, 3], [4, 5, 6], [NAN, NAN, NAN]]),
            np.array([[0.0, 0.01, NAN], [NAN] * 3, [NAN] * 3]),
        ),
        "observations": ImageObservations(
            np.array([0, 0, 0, 1, 1, 1]),
            np.array([0, 1, 2, 0, 1, 2]),
            np.arange(12.0).reshape(6, 2),
            np.full((6, 2), 0.005),
        ),
    }
    return Block(**(tables | changes))


def changed(table: Any, name: str, at: Any, value: Any) -> Any:
    array = getattr(table, name).copy()
    array[at] = value
    return replace(table, **{name: array})


def refusal(**changes: Any) -> BlockError:
    with pytest.raises(BlockError) as caught:
        small_block(**changes)
    return caught.value


def test_a_sound_block_counts_its_rays_and_names_its_cameras() -> None:
    block = small_block()
    assert block.rays.tolist() == [2, 2, 2]
    assert block.camera_ids == ("ww",)
    assert block.image_camera.tolist() == [0] * 6
    assert (len(block.images), len(block.points), len(block.observations)) == (2, 3, 6)


def test_sigma_of_a_control_coordinate_says_fixed_weighted_or_unknown() -> None:
    points = small_block().points
    assert points.fixed.tolist() == [[True, False, False], [False] * 3, [False] * 3]
    assert points.weighted.tolist() == [[False, True, False], [False] * 3, [False] * 3]


def test_arrays_are_owned_copies_and_read_only() -> None:
    xy = np.zeros((6, 2))
    observations = replace(small_block().observations, xy=xy)
    xy[0] = 1.0
    assert observations.xy[0].tolist() == [0.0, 0.0]
    with pytest.raises(ValueError, match="read-only"):
        observations.xy[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        small_block().rays[0] = 1


@pytest.mark.parametrize(
    ("change", "column", "reason"),
    [
        ({"c_mm": 0.0}, "c_mm", "must be > 0"),
        ({"c_mm": -153.0}, "c_mm", "must be > 0"),
        ({"width_mm": 0.0}, "width_mm", "must be > 0"),
        ({"height_mm": -1.0}, "height_mm", "must be > 0"),
        ({"x0_mm": NAN}, "x0_mm", "must be finite"),
        ({"y0_mm": INF}, "y0_mm", "must be finite"),
        ({"camera_id": ""}, "camera_id", "is not an id"),
        ({"camera_id": " ww"}, "camera_id", "is not an id"),
    ],
)
def test_a_camera_is_refused(change: dict[str, Any], column: str, reason: str) -> None:
    error = refusal(cameras=(CAMERA, replace(replace(CAMERA, camera_id="sww"), **change)))
    assert (error.table, error.row, error.column) == ("cameras", 1, column)
    assert reason in error.reason


def test_duplicate_ids_are_refused_with_both_rows() -> None:
    error = refusal(cameras=(CAMERA, CAMERA))
    assert (error.table, error.row, error.column) == ("cameras", 1, "camera_id")
    assert str(error) == "cameras row 1, camera_id: 'ww' stands already in row 0"
    block = small_block()
    assert refusal(images=replace(block.images, ids=("a", "a"))).row == 1
    assert refusal(points=replace(block.points, ids=("p", "q", "p"))).row == 2


def test_empty_tables_are_refused() -> None:
    none = np.zeros(0, dtype=int)
    assert str(refusal(cameras=())) == "cameras: is empty"
    assert refusal(images=Images((), none, np.zeros((0, 6)))).table == "images"
    assert refusal(points=Points((), np.zeros(0, "U1"), np.zeros((0, 3)), np.zeros((0, 3)))).table == "points"
    empty = ImageObservations(none, none, np.zeros((0, 2)), np.zeros((0, 2)))
    assert str(refusal(observations=empty)) == "observations: is empty"


@pytest.mark.parametrize(
    ("table", "name", "at", "value", "place", "reason"),
    [
        ("images", "exterior", (0, 1), INF, (0, "Y0_m"), "must be finite or empty"),
        ("images", "exterior", (0, 4), NAN, (0, "phi_deg"), "give all six or none"),
        ("images", "exterior", (1, 0), 7.0, (1, "Y0_m"), "give all six or none"),
        ("images", "exterior", (0, 5), 100.0, (0, "kappa_deg"), "|angle| <= 720 degrees"),
        ("images", "camera", 1, 1, (1, "camera_id"), "index 1 is outside 0..0"),
        ("images", "camera", 1, -1, (1, "camera_id"), "index -1 is outside 0..0"),
        ("points", "role", 1, "chec", (1, "role"), "'chec' is no role, allowed are control, check, tie"),
        ("points", "coordinates", (1, 2), INF, (1, "Z_m"), "must be finite or empty"),
        ("points", "sigma", (0, 0), INF, (0, "sigma_X_m"), "must be finite or empty"),
        ("points", "sigma", (0, 1), -0.01, (0, "sigma_Y_m"), "must be >= 0 or empty"),
        ("points", "coordinates", (0, 1), NAN, (0, "Y_m"), "a control coordinate with a sigma needs a value"),
        ("observations", "xy", (2, 0), NAN, (2, "x_mm"), "must be finite"),
        ("observations", "xy", (2, 1), -INF, (2, "y_mm"), "must be finite"),
        ("observations", "sigma", (3, 0), 0.0, (3, "sigma_x_mm"), "must be finite and > 0"),
        ("observations", "sigma", (3, 1), -1.0, (3, "sigma_y_mm"), "must be finite and > 0"),
        ("observations", "sigma", (3, 1), NAN, (3, "sigma_y_mm"), "must be finite and > 0"),
        (
            "observations",
            "sigma",
            (3, 1),
            1e160,
            (3, "sigma_y_mm"),
            "a standard deviation is between 1e-50 and 1e+50",
        ),
        (
            "observations",
            "sigma",
            (3, 0),
            1e-160,
            (3, "sigma_x_mm"),
            "a standard deviation is between 1e-50 and 1e+50",
        ),
        ("points", "sigma", (0, 1), 1e160, (0, "sigma_Y_m"), "a standard deviation is between 1e-50 and 1e+50"),
        ("observations", "image", 4, 2, (4, "image_id"), "index 2 is outside 0..1"),
        ("observations", "point", 5, 3, (5, "point_id"), "index 3 is outside 0..2"),
        ("observations", "point", 1, 0, (1, "point_id"), "point 'p' was already measured in image 'a'"),
    ],
)
def test_a_defect_is_refused_with_its_place(
    table: str, name: str, at: Any, value: Any, place: tuple[int, str], reason: str
) -> None:
    error = refusal(**{table: changed(getattr(small_block(), table), name, at, value)})
    assert error.table == table
    assert (error.row, error.column) == place
    assert reason in error.reason
    assert "\n" not in str(error)


@pytest.mark.parametrize(
    ("table", "name", "array"),
    [
        ("images", "exterior", np.zeros((2, 5))),
        ("images", "camera", np.zeros((2, 1))),
        ("points", "role", np.array(["tie"])),
        ("points", "coordinates", np.zeros((3, 2))),
        ("points", "sigma", np.zeros(3)),
        ("observations", "point", np.zeros(5)),
        ("observations", "xy", np.zeros((6, 3))),
        ("observations", "sigma", np.zeros((5, 2))),
    ],
)
def test_an_array_of_the_wrong_shape_is_refused(table: str, name: str, array: Any) -> None:
    error = refusal(**{table: replace(getattr(small_block(), table), **{name: array})})
    assert error.table == table
    assert f"{name} has shape {array.shape}" in error.reason


@pytest.mark.parametrize("role", ["tie", "check"])
def test_a_point_with_one_ray_is_named_unless_it_is_control(role: str) -> None:
    block = small_block()
    o = block.observations
    less = ImageObservations(o.image[:5], o.point[:5], o.xy[:5], o.sigma[:5])
    error = refusal(points=changed(block.points, "role", 2, role), observations=less)
    assert str(error) == f"points row 2, point_id: {role} point 'r' has 1 ray(s), at least two are needed"
    points = changed(block.points, "role", 2, "control")
    assert small_block(points=points, observations=less).rays.tolist() == [2, 2, 1]


def test_other_image_points_make_another_block() -> None:
    block = small_block()
    other = block.replace_image_points(block.observations.xy + 1.0)
    assert (other.observations.xy - block.observations.xy == 1.0).all()
    assert other.images is block.images
    with pytest.raises(BlockError, match="xy has shape"):
        block.replace_image_points(np.zeros((6, 3)))


def test_a_selection_keeps_what_is_named_and_drops_what_is_left_alone() -> None:
    two = small_block(
        cameras=(replace(CAMERA, camera_id="sww"), CAMERA),
        images=Images(("a", "b"), np.array([1, 1]), np.full((2, 6), NAN)),
    )
    part = two.select(points={"r", "p"})
    assert part.camera_ids == ("ww",)
    assert part.points.ids == ("p", "r")
    assert part.observations.point.tolist() == [0, 1, 0, 1]
    assert part.observations.xy.tolist() == two.observations.xy[[0, 2, 3, 5]].tolist()
    assert two.select(cameras=["ww"]).images.ids == ("a", "b")
    with pytest.raises(BlockError, match="has 1 ray"):
        two.select(images=["a"])


@pytest.mark.parametrize("kind", ["camera", "image", "point"])
def test_a_selection_of_an_unknown_name_is_a_key_error(kind: str) -> None:
    with pytest.raises(KeyError, match=f"no {kind} named 'x' in this block"):
        small_block().select(**{f"{kind}s": ["x"]})
