"""A scenario: everything that has to be said about a simulated experiment, apart from its seed."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field as dataclass_field
from typing import Annotated, Literal

from simfield.disturbances import EffectOn, FilmVariation, Noise, OneOf
from simfield.world import FIELDS, CameraModel, Control, Field, Flight, Measurement, plan_flights


class ScenarioError(ValueError):
    """A scenario that contradicts itself or a scenario file that cannot be read; one line for each fault."""


@dataclass(frozen=True)
class StartValues:
    """The approximate orientations in the block: the truth disturbed by normal amounts, or the flight plan as it is."""

    come_from: Literal["truth", "flight-plan"] = "truth"
    position_sigma_m: float = 10.0
    attitude_sigma_deg: float = 1.0

    def __post_init__(self) -> None:
        if min(self.position_sigma_m, self.attitude_sigma_deg) < 0.0:
            raise ValueError("position_sigma_m and attitude_sigma_deg of the start values must be >= 0")


@dataclass(frozen=True)
class Scenario:
    """A field with control, flown by cameras, with the systematic effects and random errors of its images.

    effects are the same in every trial, film is new in every image and trial. Raises ScenarioError where a name is
    used that the scenario does not have.
    """

    name: str
    field: Annotated[Field, OneOf(*FIELDS)]
    cameras: tuple[CameraModel, ...]
    flights: tuple[Flight, ...]
    control: Control = dataclass_field(default_factory=Control)
    effects: tuple[EffectOn, ...] = ()
    film: tuple[FilmVariation, ...] = ()
    noise: Noise = dataclass_field(default_factory=Noise)
    measurement: Measurement = dataclass_field(default_factory=Measurement)
    start: StartValues = dataclass_field(default_factory=StartValues)

    def __post_init__(self) -> None:
        camera_ids = [c.camera_id for c in self.cameras]
        flight_ids = [f.flight_id for f in self.flights]
        _refuse_twice(camera_ids, "camera")
        _refuse_twice(flight_ids, "flight")
        for number, flight in enumerate(self.flights):
            _refuse_unknown(flight.camera_id, camera_ids, f"flights[{number}].camera_id", "camera")
        image_ids = plan_flights(self.flights, self.cameras).image_ids
        _refuse_twice(image_ids, "image")
        for number, on in enumerate(self.effects):
            _refuse_unknown(on.camera, camera_ids, f"effects[{number}].camera", "camera")
            _refuse_unknown(on.flight, flight_ids, f"effects[{number}].flight", "flight")
            _refuse_unknown(on.image, image_ids, f"effects[{number}].image", "image")
        for number, variation in enumerate(self.film):
            _refuse_unknown(variation.camera, camera_ids, f"film[{number}].camera", "camera")
        for camera_id in self.measurement.counts:
            _refuse_unknown(camera_id, camera_ids, "measurement.counts", "camera")
        if self.measurement.unused_groups:
            group_ids = self.field.build(seed=0).group_ids
            for group_id in self.measurement.unused_groups:
                _refuse_unknown(group_id, group_ids, "measurement.unused_groups", "group")
        for name, values in (("image_um", self.noise.image_um), ("assumed_um", self.noise.assumed_um)):
            if isinstance(values, Mapping) and set(values) != set(camera_ids):
                raise ScenarioError(
                    f"noise.{name} names the cameras {sorted(values)}, the scenario has {sorted(camera_ids)}"
                )

    def camera(self, camera_id: str) -> CameraModel:
        """The camera of that id. Raises KeyError if there is none."""
        return {c.camera_id: c for c in self.cameras}[camera_id]


def _refuse_twice(ids: Collection[str], kind: str) -> None:
    if not ids:
        raise ScenarioError(f"a scenario needs at least one {kind}")
    twice = sorted({i for i in ids if list(ids).count(i) > 1})
    if twice:
        raise ScenarioError(f"{kind} {twice[0]!r} is named twice")


def _refuse_unknown(name: str | None, known: Collection[str], place: str, kind: str) -> None:
    if name is not None and name not in known:
        raise ScenarioError(f"{place}: no {kind} named {name!r}, the scenario has {', '.join(known)}")
