"""Numbers and places of points, control layouts, images in the direction of flight."""

import numpy as np
import pytest

from simfield.world.cameras import SWW, WW
from simfield.world.fields import Control, Quincunx, RegularGrid, Relief
from simfield.world.flights import Flight, fly, looking, plan_flights
from simfield.world.imaging import attitude_quaternion, ideal_image, into_camera_frame


def test_the_rheidt_field_has_starks_numbers():
    field = Quincunx().build(seed=1)
    assert len(field) == 123
    rows = ["11-15", "16-19", "21-25", "26-29", "31-35", "36-39", "41-45", "46-49", "51-55"]
    wanted = [str(i) for row in rows for i in range(int(row[:2]), int(row[3:]) + 1)]
    assert list(field.group_ids) == wanted
    assert field.ids[:4] == ("11", "11.1", "11.2", "12")
    assert np.count_nonzero(field.central) == 41
    at = dict(zip(field.ids, field.coordinates, strict=True))
    assert at["11"][:2].tolist() == [-1000.0, 1000.0]
    assert at["16"][:2].tolist() == [-750.0, 750.0]
    assert at["33"][:2].tolist() == [0.0, 0.0]
    assert at["55"][:2].tolist() == [1000.0, -1000.0]
    for a, b in (("11", "11.1"), ("11", "11.2"), ("11.1", "11.2")):
        assert np.hypot(*(at[a] - at[b])[:2]) == pytest.approx(20.0)


def test_heights_follow_the_relief_and_the_seed():
    relief = Relief(mean_m=70.0, sigma_m=4.0, member_sigma_m=0.0)
    grid = RegularGrid(40, 40, 100.0, relief=relief)
    heights = grid.build(seed=2).coordinates[:, 2]
    assert abs(heights.mean() - 70.0) < 3.0 * 4.0 / 40.0
    assert abs(heights.std() - 4.0) < 3.0 * 4.0 / np.sqrt(2 * 1600)
    assert (grid.build(seed=2).coordinates[:, 2] == heights).all()
    assert (grid.build(seed=3).coordinates[:, 2] != heights).all()


def test_central_points_are_the_same_without_their_auxiliary_points():
    three, one = Quincunx().build(1), Quincunx(group_size=1).build(1)
    assert (three.coordinates[three.central] == one.coordinates).all()


@pytest.mark.parametrize(
    ("layout", "ids"),
    [
        ("none", set()),
        ("corners", {"11", "15", "51", "55"}),
        ("corners-and-centre", {"11", "15", "33", "51", "55"}),
        ("perimeter", {str(i) for i in (11, 12, 13, 14, 15, 21, 25, 31, 35, 41, 45, 51, 52, 53, 54, 55)}),
    ],
)
def test_control_layouts_take_central_points(layout, ids):
    field = Quincunx().build(1)
    assert {field.ids[i] for i in np.flatnonzero(Control(layout).of(field))} == ids


def test_dense_control_takes_everything():
    assert Control("dense").of(Quincunx().build(1)).all()


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (lambda: Quincunx(per_side=6), "2 to 5"),
        (lambda: Quincunx(member_spacing_m=300.0), "mixes"),
        (lambda: RegularGrid(1, 5, 10.0), "too small"),
        (lambda: RegularGrid(5, 5, 0.0), "> 0"),
        (lambda: Relief(sigma_m=-1.0), ">= 0"),
        (lambda: Control(sigma_z_mm=-1.0), ">= 0"),
        (lambda: Flight("f", "ww", 0.0), "scale"),
        (lambda: Flight("f", "ww", 1e4, headings_gon=()), "heading"),
        (lambda: Flight("f", "ww", 1e4, forward_overlap=60.0), "share"),
        (lambda: Flight("f ", "ww", 1e4), "flight_id"),
    ],
)
def test_nonsense_is_refused(make, reason):
    with pytest.raises(ValueError, match=reason):
        make()


def test_image_x_is_the_direction_of_flight():
    plan = plan_flights([Flight("f", "ww", 1e4, headings_gon=(0.0, 50.0, 100.0, 200.0, 300.0))], [WW])
    for strip in range(5):
        first, middle, last = plan.exterior[3 * strip : 3 * strip + 3]
        forward = into_camera_frame(middle[None], last[None, :3])[0, 0]
        base_m = 10000 * 0.23 * 0.4
        np.testing.assert_allclose(forward, [base_m, 0.0, 0.0], atol=1e-9)
        np.testing.assert_allclose(first[:3] + last[:3], 2 * middle[:3], atol=1e-9)
        assert middle[:2].tolist() == [0.0, 0.0]
    north = plan.exterior[2]
    np.testing.assert_allclose(north[:2], [0.0, 920.0], atol=1e-9, err_msg="heading 0 flies north")
    east = plan.exterior[8]
    np.testing.assert_allclose(east[[0, 1, 5]], [920.0, 0.0, 0.0], atol=1e-9, err_msg="heading 100 gon flies east")


def test_scale_and_names():
    plan = plan_flights([Flight("sww-after", "sww", 10200.0, headings_gon=(0.0, 100.0))], [SWW])
    assert plan.image_ids[4] == "sww-after-h100-2"
    assert plan.strip_ids[4] == "sww-after-h100"
    assert plan.exterior[0, 2] == pytest.approx(50.0 + 10.2 * 85.5)


def test_parallel_strips_lie_a_sidelap_apart_and_alternate():
    plan = plan_flights([Flight("f", "ww", 1e4, headings_gon=(100.0,), strips=3, images_per_strip=4)], [WW])
    assert len(plan) == 12
    assert sorted({round(y, 6) for y in plan.exterior[:, 1]}) == [-1610.0, 0.0, 1610.0]
    assert plan.strip_ids[0] == "f-h100-s1"
    assert plan.strip_ids[4] == "f-h300-s2"


def test_deviations_have_their_size_and_belong_to_the_image():
    flights = [Flight("f", "ww", 1e4, images_per_strip=500, forward_overlap=0.9)]
    plan = plan_flights(flights, [WW])
    moved = fly(plan, flights, seed=1) - plan.exterior
    for columns, sigma in ((slice(0, 3), 25.0), (slice(3, 6), np.deg2rad(1.0))):
        found = moved[:, columns]
        assert abs(found.std() - sigma) < 3.0 * sigma / np.sqrt(2 * found.size)
    more = [Flight("e", "ww", 1e4), *flights]
    np.testing.assert_array_equal(fly(plan_flights(more, [WW]), more, seed=1)[3:], moved + plan.exterior)


def test_convergent_images_show_the_centre_in_their_middle():
    plan = plan_flights([Flight("f", "ww", 100.0, (0.0, 70.0), look="centre", forward_overlap=0.0)], [WW])
    middle = ideal_image(plan.exterior, [WW] * len(plan), np.array([[0.0, 0.0, 50.0]]))
    np.testing.assert_allclose(middle, 0.0, atol=1e-9)
    omega, phi, kappa = looking(np.array([0.3, -0.5, -1.0]), np.array([1.0, 0.0]))
    assert max(abs(omega), abs(kappa)) < np.pi / 2
    assert np.linalg.norm(attitude_quaternion(np.array([[omega, phi, kappa]]))) == pytest.approx(1.0)
