"""The reseau: crosses of known places on a glass before the film, and what can be corrected with their images.

The light of a cross passes no lens, so the deviation of a measured cross from its place shows the film and the
comparator alone. Levels of correction, from Ziemann & El-Hakim 1982 by number; what exactly they did at each is on a
page that is not at hand, and these five are this project's reading:

    0 none    1 Helmert (similarity)    2 affine    3 bilinear (affine and xy)    4 local interpolation between crosses
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from simfield import World
from simfield.block import Floats, Indices
from simfield.disturbances import FilmAffine, FilmPolynomial, UnflatFilm
from simfield.random import stream

LEVELS = {0: "none", 1: "Helmert", 2: "affine", 3: "bilinear", 4: "local interpolation"}
SPACING_MM = 10.0
CROSSES_MM = np.arange(-110.0, 110.1, SPACING_MM)
"""places along both axes: 23 x 23 crosses; 1 cm is general knowledge on register-glass reseaux, no page at hand"""
CROSS_NOISE_UM = 2.0
"""of one coordinate of a measured cross: assumption"""
LOCAL_UM = {"rc8r": 1.4, "rmk-ar": 0.9}
"""rms of one coordinate of the film's local deformation, which only level 4 can follow: fitted to the change of the
published figures from level 3 to 4, where it has to outweigh the noise of the crosses"""
WAVES = 8
WAVELENGTH_MM = (50.0, 90.0)
FILM_EFFECTS = (FilmAffine, FilmPolynomial, UnflatFilm)


@dataclass(frozen=True, eq=False)
class LocalFilm:
    """Smooth local film deformation of every image (m): waves with amplitudes (m, WAVES, 2) mm, frequencies, phases."""

    amplitude: Floats
    frequency: Floats
    phase: Floats

    @classmethod
    def draw(cls, world: World, trial: int) -> LocalFilm:
        """The local film of a trial, from a stream of its own for every image."""
        amplitude, frequency, phase = [], [], []
        for image_id, camera_id in zip(world.plan.image_ids, world.plan.camera_ids, strict=True):
            random = stream(world.seed, "local-film", trial, image_id)
            length, angle = random.uniform(*WAVELENGTH_MM, WAVES), random.uniform(0.0, 2.0 * np.pi, WAVES)
            sigma = LOCAL_UM[camera_id] / 1000.0 / np.sqrt(WAVES / 2.0)
            amplitude.append(sigma * random.standard_normal((WAVES, 2)))
            frequency.append((2.0 * np.pi / length)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]))
            phase.append(random.uniform(0.0, 2.0 * np.pi, WAVES))
        return cls(np.array(amplitude), np.array(frequency), np.array(phase))

    def displacement(self, xy_mm: Floats, image: Indices) -> Floats:
        """(k, 2) mm at xy (k, 2) mm in the images (k)."""
        angle = np.einsum("kwi,ki->kw", self.frequency[image], xy_mm) + self.phase[image]
        return np.asarray(np.einsum("kw,kwi->ki", np.sin(angle), self.amplitude[image]))


def grid() -> Floats:
    """(g, 2) the places of the crosses, mm, y running fastest."""
    x, y = np.meshgrid(CROSSES_MM, CROSSES_MM, indexing="ij")
    return np.column_stack([x.ravel(), y.ravel()])


def measured_crosses(world: World, trial: int, local: LocalFilm, images: Indices) -> dict[int, Floats]:
    """(g, 2) mm for each of the images: the crosses as measured in it, moved by its film and disturbed by noise."""
    places, film, plan = grid(), world.film(trial), world.plan
    crosses = {}
    for number in images.tolist():
        name = (plan.camera_ids[number], plan.flight_ids[number], plan.image_ids[number])
        image = np.full(len(places), number)
        moved = places + film.displacement(places, image) + local.displacement(places, image)
        for on in world.scenario.effects:
            if isinstance(on.effect, FILM_EFFECTS) and on.acts_on(*name):
                moved += on.effect.displacement(places)
        noise = stream(world.seed, "crosses", trial, name[2]).standard_normal(places.shape)
        crosses[number] = moved + CROSS_NOISE_UM / 1000.0 * noise
    return crosses


def corrected(xy_mm: Floats, image: Indices, crosses: Mapping[int, Floats], level: int) -> Floats:
    """(k, 2) mm: image points (k, 2) in the images (k), corrected by the crosses (g, 2) of their images."""
    if level == 0:
        return xy_mm
    places = grid()
    result = xy_mm.copy()
    for number, measured in crosses.items():
        rows = image == number
        if level == max(LEVELS):
            result[rows] -= interpolated(measured - places, xy_mm[rows])
        else:
            result[rows] = _transformed(xy_mm[rows], measured, places, level)
    return result


def _transformed(xy: Floats, crosses: Floats, places: Floats, level: int) -> Floats:
    """The points by the transformation that takes the measured crosses best to their places (least squares)."""
    if level == 1:
        z, wanted = crosses @ [1.0, 1.0j], places @ [1.0, 1.0j]
        turn, shift = np.linalg.lstsq(np.column_stack([z, np.ones_like(z)]), wanted, rcond=None)[0]
        moved = turn * (xy @ [1.0, 1.0j]) + shift
        return np.column_stack([moved.real, moved.imag])
    return np.asarray(_terms(xy, level) @ np.linalg.lstsq(_terms(crosses, level), places, rcond=None)[0])


def _terms(xy: Floats, level: int) -> Floats:
    x, y = xy.T
    affine = [np.ones_like(x), x, y]
    return np.column_stack(affine if level == 2 else [*affine, x * y / SPACING_MM])


def interpolated(values: Floats, xy_mm: Floats) -> Floats:
    """(k, 2): values (g, 2) at the crosses, bilinear between the four around each point, beyond the outer ones too."""
    side = len(CROSSES_MM)
    table = values.reshape(side, side, 2)
    at = (xy_mm - CROSSES_MM[0]) / SPACING_MM
    cell = np.clip(np.floor(at).astype(int), 0, side - 2)
    (i, j), (u, v) = cell.T, (at - cell).T[:, :, None]
    low = (1.0 - v) * table[i, j] + v * table[i, j + 1]
    high = (1.0 - v) * table[i + 1, j] + v * table[i + 1, j + 1]
    return np.asarray((1.0 - u) * low + u * high)
