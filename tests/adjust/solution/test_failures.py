# Over 300 lines: every way to fail, one table after the other, read as a list
"""What cannot be adjusted ends with a status and a sentence that names the defect; nothing is raised or warned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

from adjust import Adjustment, Status, adjust_block
from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.terms import Term
from adjust.status import CHECK_START
from simfield.block.block import Block, Floats, ImageObservations
from simfield.block.checks import SIGMA_LEAST, SIGMA_MOST
from tests import synthetic

NAN = float("nan")


def failed(block: Block, status: Status, model: ApModel | None = None) -> str:
    """The detail of the message, after making sure that a failure is one everywhere."""
    plain = adjust_block(block, model, compiled=False)
    a = adjust_block(block, model)
    assert a.status is status, a.message
    assert a.message == plain.message
    assert a.message.startswith(status.value + ": ")
    assert "\n" not in a.message
    assert_no_result(a)
    return a.message.removeprefix(status.value + ": ")


def assert_no_result(a: Adjustment) -> None:
    assert np.isnan(a.sigma0)
    assert np.isnan(a.m0_um)
    assert np.isnan(a.std).all()
    assert np.isnan(a.images.std).all()
    assert np.isnan(a.points.std).all()
    for estimate in a.ap.values():
        assert np.isnan(estimate.std).all()
    image = a.block.images.ids[0]
    with pytest.raises(ValueError, match="no cofactors"):
        a.covariance((image, "Z0"))
    with pytest.raises(ValueError, match="no cofactors"):
        a.correlation((image, "Z0"))
    assert a.redundancy == a.observations - a.unknowns
    assert a.residuals.shape == (len(a.block.observations), 2)


class TestDatum:
    """How much of the datum the control fixes. Models must not matter, nor relief, nor tilts, nor fixed or weighted."""

    def test_no_control(self, ww_world: synthetic.World) -> None:
        said = failed(ww_world.controlled([]).block, Status.SINGULAR)
        assert said == "there is no control, so the datum is free (shift, rotation and scale of the whole block)"

    @pytest.mark.parametrize("sigma", [0.0, 0.01])
    def test_one_control_point(self, ww_world: synthetic.World, sigma: float) -> None:
        said = failed(ww_world.controlled(["33"], (sigma,) * 3).block, Status.SINGULAR)
        assert said == (
            "the control fixes only 3 of the 7 datum elements; "
            "free: rotation about X, rotation about Y, rotation about Z and scale"
        )

    @pytest.mark.parametrize("sigma", [0.0, 0.01])
    @pytest.mark.parametrize("ids", [("11", "55"), ("11", "15"), ("33", "16"), ("24", "49")])
    def test_two_control_points(self, two_camera_world: synthetic.World, ids: Sequence[str], sigma: float) -> None:
        said = failed(two_camera_world.controlled(ids, (sigma,) * 3).block, Status.SINGULAR)
        assert said == (
            "the control fixes only 6 of the 7 datum elements; "
            f"free: rotation about the line through the control points {ids[0]} and {ids[1]}"
        )

    @pytest.mark.parametrize("model_name", ["none", "brown14"])
    @pytest.mark.parametrize("seed", range(6))
    def test_two_control_points_in_any_flight(self, seed: int, model_name: str) -> None:
        """The last pivot of such a block is anything from 1e-9 to below zero, its condition always tells."""
        from adjust import ap_models

        flight = synthetic.fly(synthetic.WW, 10500.0, seed=100 + seed)
        w = synthetic.world([(synthetic.WW, flight)], synthetic.quincunx(seed=seed))
        said = failed(w.controlled(["11", "55"]).block, Status.SINGULAR, ap_models.get(model_name))
        assert said.endswith("the line through the control points 11 and 55")

    def test_control_on_a_line(self) -> None:
        flight = synthetic.fly(synthetic.WW, 10500.0)
        field = synthetic.quincunx()
        for name in ("11", "22", "33", "44", "55"):
            field[name][2] = 0.01 * field[name][0]
        w = synthetic.world([(synthetic.WW, flight)], field).controlled(["11", "22", "33", "44", "55"])
        said = failed(w.block, Status.SINGULAR)
        assert said == (
            "the control fixes only 6 of the 7 datum elements; "
            "free: rotation about the line through the control points 11, 22, 33, 44 and 55"
        )

    def test_control_on_a_line_along_an_axis(self, vertical_world: synthetic.World) -> None:
        said = failed(vertical_world.controlled(["31", "32", "34", "35"]).block, Status.SINGULAR)
        assert said == "the control fixes only 6 of the 7 datum elements; free: rotation about X"

    def test_height_control_only(self, ww_world: synthetic.World) -> None:
        said = failed(ww_world.controlled(synthetic.CONTROL, (NAN, NAN, 0.0)).block, Status.SINGULAR)
        assert said == (
            "the control fixes only 4 of the 7 datum elements; free: shift in X, shift in Y and rotation about Z"
        )

    def test_height_control_on_a_plain(self, vertical_world: synthetic.World) -> None:
        said = failed(vertical_world.controlled(synthetic.CONTROL, (NAN, NAN, 0.02)).block, Status.SINGULAR)
        assert said == (
            "the control fixes only 3 of the 7 datum elements; free: shift in X, shift in Y, rotation about Z and scale"
        )

    def test_plan_control_only(self, ww_world: synthetic.World) -> None:
        said = failed(ww_world.controlled(synthetic.CONTROL, (0.0, 0.0, NAN)).block, Status.SINGULAR)
        assert said == "the control fixes only 6 of the 7 datum elements; free: shift in Z"

    def test_control_without_any_weight_to_speak_of(self, ww_world: synthetic.World) -> None:
        said = failed(ww_world.controlled(synthetic.CONTROL, (1e7, 1e7, 1e7)).block, Status.SINGULAR)
        assert "datum" in said

    def test_weak_control_is_weak_and_not_singular(self, ww_world: synthetic.World) -> None:
        a = adjust_block(ww_world.controlled(synthetic.CONTROL, (100.0, 100.0, 100.0)).block)
        assert a.status.ok, a.message


@dataclass(frozen=True)
class UserModel(ApModel):
    """Terms of a user, who has not thought enough."""

    names: tuple[str, ...] = ("k1",)
    which: Any = None

    id: ClassVar[str] = "user"
    title: ClassVar[str] = "A user's model"
    author: ClassVar[str] = "-"
    year: ClassVar[int] = 0
    source: ClassVar[str] = "-"
    certainty: ClassVar[Certainty] = Certainty.CERTAIN

    @property
    def parameters(self) -> tuple[str, ...]:
        return self.names

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        return list(self.which(x, y))


SCALE = UserModel(("k1",), lambda x, y: [(x, y)])
ROTATION = UserModel(("k1",), lambda x, y: [(-y, x)])
SHIFT = UserModel(("k1", "k2"), lambda x, y: [(1, 0), (0, 1)])
AFFINE = UserModel(("k1", "k2", "k3"), lambda x, y: [(x, 0), (0, y), (x * y, 0)])
TWINS = UserModel(("k1", "k2", "k3"), lambda x, y: [(x * y, y**2), (x**2, 0), (3 * x * y, 3 * y**2)])
IDLE = UserModel(("k1", "k2"), lambda x, y: [(x * y, 0), (0, 0)])
POLE = UserModel(("k1",), lambda x, y: [(1.0 / (x - x[0]), y)])


class TestAdditionalParameters:
    def test_a_scale_of_the_image_is_a_flying_height(self, vertical_world: synthetic.World) -> None:
        said = failed(vertical_world.block, Status.SINGULAR, SCALE)
        assert said == "k1 of camera ww and Z0 of all 12 images cannot be separated"

    def test_from_a_rough_start(self, vertical_world: synthetic.World) -> None:
        """At the start the images are tilted, so nothing is singular; the closer the solution, the more it is."""
        rng = np.random.default_rng(0)
        off = rng.normal(0.0, 1.0, vertical_world.exterior.shape) * [10.0, 10.0, 10.0, 0.02, 0.02, 0.02]
        started = vertical_world.started_at(vertical_world.exterior + off)
        for model, element in ((SCALE, "Z0"), (ROTATION, "kappa")):
            a = adjust_block(started.block, model)
            # which of the two depends on the last digits
            assert a.status in (Status.SINGULAR, Status.NOT_CONVERGED)
            assert f"k1 of camera ww and {element} of all 12 images can" in a.message
            assert_no_result(a)

    def test_relief_separates_them(self, ww_world: synthetic.World) -> None:
        assert adjust_block(ww_world.block, SCALE).status.ok

    def test_a_rotation_of_the_image_is_kappa(self, vertical_world: synthetic.World) -> None:
        said = failed(vertical_world.block, Status.SINGULAR, ROTATION)
        assert said == "k1 of camera ww and kappa of all 12 images cannot be separated"

    def test_a_shift_of_the_image_is_a_shift_of_the_station(self, vertical_world: synthetic.World) -> None:
        said = failed(vertical_world.block, Status.SINGULAR, SHIFT)
        assert said == (
            "k1 of camera ww, k2 of camera ww, X0 of all 12 images and Y0 of all 12 images cannot be separated "
            "(rank defect 2)"
        )

    def test_only_the_guilty_parameters_are_named(self, vertical_world: synthetic.World) -> None:
        said = failed(vertical_world.block, Status.SINGULAR, AFFINE)
        assert said == "k1 of camera ww, k2 of camera ww and Z0 of all 12 images cannot be separated"

    def test_only_the_guilty_camera_is_named(self) -> None:
        flights = [
            (synthetic.WW, synthetic.fly(synthetic.WW, 10500.0, tilt_rad=0.0)),
            (synthetic.SWW, synthetic.fly(synthetic.SWW, 9600.0, tilt_rad=0.0)),
        ]
        w = synthetic.world(flights, synthetic.quincunx(relief_m=0.0))
        a = adjust_block(w.block, {"ww": TWINS, "sww": UserModel(("k1",), lambda x, y: [(x * y, 0)])})
        assert a.status is Status.SINGULAR
        assert a.message.endswith(": k1 of camera ww and k3 of camera ww cannot be separated")

    def test_twins(self, ww_world: synthetic.World) -> None:
        said = failed(ww_world.block, Status.SINGULAR, TWINS)
        assert said == "k1 of camera ww and k3 of camera ww cannot be separated"

    def test_a_term_that_does_nothing(self, ww_world: synthetic.World) -> None:
        said = failed(ww_world.block, Status.SINGULAR, IDLE)
        assert said == "k2 of camera ww has no effect on any measured point"

    def test_a_term_with_a_pole(self, ww_world: synthetic.World) -> None:
        said = failed(ww_world.block, Status.NOT_FINITE, POLE)
        assert said.startswith("the terms of k1 of camera ww are not finite at x = ")

    def test_datum_and_parameters_at_once(self, vertical_world: synthetic.World) -> None:
        said = failed(vertical_world.controlled(["11", "55"]).block, Status.SINGULAR, TWINS)
        datum, parameters = said.split("; free: ")[1].split("; ")
        assert datum == "rotation about the line through the control points 11 and 55"
        assert parameters == "k1 of camera ww and k3 of camera ww cannot be separated"


class TestRedundancy:
    def test_negative(self) -> None:
        flight = synthetic.fly(synthetic.WW, 10500.0, headings=(0.0,))[:2]
        field = {name: xyz for name, xyz in synthetic.quincunx().items() if name in ("13", "33", "53")}
        w = synthetic.world([(synthetic.WW, flight)], field, control=())
        said = failed(w.block, Status.TOO_LITTLE_REDUNDANCY)
        assert said == "12 observations for 21 unknowns, redundancy -9"

    def test_zero(self) -> None:
        flight = synthetic.fly(synthetic.WW, 10500.0, headings=(0.0,))[1:2]
        w = synthetic.world([(synthetic.WW, flight)], synthetic.quincunx(), control=("11", "15", "51"))
        said = failed(w.block, Status.TOO_LITTLE_REDUNDANCY)
        assert said == "6 observations for 6 unknowns, redundancy 0"

    def test_one_is_enough(self, ww_world: synthetic.World) -> None:
        """A single image over control is a resection like any other; a height observed brings the only redundancy."""
        flight = synthetic.fly(synthetic.WW, 10500.0, headings=(0.0,))[1:2]
        w = synthetic.world([(synthetic.WW, flight)], synthetic.quincunx(), control=("11", "15", "51", "33"))
        sigma = np.zeros((4, 3))
        sigma[w.block.points.ids.index("33"), 2] = 0.01
        sigma[w.block.points.ids.index("33"), 0] = np.nan
        a = adjust_block(w.with_points(sigma=sigma).block)
        assert a.redundancy == 1
        assert a.status.ok, a.message
        assert np.isfinite(a.std).all()


class TestImages:
    def thinned(self, w: synthetic.World, image: int, points: Sequence[str] | int) -> Block:
        """Image number `image` keeps only these points, or so many."""
        o = w.block.observations
        mine = np.flatnonzero(o.image == image)
        if isinstance(points, int):
            mine = mine[:points]
        else:
            mine = mine[np.isin([w.block.points.ids[i] for i in o.point[mine]], points)]
        rows = np.sort(np.concatenate([np.flatnonzero(o.image != image), mine]))
        few = ImageObservations(o.image[rows], o.point[rows], o.xy[rows], o.sigma[rows])
        return Block(w.block.cameras, w.block.images, w.block.points, few)

    def test_two_points(self, ww_world: synthetic.World) -> None:
        said = failed(self.thinned(ww_world, 2, 2), Status.SINGULAR)
        assert said == (
            "image ww-3 (2 measured points) cannot be oriented: three or more points are needed, not on one line"
        )

    def test_one_point(self, ww_world: synthetic.World) -> None:
        said = failed(self.thinned(ww_world, 2, 1), Status.SINGULAR)
        assert said.startswith("image ww-3 (1 measured point) cannot be oriented")

    def test_points_on_a_line(self, vertical_world: synthetic.World) -> None:
        said = failed(self.thinned(vertical_world, 4, ["31", "32", "33", "34", "35"]), Status.SINGULAR)
        assert said.startswith("image ww-5 (5 measured points) cannot be oriented")

    def test_three_points_are_enough(self, ww_world: synthetic.World) -> None:
        assert adjust_block(self.thinned(ww_world, 2, ["13", "33", "35"])).status.ok

    def test_no_points(self, ww_world: synthetic.World) -> None:
        said = failed(self.thinned(ww_world, 2, 0), Status.SINGULAR)
        assert said == "image ww-3 has no measured points"

    def test_two_images_and_the_datum(self, ww_world: synthetic.World) -> None:
        w = ww_world.controlled(["33"])
        once = w.__class__(self.thinned(w, 2, 2), w.exterior, w.coordinates, w.models, w.ap)
        said = failed(self.thinned(once, 8, 1), Status.SINGULAR)
        images, datum, free = said.split("; ")  # in this order
        assert images.startswith("image ww-3 (2 measured points) and image ww-9 (1 measured point) cannot be oriented")
        assert datum.endswith("only 3 of the 7 datum elements")
        assert free == "free: rotation about X, rotation about Y, rotation about Z and scale"


class TestPoints:
    def test_parallel_rays(self) -> None:
        station = synthetic.fly(synthetic.WW, 10500.0, headings=(0.0,), tilt_rad=0.0)[1]
        w = synthetic.world([(synthetic.WW, np.array([station] * 3))], synthetic.quincunx())
        said = failed(w.block, Status.SINGULAR)
        assert said == "point 12 is not determined: its 3 rays are parallel"

    @pytest.mark.parametrize("rays", [0, 1])
    def test_control_without_coordinates_and_with_too_few_rays(self, ww_world: synthetic.World, rays: int) -> None:
        p, o = ww_world.block.points, ww_world.block.observations
        at = p.ids.index("11")
        sigma = np.where(np.arange(len(p))[:, None] == at, np.nan, p.sigma)
        w = ww_world.with_points(sigma=sigma)  # its coordinates stay as a start value
        mine = np.flatnonzero(o.point == at)[rays:]
        rows = np.setdiff1d(np.arange(len(o)), mine)
        few = ImageObservations(o.image[rows], o.point[rows], o.xy[rows], o.sigma[rows])
        said = failed(Block(w.block.cameras, w.block.images, w.block.points, few), Status.SINGULAR)
        assert said.startswith(f"point 11 is not determined: it has {rays} ray")


class TestStart:
    def test_no_orientation_and_no_control(self, ww_world: synthetic.World) -> None:
        w = ww_world.controlled(["11", "33"])
        said = failed(w.started_at(np.full_like(w.exterior, np.nan)).block, Status.NO_START)
        assert said.startswith("image ww-1 has no approximate orientation, and fewer than three points with known")

    @pytest.mark.parametrize(
        "mistake",
        [
            pytest.param(lambda a: np.mod(np.rad2deg(a), 2 * np.pi), id="degrees taken for radians"),
            pytest.param(lambda a: np.add(a, [np.pi, 0.0, 0.0]), id="upside down"),
            pytest.param(lambda a: np.add(a, [0.0, 0.0, np.pi]), id="kappa off by 180 degrees"),
            pytest.param(lambda a: -a, id="signs"),
        ],
    )
    def test_wrong_angles(self, ww_world: synthetic.World, mistake: Any) -> None:
        exterior = ww_world.exterior.copy()
        exterior[:, 3:] = mistake(exterior[:, 3:])
        a = adjust_block(ww_world.started_at(exterior).block)
        assert not a.status.ok
        assert CHECK_START in a.message
        assert_no_result(a)

    def test_radians_taken_for_degrees(self, ww_world: synthetic.World) -> None:
        """Almost vertical images without headings: either the right result or none, never a wrong one."""
        exterior = ww_world.exterior.copy()
        exterior[:, 3:] = np.deg2rad(exterior[:, 3:])
        a = adjust_block(ww_world.started_at(exterior).block)
        assert a.status is not Status.CONVERGED or a.sigma0 < 1e-6

    @pytest.mark.parametrize("column", [0, 1, 2])
    def test_one_image_that_looks_up(self, ww_world: synthetic.World, column: int) -> None:
        exterior = ww_world.exterior.copy()
        exterior[column, 3] += np.pi
        said = failed(ww_world.started_at(exterior).block, Status.BEHIND_CAMERA)
        assert f"behind image ww-{column + 1}" in said

    def test_orientations_all_zero(self) -> None:
        """Stations in the middle of the points: depth zero is met exactly on flat ground."""
        for relief in (0.0, 40.0):
            flight = synthetic.fly(synthetic.WW, 10500.0)
            w = synthetic.world([(synthetic.WW, flight)], synthetic.quincunx(relief_m=relief))
            a = adjust_block(w.started_at(np.zeros_like(w.exterior)).block)
            assert a.status in (Status.BEHIND_CAMERA, Status.NO_START)
            assert a.message.endswith(CHECK_START)
            assert_no_result(a)

    def test_below_the_ground(self, ww_world: synthetic.World) -> None:
        exterior = ww_world.exterior * [1.0, 1.0, -1.0, 1.0, 1.0, 1.0]
        a = adjust_block(ww_world.started_at(exterior).block)
        assert a.status in (Status.BEHIND_CAMERA, Status.NO_START)
        assert_no_result(a)


class TestUnits:
    @pytest.mark.parametrize("factor", [1e-3, 1e3])
    def test_metres_and_micrometres_for_millimetres(self, ww_world: synthetic.World, factor: float) -> None:
        a = adjust_block(ww_world.with_image_points(ww_world.block.observations.xy * factor).block)
        assert not a.status.ok or a.sigma0 > 100.0, "impossible image coordinates, and nothing to see of it"

    @pytest.mark.parametrize("sigma", [SIGMA_LEAST, SIGMA_MOST])
    def test_standard_deviations_far_from_all_units(self, ww_world: synthetic.World, sigma: float) -> None:
        """What a block lets through can be computed with; the iteration ends at 1e-9 of what is stated."""
        o, b = ww_world.with_noise(np.random.default_rng(3)).block.observations, ww_world.block
        usual, strange = (
            adjust_block(Block(b.cameras, b.images, b.points, ImageObservations(o.image, o.point, o.xy, every)))
            for every in (o.sigma, np.full_like(o.sigma, sigma))
        )
        assert strange.status.ok
        np.testing.assert_allclose(strange.coordinates, usual.coordinates, atol=1e-3)
        np.testing.assert_allclose(strange.points.std, usual.points.std, rtol=1e-3)


def test_every_status_is_a_sentence() -> None:
    for status in Status:
        assert status.value[0].islower()
        assert not status.value.endswith(".")
        assert status.ok == (status is Status.CONVERGED)
