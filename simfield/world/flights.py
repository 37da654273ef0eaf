"""Flights: from scale, overlap and headings to images, and from the plan to what was flown.

A heading is an azimuth in gon, clockwise from north (+Y). The image x axis is the direction of flight, so that kappa
= 100 gon - heading. Every flight is centred on the field. Names are readable: image 2 of the strip heading 100 gon of
the flight "sww-after" is "sww-after-h100-2"; where a heading has parallel strips, "-s1", "-s2" follow the heading.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from simfield.block import Floats
from simfield.random import stream
from simfield.world.cameras import CameraModel


@dataclass(frozen=True)
class Flight:
    """One flight with one camera and one film cassette.

    scale is the image scale number, overlaps are shares of the format, strips the number of parallel strips of every
    heading (flown to and fro if alternate). Images look straight down or, convergent, at the field's centre. Position
    and attitude deviate from the plan by normal random amounts.
    """

    flight_id: str
    camera_id: str
    scale: float
    headings_gon: tuple[float, ...] = (0.0,)
    strips: int = 1
    alternate: bool = True
    images_per_strip: int = 3
    forward_overlap: float = 0.6
    sidelap: float = 0.3
    ground_height_m: float = 50.0
    look: Literal["down", "centre"] = "down"
    position_sigma_m: float = 25.0
    attitude_sigma_deg: float = 1.0

    def __post_init__(self) -> None:
        place = f"flight {self.flight_id!r}"
        if not self.flight_id or self.flight_id != self.flight_id.strip():
            raise ValueError(f"flight_id {self.flight_id!r} is not an id (a text without blanks at its ends)")
        if self.scale <= 0.0:
            raise ValueError(f"{place}: scale {self.scale:g} is not allowed, it is the scale number, > 0")
        if not self.headings_gon or min(self.strips, self.images_per_strip) < 1:
            raise ValueError(f"{place} needs a heading, a strip and an image")
        if not (0.0 <= self.forward_overlap < 1.0 and 0.0 <= self.sidelap < 1.0):
            raise ValueError(f"{place}: overlaps are shares of the format, from 0 to below 1 (0.6 for 60 %)")
        if min(self.position_sigma_m, self.attitude_sigma_deg) < 0.0:
            raise ValueError(f"{place}: position_sigma_m and attitude_sigma_deg must be >= 0")

    def strip_headings(self) -> Iterator[tuple[str, float, float]]:
        """(strip id, heading in gon, offset to the left of the first heading in strips) of every strip."""
        for heading in self.headings_gon:
            for strip in range(self.strips):
                flown = (heading + (200.0 if self.alternate and strip % 2 else 0.0)) % 400.0
                name = f"{self.flight_id}-h{flown:g}" + (f"-s{strip + 1}" if self.strips > 1 else "")
                to_left = strip - (self.strips - 1) / 2.0
                yield name, flown, to_left * (1.0 if flown == heading % 400.0 else -1.0)


@dataclass(frozen=True, eq=False)
class FlightPlan:
    """The planned images: ids, flight, strip and camera of each (m), nominal exterior (m, 6) in metres and radians."""

    image_ids: tuple[str, ...]
    flight_ids: tuple[str, ...]
    strip_ids: tuple[str, ...]
    camera_ids: tuple[str, ...]
    exterior: Floats

    def __len__(self) -> int:
        return len(self.image_ids)


def plan_flights(flights: Sequence[Flight], cameras: Sequence[CameraModel]) -> FlightPlan:
    """Lay out every flight over the origin. Raises KeyError for a camera that is not among the cameras."""
    by_id = {c.camera_id: c for c in cameras}
    images, flown_by, strips, used, exterior = [], [], [], [], []
    for flight in flights:
        camera = by_id[flight.camera_id]
        base_m = flight.scale * camera.width_mm * (1.0 - flight.forward_overlap) / 1000.0
        strip_distance_m = flight.scale * camera.height_mm * (1.0 - flight.sidelap) / 1000.0
        height_m = flight.ground_height_m + flight.scale * camera.c_mm / 1000.0
        for strip_id, heading_gon, to_left in flight.strip_headings():
            azimuth = heading_gon * np.pi / 200.0
            ahead = np.array([np.sin(azimuth), np.cos(azimuth)])
            left = np.array([-np.cos(azimuth), np.sin(azimuth)])
            for number in range(flight.images_per_strip):
                along_m = base_m * (number - (flight.images_per_strip - 1) / 2.0)
                centre = np.array([0.0, 0.0, flight.ground_height_m])
                down = np.array([0.0, 0.0, -1.0])
                place = np.array([*(along_m * ahead + to_left * strip_distance_m * left), height_m])
                attitude = looking(down if flight.look == "down" else centre - place, ahead)
                images.append(f"{strip_id}-{number + 1}")
                flown_by.append(flight.flight_id)
                strips.append(strip_id)
                used.append(flight.camera_id)
                exterior.append([*place, *attitude])
    return FlightPlan(tuple(images), tuple(flown_by), tuple(strips), tuple(used), np.array(exterior).reshape(-1, 6))


def looking(view: Floats, ahead: Floats) -> tuple[float, float, float]:
    """omega, phi, kappa in radians of a camera that looks along view (3), its image x axis as near to ahead (2) as
    can be.
    """
    z = -view / np.linalg.norm(view)
    x = np.array([*ahead, 0.0]) - z * (z[:2] @ ahead)
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    # The columns of R = R1(omega) R2(phi) R3(kappa) are x, y, z; its first row and last column give the angles.
    return float(np.arctan2(-z[1], z[2])), float(np.arcsin(z[0])), float(np.arctan2(-y[0], x[0]))


def fly(plan: FlightPlan, flights: Sequence[Flight], seed: int, attempt: int = 0) -> Floats:
    """(m, 6) the exterior orientation that was flown: the plan and the seeded deviations of every image."""
    by_id = {f.flight_id: f for f in flights}
    exterior = plan.exterior.copy()
    for row, (image_id, flight_id) in enumerate(zip(plan.image_ids, plan.flight_ids, strict=True)):
        flight = by_id[flight_id]
        exterior[row] += deviation(
            stream(seed, "deviations", image_id, attempt), flight.position_sigma_m, flight.attitude_sigma_deg
        )
    return exterior


def deviation(random: np.random.Generator, position_sigma_m: float, attitude_sigma_deg: float) -> Floats:
    """(6) normal deviations of an exterior orientation, metres and radians."""
    sigma = np.repeat([position_sigma_m, np.deg2rad(attitude_sigma_deg)], 3)
    return np.asarray(sigma * random.standard_normal(6))
