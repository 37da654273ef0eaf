"""The usual mistakes, put into a block at random: what was done, and the kind and place that must be named."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from simfield.block import Block, ImageObservations, Images, Points
from simfield.block.further import Further, Stations

Random = np.random.Generator
Named = tuple[str, tuple[str, ...]]
"""the kind of the finding, and words of which its place or text has every one"""
Made = tuple[Block, Named]


def with_xy(block: Block, xy: np.ndarray) -> Block:
    return block.replace_image_points(xy)


def with_points(block: Block, **changed: np.ndarray) -> Block:
    return replace(block, points=replace(block.points, **changed))


def with_exterior(block: Block, exterior: np.ndarray) -> Block:
    return replace(block, images=Images(block.images.ids, block.images.camera, exterior))


def halves(block: Block) -> np.ndarray:
    return np.array([(c.width_mm, c.height_mm) for c in block.cameras])[block.image_camera] / 2.0


def control_of(block: Block) -> np.ndarray:
    return np.flatnonzero(block.points.role == "control")


def y_down(block: Block, random: Random) -> Made:
    return with_xy(block, block.observations.xy * [1.0, -1.0]), ("axes", ("y of the image points",))


def x_left(block: Block, random: Random) -> Made:
    return with_xy(block, block.observations.xy * [-1.0, 1.0]), ("axes", ("x of the image points",))


def x_y_exchanged(block: Block, random: Random) -> Made:
    return with_xy(block, block.observations.xy[:, ::-1]), ("axes", ("x and y of the image points are exchanged",))


def northing_first(block: Block, random: Random) -> Made:
    return with_points(block, coordinates=block.points.coordinates[:, [1, 0, 2]]), (
        "axes",
        ("northing before easting",),
    )


def metres(block: Block, random: Random) -> Made:
    return with_xy(block, block.observations.xy / 1000.0), ("units", ("camera",))


def micrometres(block: Block, random: Random) -> Made:
    return with_xy(block, block.observations.xy * 1000.0), ("units", ("camera",))


def pixels_from_the_corner(block: Block, random: Random) -> Made:
    return with_xy(block, (block.observations.xy + halves(block)) / 0.004), ("units", ("camera",))


def corner(block: Block, random: Random) -> Made:
    return with_xy(block, block.observations.xy + halves(block)), ("origin", ("camera",))


def corner_and_y_down(block: Block, random: Random) -> Made:
    return with_xy(block, block.observations.xy * [1.0, -1.0] + halves(block)), ("axes", ("y of the image points",))


def control_exchanged(block: Block, random: Random) -> Made:
    i, j = random.choice(control_of(block), 2, replace=False)
    coordinates = block.points.coordinates.copy()
    coordinates[[i, j]] = coordinates[[j, i]]
    ids = block.points.ids
    return with_points(block, coordinates=coordinates), ("names exchanged", (ids[i], ids[j]))


def control_mistyped(block: Block, random: Random) -> Made:
    """One digit of one coordinate: by 10, 30 or 90 m where the field is kilometres wide."""
    i = int(random.choice(control_of(block)))
    coordinates = block.points.coordinates.copy()
    wide = float(np.ptp(coordinates[control_of(block)], axis=0).max())
    coordinates[i, random.integers(3)] += random.choice([-1.0, 1.0]) * random.choice([0.005, 0.015, 0.045]) * wide
    return with_points(block, coordinates=coordinates), ("coordinates", (block.points.ids[i],))


def control_without_sigma(block: Block, random: Random) -> Made:
    chosen = random.choice(control_of(block), random.integers(1, 4), replace=False)
    sigma = block.points.sigma.copy()
    sigma[chosen] = np.nan
    return with_points(block, sigma=sigma), ("control not used", (block.points.ids[chosen.min()],))


def images_exchanged(block: Block, random: Random) -> Made:
    """Two images far apart: their points stand under each other's name."""
    while True:
        i, j = random.choice(len(block.images), 2, replace=False)
        apart = np.linalg.norm(block.images.exterior[i, :3] - block.images.exterior[j, :3])
        if block.images.camera[i] == block.images.camera[j] and apart > 0.5 * np.abs(
            np.ptp(block.images.exterior[:, 2])
        ):
            turned = block.images.exterior[[i, j], 3:]
            if apart > 0.5 * block.images.exterior[i, 2] or np.abs(np.diff(turned, axis=0)).max() > 1.0:
                break
    exterior = block.images.exterior.copy()
    exterior[[i, j]] = exterior[[j, i]]
    return with_exterior(block, exterior), ("names exchanged", (block.images.ids[i], block.images.ids[j]))


def gon(block: Block, random: Random) -> Made:
    exterior = block.images.exterior.copy()
    exterior[:, 3:] /= 0.9
    return with_exterior(block, exterior), ("angles", ("gon",))


def kappa_backward(block: Block, random: Random) -> Made:
    return with_exterior(block, block.images.exterior * [1, 1, 1, 1, 1, -1]), ("angles", ("kappa",))


def c_in_metres(block: Block, random: Random) -> Made:
    cameras = tuple(replace(c, c_mm=c.c_mm / 1000.0) for c in block.cameras)
    return replace(block, cameras=cameras), ("principal distance", ("camera",))


def sigma_in_micrometres(block: Block, random: Random) -> Made:
    o = block.observations
    changed = ImageObservations(o.image, o.point, o.xy, o.sigma * 1000.0)
    return replace(block, observations=changed), ("standard deviations", ("image points",))


def two_parts(block: Block, random: Random) -> Made:
    """Another block beside it, a copy with names of its own, that shares nothing."""
    o, p, i = block.observations, block.points, block.images
    m, n = len(i), len(p)
    shift = np.array([0.3, 0.0, 0.0]) * float(np.ptp(p.coordinates[control_of(block), 0]))
    images = Images(
        (*i.ids, *(f"second-{each}" for each in i.ids)),
        np.tile(i.camera, 2),
        np.vstack([i.exterior, i.exterior + np.append(shift, np.zeros(3))]),
    )
    points = Points(
        (*p.ids, *(f"second-{each}" for each in p.ids)),
        np.tile(p.role, 2),
        np.vstack([p.coordinates, p.coordinates + shift]),
        np.tile(p.sigma, (2, 1)),
    )
    seen = ImageObservations(
        np.concatenate([o.image, o.image + m]),
        np.concatenate([o.point, o.point + n]),
        np.tile(o.xy, (2, 1)),
        np.tile(o.sigma, (2, 1)),
    )
    return Block(block.cameras, images, points, seen), ("parts", ("second-",))


def stations_too_high(block: Block, random: Random) -> Made:
    """GNSS above the ellipsoid, control above the geoid: 20 to 60 m."""
    exterior = block.images.exterior
    position = exterior[:, :3] + [0.0, 0.0, random.uniform(20.0, 60.0)]
    m = len(block.images)
    stations = Stations(
        image=np.arange(m),
        strip=np.full(m, -1),
        time_s=np.full(m, np.nan),
        position=position,
        sigma_position=np.full((m, 3), 0.1),
        attitude=np.full((m, 3), np.nan),
        sigma_attitude=np.full((m, 3), np.nan),
    )
    return replace(block, further=Further(stations=stations)), ("stations against control", ("Z0",))


MISTAKES: dict[str, Callable[[Block, Random], Made]] = {
    "y counts downward": y_down,
    "x counts to the left": x_left,
    "x and y exchanged": x_y_exchanged,
    "northing before easting": northing_first,
    "image points in metres": metres,
    "image points in micrometres": micrometres,
    "pixels from the corner": pixels_from_the_corner,
    "from the corner": corner,
    "from the corner with y down": corner_and_y_down,
    "two control points exchanged": control_exchanged,
    "a digit of a control coordinate": control_mistyped,
    "control without standard deviation": control_without_sigma,
    "two images exchanged": images_exchanged,
    "angles in gon": gon,
    "kappa the other way": kappa_backward,
    "principal distance in metres": c_in_metres,
    "standard deviations in micrometres": sigma_in_micrometres,
    "two blocks without a common point": two_parts,
    "GNSS heights in another datum": stations_too_high,
}
