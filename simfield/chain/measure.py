"""The story of the chain: ideal image points through air, lens and film onto the comparator, with marks beside them.

    ideal -> curvature -> refraction -> lens (distortion, tilt, interior) -> film (polynomials, field) -> comparator

What does not change from trial to trial is computed once (`prepare`). The scenario's own effects take part where they
belong: deformations of the film act on the marks, too, everything else only on the points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from simfield.block import Block, Floats, ImageObservations, Indices, Raw
from simfield.chain.air import Air, through_air
from simfield.chain.comparator import Comparator, Errors, Marks
from simfield.chain.lens import Lens
from simfield.chain.random_field import FieldAt, RandomField, field_at
from simfield.disturbances import FilmAffine, FilmPolynomial, UnflatFilm, measured_from_ideal, systematic
from simfield.random import Words, counter_key, name_words, normal_pairs, stream, words
from simfield.simulate import World

FILM = (FilmAffine, FilmPolynomial, UnflatFilm)
REACH_MM = 125.0
KINDS = ("point", "mark")


@dataclass(frozen=True)
class Chain:
    """All stages beyond the scenario's own effects; the default adds nothing."""

    name: str = "undisturbed"
    air: Air = field(default_factory=Air)
    lenses: tuple[Lens, ...] = ()
    film_field: RandomField | None = None
    marks: Marks = field(default_factory=Marks)
    comparator: Comparator = field(default_factory=Comparator)
    errors: Errors = field(default_factory=Errors)


@dataclass(frozen=True, eq=False)
class PreparedChain:
    """A chain over a world: places of all settings on the exposed film, first the k points, then the marks.

    exposed (n, 2) mm before the film deforms; image (n); owner of the film by name; time (n) from 0 to 1 in the
    session of each image.
    """

    world: World
    chain: Chain
    exposed: Floats
    image: Indices
    mark: Indices
    time: Floats
    constant_film: Callable[[Floats], Floats]
    field: FieldAt | None

    @property
    def count(self) -> int:
        """The number of image points."""
        return len(self.world.image)

    def on_film(self, trial: int) -> Floats:
        """(n, 2) mm: where everything lies on the deformed film of a trial."""
        film = self.world.film(trial) if self.world.scenario.film else None
        exposed = self.exposed if self.field is None else self.exposed + self.field.draw(trial)

        def displacement(xy: Floats) -> Floats:
            d = self.constant_film(xy)
            return d if film is None else d + film.displacement(xy, self.image)

        return measured_from_ideal(exposed, displacement)

    def measure(self, trial: int = 0) -> Raw:
        """What the comparator writes down in a trial."""
        world, chain, k = self.world, self.chain, self.count
        xy = self.on_film(trial)
        xy[:k] += replace(world.image_noise, sigma=self.noise_sigma[:k]).of(trial)
        xy[k:] += self.noise_sigma[k:, None] * self._pairs("mark pointing", trial)[k:]
        xy[:k] += self._gross(trial)
        settings = self._on_machine(xy, trial)
        kept = stream(world.seed, "missed", trial).random(k) >= chain.errors.missed_rate
        return _written_down(self, settings, kept, self._named(trial), trial)

    def _on_machine(self, xy: Floats, trial: int) -> Floats:
        """(n, s, 2) mm: machine coordinates of every setting."""
        machine, key = self.chain.comparator, counter_key(self.world.seed, "placement")
        turned, shifted = (normal_pairs(key, i, self.image_words, trial) for i in (0, 1))
        turn = np.deg2rad(machine.placement_sigma_deg) * turned[:, 0]
        shift = machine.placement_sigma_mm * shifted
        cosine, sine = np.cos(turn)[self.image], np.sin(turn)[self.image]
        placed = np.column_stack([cosine * xy[:, 0] - sine * xy[:, 1], sine * xy[:, 0] + cosine * xy[:, 1]])
        placed = (placed + shift[self.image]) @ machine.matrix().T
        placed += self.time[:, None] * (np.array(machine.drift_um) / 1000.0)
        if machine.settings == 1:
            return placed[:, None, :]
        # half the difference of two settings is independent of their mean, as the settings are
        half = self._setting_sigma * self._pairs("setting difference", trial)
        return np.stack([placed - half, placed + half], axis=1)

    @property
    def _setting_sigma(self) -> float:
        """mm, of the mean of the settings of a point."""
        machine = self.chain.comparator
        return float(machine.setting_um / 1000.0 / np.sqrt(machine.settings))

    @cached_property
    def noise_sigma(self) -> Floats:
        """(n) mm: of pointing and setting in the mean of a place's settings.

        Both are normal and only their sum is seen, so one number stands for both.
        """
        marks = np.full(len(self.image) - self.count, self.chain.errors.pointing_um / 1000.0)
        return np.asarray(np.hypot(np.concatenate([self.world.image_noise.sigma, marks]), self._setting_sigma))

    @property
    def image_words(self) -> Words:
        """(m) what the numbers of an image hang on."""
        return name_words(self.world.plan.image_ids)

    @property
    def place_words(self) -> Words:
        """(n) what the numbers of a point (its place in the field) or a setting of a mark (its order) hang on."""
        points = self.world.place[self.world.point]
        marks = (len(self.image) - self.count) // len(self.world.plan)
        return np.concatenate([points, np.tile(np.arange(marks), len(self.world.plan))]).astype(np.uint64)

    def _pairs(self, name: str, trial: int) -> Floats:
        """(n, 2) standard normal numbers of a trial; those of marks are not those of points."""
        k, image = self.count, self.image_words[self.image]
        places, keys = self.place_words, (counter_key(self.world.seed, name, kind) for kind in KINDS)
        parts = (slice(0, k), slice(k, None))
        return np.concatenate(
            [normal_pairs(key, places[p], image[p], trial) for key, p in zip(keys, parts, strict=True)]
        )

    def _gross(self, trial: int) -> Floats:
        """(k, 2) mm: gross errors of the points."""
        errors, k = self.chain.errors, self.count
        key, place, image = (
            counter_key(self.world.seed, "gross"),
            self.place_words[:k],
            self.image_words[self.image[:k]],
        )
        hit = words(key, place, image, trial) < share_of_words(errors.gross_rate)
        size = normal_pairs(counter_key(self.world.seed, "gross size"), place, image, trial)
        return np.asarray(np.where(hit[:, None], errors.gross_um / 1000.0 * size, 0.0))

    def _named(self, trial: int) -> Indices:
        """(k): the point that the operator took each image point for; points set one after the other are exchanged."""
        point, first = np.array(self.world.point), self.first_of_pairs
        image = self.image[first]
        key, place = counter_key(self.world.seed, "confused"), self.place_words[first]
        hit = words(key, place, self.image_words[image], trial) < share_of_words(self.chain.errors.confused_rate)
        second = self.second_of_pairs[hit]
        point[first[hit]], point[second] = self.world.point[second], self.world.point[first[hit]]
        return point

    @property
    def first_of_pairs(self) -> Indices:
        """(p) the points 0, 2, 4 ... in the session of each image that have a successor there."""
        return self._session_pairs[0]

    @property
    def second_of_pairs(self) -> Indices:
        """(p) their successors."""
        return self._session_pairs[1]

    @cached_property
    def _session_pairs(self) -> tuple[Indices, Indices]:
        pairs = [
            own[: len(own) // 2 * 2].reshape(-1, 2)
            for own in (np.flatnonzero(self.world.image == i) for i in range(len(self.world.plan)))
        ]
        first, second = np.concatenate(pairs).T
        return first, second


def _written_down(
    prepared: PreparedChain, settings: Floats, kept: npt.NDArray[np.bool_], point: Indices, trial: int
) -> Raw:
    """The measured file of a trial: kept (k) what was measured, point (k) under which name."""
    world, chain, k = prepared.world, prepared.chain, prepared.count
    block = world.block(world.distorted, trial)
    o = block.observations
    means = settings.mean(axis=1)
    observations = ImageObservations(o.image[kept], point[kept], means[:k][kept], o.sigma[kept])
    fiducials, crosses = len(chain.marks.fiducial_positions()), len(chain.marks.reseau_positions())
    air, machine = chain.air, chain.comparator
    height = world.exterior[:, 2] + air.altimeter_sigma_m * stream(world.seed, "altimeter").standard_normal(
        len(world.plan)
    )
    ground = np.full(len(height), float(np.mean(world.field.coordinates[:, 2])))
    return Raw(
        block=Block(block.cameras, block.images, block.points, observations),
        settings=settings[:k][kept],
        time=prepared.time[:k][kept],
        mark_image=prepared.image[k:],
        mark=prepared.mark[k:],
        mark_time=prepared.time[k:],
        mark_settings=settings[k:],
        mark_ids=(*(f"f{i + 1}" for i in range(fiducials)), *(f"r{i + 1}" for i in range(crosses))),
        mark_kinds=("fiducial",) * fiducials + ("reseau",) * crosses,
        calibrated={c.camera_id: calibrated_marks(world, prepared, c.camera_id) for c in block.cameras},
        heights=np.column_stack([height, ground]),
        machine=(*machine.scale_ppm, machine.non_orthogonality_ppm),
        certificates={
            lens.camera: (np.array(lens.radial.radius_mm), np.atleast_2d(lens.radial.distortion_um))
            for lens in chain.lenses
            if lens.radial is not None and lens.camera in block.camera_ids
        },
    )


def calibrated_marks(world: World, prepared: PreparedChain, camera_id: str) -> Floats:
    """(M, 2) mm: the positions of a camera's marks as its certificate gives them."""
    marks = prepared.chain.marks
    true = np.concatenate([marks.fiducial_positions(), marks.reseau_positions()])
    error = stream(world.seed, "mark calibration", camera_id).standard_normal(true.shape)
    return np.asarray(true + marks.calibration_um / 1000.0 * error)


def share_of_words(rate: float) -> int:
    """How many of the 2^32 words lie below the one that cuts off this share."""
    return round(rate * 2.0**32)


def prepare(world: World, chain: Chain) -> PreparedChain:
    """Everything about a chain over a world that all trials share."""
    marks = np.concatenate([chain.marks.fiducial_positions(), chain.marks.reseau_positions()])
    fiducials, m = len(chain.marks.fiducial_positions()), len(world.plan)
    # fiducials are set at the start and again at the end of the session, the reseau in between
    order = np.concatenate(
        [
            np.arange(fiducials),
            np.arange(len(marks)),
        ]
    )
    at = np.concatenate([np.zeros(fiducials), np.ones(fiducials), np.full(len(marks) - fiducials, 0.5)])
    image = np.concatenate([world.image, np.repeat(np.arange(m), len(order))])
    exposed = np.concatenate([_exposed(world, chain), np.tile(marks[order], (m, 1))])
    film = tuple(on for on in world.scenario.effects if isinstance(on.effect, FILM))
    field = None
    if chain.film_field is not None:
        plan = world.plan
        owners = {"image": plan.image_ids, "flight": plan.flight_ids, "camera": plan.camera_ids}
        names = owners[chain.film_field.per]
        field = field_at(chain.film_field, exposed, tuple(names[i] for i in image.tolist()), REACH_MM, world.seed)
    return PreparedChain(
        world,
        chain,
        exposed,
        image,
        np.concatenate([np.full(len(world.image), -1), np.tile(order, m)]),
        np.concatenate([_times(world), np.tile(at, m)]),
        systematic(film, world.plan, image),
        field,
    )


def _exposed(world: World, chain: Chain) -> Floats:
    """(k, 2) mm: the image points after air and lens."""
    plan, image = world.plan, world.image
    c = np.array([world.scenario.camera(camera).c_mm for camera in plan.camera_ids])
    ground = float(np.mean(world.field.coordinates[:, 2]))
    xy = through_air(chain.air, world.ideal, image, world.exterior[:, 2], ground, c)
    lens = tuple(on for on in world.scenario.effects if not isinstance(on.effect, FILM))
    xy = measured_from_ideal(xy, systematic(lens, plan, image))
    for one in chain.lenses:
        own = np.array([camera == one.camera for camera in plan.camera_ids])[image]
        if own.any():
            xy[own] = one.distort(xy[own], world.scenario.camera(one.camera).c_mm)
    return xy


def _times(world: World) -> Floats:
    """(k): when each point is set in the session of its image, evenly between start and end."""
    time = np.empty(len(world.image))
    for i in range(len(world.plan)):
        own = np.flatnonzero(world.image == i)
        time[own] = (1.0 + np.arange(len(own))) / (1.0 + len(own))
    return time
