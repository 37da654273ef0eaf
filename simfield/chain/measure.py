"""The story of the chain: ideal image points through air, lens and film onto the comparator, with marks beside them.

    ideal -> curvature -> refraction -> lens (distortion, tilt, interior) -> film (polynomials, field) -> comparator

What does not change from trial to trial is computed once (`prepare`). The scenario's own effects take part where they
belong: deformations of the film act on the marks, too, everything else only on the points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from simfield.block import Floats, Indices
from simfield.chain.air import Air, through_air
from simfield.chain.film import FieldAt, RandomField, field_at
from simfield.chain.lens import Lens
from simfield.chain.machine import Comparator, Errors, Marks
from simfield.chain.raw import Raw
from simfield.counter_normals import normal_pairs
from simfield.distortion import measured_from_ideal, systematic
from simfield.effects import FilmAffine, FilmPolynomial, UnflatFilm
from simfield.simulate import World
from simfield.streams import counter_key, stream

FILM = (FilmAffine, FilmPolynomial, UnflatFilm)
REACH_MM = 125.0


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
class Prepared:
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
        exposed = self.exposed if self.field is None else self.exposed + self.field.draw(self.world.seed, trial)

        def displacement(xy: Floats) -> Floats:
            d = self.constant_film(xy)
            return d if film is None else d + film.displacement(xy, self.image)

        return measured_from_ideal(exposed, displacement)

    def measure(self, trial: int = 0) -> Raw:
        """What the comparator writes down in a trial."""
        world, chain, k = self.world, self.chain, self.count
        xy = self.on_film(trial)
        xy[:k] += world.image_noise.of(trial)
        xy[k:] += _pairs(world.seed, "mark pointing", len(xy) - k, trial) * chain.errors.pointing_um / 1000.0
        _gross(xy[:k], chain.errors, world, trial)
        settings = self._on_machine(xy, trial)
        kept = stream(world.seed, "missed", trial).random(k) >= chain.errors.missed_rate
        points = _confused(world, chain.errors, trial)
        return Raw.of(self, settings, kept, points, trial)

    def _on_machine(self, xy: Floats, trial: int) -> Floats:
        """(n, s, 2) mm: machine coordinates of every setting."""
        machine = self.chain.comparator
        m = len(self.world.plan)
        random = stream(self.world.seed, "placement", trial)
        turn = np.deg2rad(machine.placement_sigma_deg) * random.standard_normal(m)
        shift = machine.placement_sigma_mm * random.standard_normal((m, 2))
        cosine, sine = np.cos(turn)[self.image], np.sin(turn)[self.image]
        placed = np.column_stack([cosine * xy[:, 0] - sine * xy[:, 1], sine * xy[:, 0] + cosine * xy[:, 1]])
        placed = (placed + shift[self.image]) @ machine.matrix().T
        placed += self.time[:, None] * (np.array(machine.drift_um) / 1000.0)
        settings = np.repeat(placed[:, None, :], machine.settings, axis=1)
        if machine.setting_um:
            errors = _pairs(self.world.seed, "setting", len(xy) * machine.settings, trial)
            settings += machine.setting_um / 1000.0 * errors.reshape(settings.shape)
        return settings


def prepare(world: World, chain: Chain) -> Prepared:
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
        field = field_at(chain.film_field, exposed, tuple(names[i] for i in image.tolist()), REACH_MM)
    return Prepared(
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


def _pairs(seed: int, name: str, count: int, trial: int) -> Floats:
    """(count, 2) standard normal numbers of a trial."""
    return normal_pairs(counter_key(seed, name), np.arange(count, dtype=np.uint64), 0, trial)


def _gross(xy: Floats, errors: Errors, world: World, trial: int) -> None:
    """Add gross errors to points xy (k, 2) in place."""
    if errors.gross_rate:
        random = stream(world.seed, "gross", trial)
        hit = random.random(len(xy)) < errors.gross_rate
        xy[hit] += errors.gross_um / 1000.0 * random.standard_normal((int(hit.sum()), 2))


def _confused(world: World, errors: Errors, trial: int) -> Indices:
    """(k): the point that the operator took each image point for; pairs of an image are exchanged."""
    point = np.array(world.point)
    if errors.confused_rate:
        random = stream(world.seed, "confused", trial)
        for i in range(len(world.plan)):
            own = np.flatnonzero(world.image == i)
            pairs = int(random.binomial(len(own) // 2, errors.confused_rate))
            picked = random.permutation(own)[: 2 * pairs].reshape(2, -1)
            point[picked[0]], point[picked[1]] = world.point[picked[1]], world.point[picked[0]]
    return point
