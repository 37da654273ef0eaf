"""Deformation of the film: shared by all trials of a flight, or drawn anew for every image or flight of a trial."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from simfield.block import Floats, Indices
from simfield.disturbances.effects import EffectOn, FilmAffine, FilmPolynomial
from simfield.random import Words, counter_key, name_words, normal_pairs
from simfield.world import FlightPlan

REFERENCE_MM = 100.0


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
    the column, owner (e) and the number of the trial (simfield.random.counter_normals). Sorted by image.
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
                    word = int(name_words([owner])[0])
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
