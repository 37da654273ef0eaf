"""Film between exposure and measurement: polynomials (simfield.disturbances.distortion) and a smooth random field."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from simfield.block import Floats
from simfield.random import Words, counter_key, name_words, normal_pairs

NODES_PER_LENGTH = 12
SHORT_OF_VARIANCE = 1e-2
"""the most of the variance that the modes left out may have, over the whole format; the standard deviation is short by
half of it, in the corners too"""
MODES_TOGETHER = 8
"""modes are taken up to the next multiple, since so many are summed at a time"""


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
    """A random field at fixed places: modes (k, q) mm, so that q pairs of normal numbers give the displacements.

    key and owner (k), a word for the image, flight or camera, are what the numbers hang on.
    """

    modes: Floats
    key: tuple[int, int]
    owner: Words

    def draw(self, trial: int) -> Floats:
        """(k, 2) mm: the displacement in one trial."""
        owners, own = np.unique(self.owner, return_inverse=True)
        numbers = np.arange(self.modes.shape[1], dtype=np.uint64)[None, :]
        drawn = normal_pairs(self.key, numbers, owners[:, None], trial)
        return np.asarray(np.einsum("kq,kqc->kc", self.modes, drawn[own]))


def field_at(field: RandomField, xy_mm: Floats, owner: tuple[str, ...], half_mm: float, seed: int) -> FieldAt:
    """The field at places xy (k, 2) mm, within +-half_mm, of the owners (k): image, flight or camera ids.

    Karhunen-Loeve expansion over the square, the strongest products of modes along x and y (Ghanem & Spanos 1991,
    Stochastic finite elements, section 2.3), by the Nystroem method.
    """
    count = 1 + NODES_PER_LENGTH * int(np.ceil(2.0 * half_mm / field.length_mm))
    nodes = np.linspace(-half_mm, half_mm, count)
    weight = np.full(count, 2.0 * half_mm / (count - 1))
    weight[[0, -1]] /= 2.0
    root = np.sqrt(weight)
    values, vectors = np.linalg.eigh(_correlation(nodes, nodes, field.length_mm) * root * root[:, None])
    values, vectors = values[::-1], vectors[:, ::-1]
    strength = np.outer(values, values).ravel() / (2.0 * half_mm) ** 2
    order = np.argsort(-strength, kind="stable")
    needed = 1 + int(np.searchsorted(np.cumsum(strength[order]), 1.0 - SHORT_OF_VARIANCE))
    kept = order[: -(-needed // MODES_TOGETHER) * MODES_TOGETHER]
    in_x, in_y = np.unravel_index(kept, (count, count))
    along_x, along_y = (_modes(xy_mm[:, axis], nodes, field.length_mm, root, values, vectors) for axis in (0, 1))
    owners = name_words(owner)
    modes = 1e-3 * field.sigma_um * along_x[:, in_x] * along_y[:, in_y]
    return FieldAt(np.ascontiguousarray(modes), counter_key(seed, "film field", field.per), owners)


def _modes(at: Floats, nodes: Floats, length: float, root: Floats, values: Floats, vectors: Floats) -> Floats:
    """(k, count): modes at `at` (k) mm, times the root of their eigenvalues; weak ones, which are noise, are 0."""
    strong = values > 1e-10 * values[0]
    scaled = np.where(strong, vectors / np.sqrt(np.where(strong, values, 1.0)), 0.0)
    return np.asarray(_correlation(at, nodes, length) @ (root[:, None] * scaled))


def _correlation(a: Floats, b: Floats, length: float) -> Floats:
    return np.asarray(np.exp(-0.5 * ((a[:, None] - b) / length) ** 2))
