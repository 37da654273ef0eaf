"""From effects to measured coordinates: what acts on which image point, and the solution of measured = ideal +
d(measured).
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from simfield.block import Floats, Indices
from simfield.counter_normals import Words, normal_pairs
from simfield.effects import Effect, EffectOn, FilmAffine, FilmPolynomial
from simfield.flights import FlightPlan
from simfield.streams import counter_key

SETTLED = 4.0 * float(np.finfo(np.float64).eps)
"""A step of so small a share of the largest coordinate is rounding, not distortion: 1e-13 mm on a 23 cm film."""

MOST_STEPS = 200
"""Enough for a distortion whose gradient is 0.85; film and lens of an aerial camera need five steps."""

REFERENCE_MM = 100.0


class DistortionError(ArithmeticError):
    """measured = ideal + d(measured) could not be solved."""


TERMS = {"affinity": (1,), "affine": (0, 1), "bilinear": (3,), "quadratic": (2, 3, 4), "cubic": (5, 6, 7, 8)}
"""which of the monomials x, y, x^2, xy, y^2, x^3, x^2 y, xy^2, y^3 a film variation has; affinity has y in dy alone"""
DEGREES = (1, 1, 2, 2, 2, 3, 3, 3, 3)


@dataclass(frozen=True)
class FilmVariation:
    """Film deformation that is new in every trial: all affine, quadratic or cubic terms in x and y, the
    bilinear ones (xy), or affinity in y alone.

    One draw serves an image, a flight (its cassette) or all images of the camera. Every coefficient is normal;
    um_at_100mm is the standard deviation of one term at 100 mm.
    """

    camera: str
    terms: Literal["affinity", "affine", "bilinear", "quadratic", "cubic"]
    um_at_100mm: float
    per: Literal["image", "flight", "camera"] = "image"

    def __post_init__(self) -> None:
        if self.um_at_100mm < 0.0:
            raise ValueError("um_at_100mm of a film variation must be >= 0")


def film_monomials(xy_mm: Floats) -> Floats:
    """(k, 9) the monomials of TERMS at xy (k, 2) mm."""
    x, y = xy_mm.T
    return np.column_stack([x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y])


@dataclass(frozen=True, eq=False)
class DrawnFilm:
    """The film deformation drawn for one trial: coefficients (m, 2, 9) of the monomials of TERMS in dx and dy of each
    image.
    """

    coefficients: Floats

    def displacement(self, xy_mm: Floats, image: Indices) -> Floats:
        """(k, 2) mm at xy (k, 2) mm in the images (k)."""
        return np.asarray(np.einsum("kcj,kj->kc", self.coefficients[image], film_monomials(xy_mm)))

    def effects(self, plan: FlightPlan) -> tuple[EffectOn, ...]:
        """The same, image by image, without the images that have none."""
        found: list[EffectOn] = []
        for image_id, (dx, dy) in zip(plan.image_ids, self.coefficients.tolist(), strict=True):
            if any(dx[:2] + dy[:2]):
                found.append(EffectOn(FilmAffine(*dx[:2], *dy[:2]), image=image_id))
            if any(dx[2:] + dy[2:]):
                found.append(EffectOn(FilmPolynomial(*dx[2:], *dy[2:]), image=image_id))
        return tuple(found)


@dataclass(frozen=True, eq=False)
class FilmTable:
    """What is drawn for the film of a trial: e products of a standard deviation and a pair of normal numbers.

    image (e), column (e) of the monomials, sigma (e, 2) of the coefficients in dx and dy; a pair hangs on key (e, 2),
    the column, owner (e) and the number of the trial (simfield.counter_normals). Sorted by image.
    """

    image: Indices
    column: Indices
    sigma: Floats
    key: Words
    owner: Words

    @classmethod
    def of(cls, film: Sequence[FilmVariation], plan: FlightPlan, seed: int) -> FilmTable:
        """The table of a flight plan."""
        parts: list[tuple[int, int, float, float, tuple[int, int], int]] = []
        for variation in film:
            columns = TERMS[variation.terms]
            sigma = variation.um_at_100mm / 1000.0 / REFERENCE_MM ** DEGREES[columns[0]]
            in_x = 0.0 if variation.terms == "affinity" else sigma
            key = counter_key(seed, "film", variation.terms, variation.per)
            for image, owner in enumerate(_owners(variation, plan)):
                if plan.camera_ids[image] == variation.camera:
                    word = zlib.crc32(owner.encode())
                    parts += [(image, column, in_x, sigma, key, word) for column in columns]
        parts.sort(key=lambda part: part[0])
        return cls(
            np.array([part[0] for part in parts], dtype=np.intp),
            np.array([part[1] for part in parts], dtype=np.intp),
            np.array([part[2:4] for part in parts], dtype=float).reshape(-1, 2),
            np.array([part[4] for part in parts], dtype=np.uint64).reshape(-1, 2),
            np.array([part[5] for part in parts], dtype=np.uint64),
        )

    def coefficients(self, values: Floats, images: int) -> Floats:
        """(m, 2, 9): values (e, 2) added up in the images and monomials where they belong."""
        total = np.zeros((images, len(DEGREES), 2))
        np.add.at(total, (self.image, self.column), values)
        return total.transpose(0, 2, 1)


def draw_film(film: Sequence[FilmVariation], plan: FlightPlan, seed: int, trial: int) -> DrawnFilm:
    """The film of every image in one trial."""
    table = FilmTable.of(film, plan, seed)
    drawn = np.zeros_like(table.sigma)
    for key in np.unique(table.key, axis=0):
        own = (table.key == key).all(axis=1)
        k0, k1 = key.tolist()
        drawn[own] = normal_pairs((k0, k1), table.column[own].astype(np.uint64), table.owner[own], trial)
    return DrawnFilm(table.coefficients(table.sigma * drawn, len(plan)))


def _owners(variation: FilmVariation, plan: FlightPlan) -> tuple[str, ...]:
    """(m) whose deformation each image has: its own, its flight's or its camera's."""
    return {"image": plan.image_ids, "flight": plan.flight_ids, "camera": plan.camera_ids}[variation.per]


def systematic(effects: Sequence[EffectOn], plan: FlightPlan, image: Indices) -> Callable[[Floats], Floats]:
    """The summed displacement of image points (k, 2) that lie in the images (k)."""
    names = list(zip(plan.camera_ids, plan.flight_ids, plan.image_ids, strict=True))
    parts: list[tuple[Effect, slice | Indices]] = []
    for on in effects:
        acts = np.array([on.acts_on(*name) for name in names], dtype=bool)[image]
        if acts.any():
            parts.append((on.effect, slice(None) if acts.all() else np.flatnonzero(acts)))

    return _Sum(tuple(parts))


@dataclass(frozen=True, eq=False)
class _Sum:
    """Effects with the rows that they act on, summed; a class, so that it can travel to another process."""

    parts: tuple[tuple[Effect, slice | Indices], ...]

    def __call__(self, xy_mm: Floats) -> Floats:
        d = np.zeros_like(xy_mm)
        for effect, rows in self.parts:
            d[rows] += effect.displacement(xy_mm[rows])
        return d


def measured_from_ideal(ideal: Floats, displacement: Callable[[Floats], Floats], start: Floats | None = None) -> Floats:
    """Solve measured = ideal + d(measured) for (k, 2) mm by fixed-point iteration, down to rounding.

    start, if given, is a guess of the measured coordinates. Raises DistortionError where d is too steep to be solved.
    """
    measured = ideal if start is None else start
    for _ in range(MOST_STEPS):
        with np.errstate(over="ignore", invalid="ignore"):
            following = ideal + displacement(measured)
            step = np.abs(following - measured).max(initial=0.0)
        measured = following
        if not np.isfinite(step):
            break
        if step <= SETTLED * np.abs(measured).max(initial=0.0):
            return measured
    raise DistortionError(
        f"measured = ideal + d(measured) does not converge (last step {step:.3g} mm): the distortion is too steep"
    )
