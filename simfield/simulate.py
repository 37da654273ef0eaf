"""The story: field, flights, ideal images, distortion, visibility, omission, noise, block.

The geometry (heights, deviations of the flights, omitted points, start values) belongs to (scenario, seed); the errors
(image noise, the film of single images, geodetic errors) belong to (seed, trial). Many trials share one World.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from operator import index

import numpy as np
import numpy.typing as npt

from simfield.block import Block, Floats, ImageObservations, Images, Indices, Points
from simfield.disturbances import (
    DrawnFilm,
    FilmTable,
    ImageNoise,
    ImagePointDraws,
    MovingFilm,
    draw_film,
    geodetic_noise,
    image_noise,
    measured_from_ideal,
    shown,
    systematic,
)
from simfield.random import stream
from simfield.scenario import Scenario
from simfield.truth import Truth
from simfield.world import (
    CountError,
    FieldPoints,
    FlightPlan,
    Rays,
    deviation,
    fly,
    half_format,
    ideal_image,
    measured_rays,
    plan_flights,
)

MOST_FLIGHTS = 20
"""A flight that cannot have given the published counts was not the flight: it is drawn anew, this often."""

FEWEST_RAYS = 2
"""A point that is no control needs two rays to have coordinates."""


@dataclass(frozen=True, eq=False)
class World:
    """The geometry that all trials share.

    exterior (m, 6) is true, start (m, 6) approximate, metres and radians. place (n) are the measured points as
    numbers in the field; image (k) and point (k) index the images and these points; ideal (k, 2) and distorted (k, 2)
    are in mm, the latter with the effects but without the film that changes from trial to trial.
    """

    scenario: Scenario
    seed: int
    field: FieldPoints
    plan: FlightPlan
    exterior: Floats
    start: Floats
    place: Indices
    image: Indices
    point: Indices
    ideal: Floats
    distorted: Floats

    def film(self, trial: int) -> DrawnFilm:
        """The film deformation of every image in a trial."""
        return draw_film(self.scenario.film, self.plan, self.seed, trial)

    def undisturbed_image_points(self, trial: int = 0) -> Floats:
        """(k, 2) image coordinates of a trial without noise, mm."""
        if not self.scenario.film:
            return self.distorted
        constant, film = systematic(self.scenario.effects, self.plan, self.image), self.film(trial)
        return measured_from_ideal(
            self.ideal, lambda xy: constant(xy) + film.displacement(xy, self.image), start=self.distorted
        )

    def image_points(self, trial: int = 0) -> Floats:
        """(k, 2) measured image coordinates of a trial, mm: what `observe` puts into the block, without the block.

        Raises ValueError for a trial that is not a number from 0 to 2^32 - 1.
        """
        if not 0 <= index(trial) < 2**32:
            raise ValueError(f"trial {trial} is not allowed, trials are numbered from 0 to 2^32 - 1")
        return self.undisturbed_image_points(trial) + self.image_noise.of(trial)

    def draws(self, start: int, stop: int) -> ImagePointDraws:
        """The image coordinates of the trials start .. stop - 1, drawn when they are asked for."""
        return ImagePointDraws(self.distorted, self.image_noise, start, stop, self.moving_film)

    @cached_property
    def moving_film(self) -> MovingFilm | None:
        """The image points on film that changes from trial to trial; None where it does not."""
        if not self.scenario.film:
            return None
        shared = systematic(self.scenario.effects, self.plan, self.image)
        table = FilmTable.of(self.scenario.film, self.plan, self.seed)
        return MovingFilm.of(self.distorted, shared, self.image, table, len(self.plan))

    @cached_property
    def image_noise(self) -> ImageNoise:
        """The random errors of all image coordinates."""
        sigma = self.scenario.noise.image_sigma_mm(self.plan.camera_ids)
        return image_noise(sigma, self.plan.image_ids, self.image, self.place[self.point], self.seed)

    def given_coordinates(self, trial: int = 0) -> Floats:
        """(n, 3) coordinates of the measured points as the geodetic survey of a trial gives them, metres."""
        errors = geodetic_noise(self.scenario.noise, len(self.field), self.seed, trial)
        return np.asarray((self.field.coordinates + errors)[self.place])

    def observe(self, trial: int = 0) -> tuple[Block, Truth]:
        """Measure once: the block of a trial, and the truth behind it."""
        return self.block(self.image_points(index(trial)), index(trial)), _truth(self, index(trial))

    def block(self, image_points: Floats, trial: int = 0) -> Block:
        """The block of a trial with these measured image coordinates (k, 2), mm."""
        scenario, plan = self.scenario, self.plan
        camera_ids = [c.camera_id for c in scenario.cameras]
        assumed = scenario.noise.assumed_sigma_mm(plan.camera_ids)[self.image]
        return Block(
            tuple(c.as_block_camera() for c in scenario.cameras),
            Images(plan.image_ids, np.array([camera_ids.index(c) for c in plan.camera_ids]), self.start),
            _points(self, trial),
            ImageObservations(self.image, self.point, image_points, np.column_stack([assumed, assumed])),
        )


def simulate(scenario: Scenario, seed: int, trial: int = 0) -> tuple[Block, Truth]:
    """Fly a scenario and measure its images: the block that a surveyor would hand over, and the truth behind it.

    The geometry hangs on the scenario and the seed, the errors on the seed and the trial (0 to 2^32 - 1). Frames, signs
    and units are those of docs/conventions.md. Raises CountError where the published counts of the scenario cannot be
    reached, DistortionError where an effect cannot be solved, and ValueError for an impossible trial.
    """
    return build_world(scenario, seed).observe(trial)


def build_world(scenario: Scenario, seed: int) -> World:
    """Build the geometry of a scenario.

    Raises CountError where the published counts cannot be reached and DistortionError where an effect cannot be solved.
    """
    seed = index(seed)
    field = scenario.field.build(seed)
    plan = plan_flights(scenario.flights, scenario.cameras)
    for attempt in range(MOST_FLIGHTS):
        exterior = fly(plan, scenario.flights, seed, attempt)
        image, place, ideal, distorted = _seen(scenario, field, plan, exterior)
        try:
            kept = _measured(scenario, field, plan, seed, image, place, distorted)
        except CountError as error:
            reason = error
            continue
        points, point = np.unique(place[kept], return_inverse=True)
        start = _start_values(scenario, plan, exterior, seed)
        return World(
            scenario, seed, field, plan, exterior, start, points, image[kept], point, ideal[kept], distorted[kept]
        )
    raise CountError(f"{scenario.name}, seed {seed}: {MOST_FLIGHTS} flights and none with the counts: {reason}")


def _seen(
    scenario: Scenario, field: FieldPoints, plan: FlightPlan, exterior: Floats
) -> tuple[Indices, Indices, Floats, Floats]:
    """Image (k), place in the field (k), ideal and distorted coordinates (k, 2) of all points that the images show."""
    cameras = [scenario.camera(c) for c in plan.camera_ids]
    ideal = ideal_image(exterior, cameras, field.coordinates)
    half = half_format(cameras, scenario.measurement.margin_mm)
    image, place, distorted = shown(ideal, scenario.effects, plan, half)
    return image, place, ideal[image, place], distorted


def _measured(
    scenario: Scenario,
    field: FieldPoints,
    plan: FlightPlan,
    seed: int,
    image: Indices,
    place: Indices,
    distorted: Floats,
) -> npt.NDArray[np.bool_]:
    """(k): what is measured of what is seen, without the points that too few images show."""
    rays = Rays(image, place, np.hypot(distorted[:, 0], distorted[:, 1]))
    kept = measured_rays(
        scenario.measurement, rays, plan.camera_ids, plan.image_ids, main_points(scenario, field), seed
    )
    enough = np.bincount(place[kept], minlength=len(field)) >= FEWEST_RAYS
    return np.asarray(kept & (enough | scenario.control.of(field))[place])


def main_points(scenario: Scenario, field: FieldPoints) -> npt.NDArray[np.bool_]:
    """(n): the points of the field that are used without auxiliary points."""
    unused = np.isin(field.group_ids, scenario.measurement.unused_groups)
    return field.of_groups(~unused)


def _start_values(scenario: Scenario, plan: FlightPlan, exterior: Floats, seed: int) -> Floats:
    start = scenario.start
    if start.come_from == "flight-plan":
        return plan.exterior
    moved = [
        deviation(stream(seed, "start", i), start.position_sigma_m, start.attitude_sigma_deg) for i in plan.image_ids
    ]
    return np.asarray(exterior + np.array(moved))


def _points(world: World, trial: int) -> Points:
    control, noise = world.scenario.control, world.scenario.noise
    is_control = control.of(world.field)[world.place]
    coordinates = world.given_coordinates(trial)
    sigma = np.full_like(coordinates, noise.geodetic_mm / 1000.0)
    sigma[is_control] = np.array([control.sigma_xy_mm, control.sigma_xy_mm, control.sigma_z_mm]) / 1000.0
    if control.rest == "tie":
        coordinates[~is_control] = sigma[~is_control] = np.nan
    return Points(
        tuple(world.field.ids[i] for i in world.place),
        np.where(is_control, "control", control.rest),
        coordinates,
        sigma,
    )


def _truth(world: World, trial: int) -> Truth:
    scenario, plan, field = world.scenario, world.plan, world.field
    main = main_points(scenario, field)
    return Truth(
        scenario=scenario.name,
        seed=world.seed,
        trial=trial,
        image_ids=plan.image_ids,
        flight_ids=plan.flight_ids,
        strip_ids=plan.strip_ids,
        camera_ids=plan.camera_ids,
        exterior=world.exterior,
        point_ids=tuple(field.ids[i] for i in world.place),
        group=tuple(field.group_ids[field.group[i]] for i in world.place),
        central=field.central[world.place],
        coordinates=field.coordinates[world.place],
        main_points=tuple(field.ids[i] for i in world.place if main[i]),
        image=world.image,
        point=world.point,
        ideal=world.ideal,
        undisturbed=world.undisturbed_image_points(trial),
        noise_sigma=scenario.noise.image_sigma_mm(plan.camera_ids)[world.image],
        effects=scenario.effects + world.film(trial).effects(plan),
    )
