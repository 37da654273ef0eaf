"""Film between exposure and measurement: polynomials (simfield.distortion) and a smooth random field."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from simfield.block import Floats, Indices
from simfield.streams import stream

NODES_PER_LENGTH = 2.0
"""nodes a correlation length: the field between them is short of variance by less than 0.1 %"""
JITTER = 1e-10


@dataclass(frozen=True)
class RandomField:
    """A smooth field of film deformation: sigma_um, and a correlation that falls as exp(-d^2 / 2 l^2) over l mm.

    It is drawn anew for every image, flight or camera of every trial, in x and y independently. Source: local film
    deformation of 3 to 5 um (Ahrend, Meier, as in Stark 1973, p. 9).
    """

    sigma_um: float
    length_mm: float
    per: Literal["image", "flight", "camera"] = "image"

    def __post_init__(self) -> None:
        if self.sigma_um < 0.0 or self.length_mm <= 0.0:
            raise ValueError("a random field needs sigma_um >= 0 and length_mm > 0")


@dataclass(frozen=True, eq=False)
class FieldAt:
    """A random field at fixed places: factors along x and y (k, q), so that a draw Z (q, q) gives f_x Z f_y."""

    field: RandomField
    along_x: Floats
    along_y: Floats
    owner: Indices
    owners: tuple[str, ...]

    def draw(self, seed: int, trial: int) -> Floats:
        """(k, 2) mm: the displacement in one trial."""
        q = self.along_x.shape[1]
        drawn = stream(seed, "film field", trial, self.field.per).standard_normal((len(self.owners), 2, q, q))
        d = np.empty((len(self.along_x), 2))
        for number in range(len(self.owners)):
            own = self.owner == number
            x, y = self.along_x[own], self.along_y[own]
            d[own, 0] = np.sum(x @ drawn[number, 0] * y, axis=1)
            d[own, 1] = np.sum(x @ drawn[number, 1] * y, axis=1)
        return 1e-3 * self.field.sigma_um * d


def field_at(field: RandomField, xy_mm: Floats, owner: tuple[str, ...], half_mm: float) -> FieldAt:
    """The field at places xy (k, 2) mm of the owners (k), image, flight or camera ids; nodes cover +-half_mm."""
    count = 2 + int(np.ceil(2.0 * half_mm / field.length_mm * NODES_PER_LENGTH))
    nodes = np.linspace(-half_mm, half_mm, count)
    kernel = _correlation(nodes, nodes, field.length_mm) + JITTER * np.eye(count)
    inverse_root = np.linalg.inv(np.linalg.cholesky(kernel)).T
    names = tuple(dict.fromkeys(owner))
    place = {name: number for number, name in enumerate(names)}
    return FieldAt(
        field,
        _correlation(xy_mm[:, 0], nodes, field.length_mm) @ inverse_root,
        _correlation(xy_mm[:, 1], nodes, field.length_mm) @ inverse_root,
        np.array([place[name] for name in owner], dtype=np.intp),
        names,
    )


def _correlation(a: Floats, b: Floats, length: float) -> Floats:
    return np.asarray(np.exp(-0.5 * ((a[:, None] - b) / length) ** 2))
