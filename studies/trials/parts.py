"""The part of a condition's block that a method adjusts, and which rows of the trials belong to it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from simfield import World, main_points
from simfield.block import Block, Floats, ImageObservations, Indices, Points
from studies.design import ALL, Method


@dataclass(frozen=True, eq=False)
class MethodBlock:
    """The noise-free block of a method; rays (k') and points (n') are its rows among those of the world.

    true (n', 3) are the true coordinates in metres, exterior (m', 6) the true orientations in metres and radians.
    """

    block: Block
    rays: Indices
    points: Indices
    true: Floats
    exterior: Floats

    @classmethod
    def of(cls, world: World, whole: Block, method: Method) -> MethodBlock:
        """From a world and its noise-free block. Raises BlockError where the method leaves nothing to adjust."""
        kept_cameras = set(whole.camera_ids if method.cameras == ALL else method.cameras.split("+"))
        image = np.array([whole.camera_ids[c] in kept_cameras for c in whole.images.camera])
        point = np.ones(len(whole.points), dtype=bool)
        if not method.aux_points:
            point = main_points(world.scenario, world.field)[world.place]
        point = point & _seen_enough(whole, image)
        rays = np.flatnonzero(image[world.image] & point[world.point])
        block = whole.select(
            cameras=kept_cameras & set(whole.camera_ids),
            points=[whole.points.ids[i] for i in np.flatnonzero(point)],
        )
        places = {name: row for row, name in enumerate(whole.points.ids)}
        points = np.array([places[name] for name in block.points.ids], dtype=np.intp)
        true = world.field.coordinates[world.place][points]
        return cls(_weighted(block, method), rays, points, true, world.exterior[image])


def noise_free_block(world: World) -> Block:
    """The block of a condition without any random error: what all its trials are disturbances of."""
    block, _ = world.observe(0)
    given = block.points
    coordinates = np.where(np.isnan(given.coordinates), np.nan, world.field.coordinates[world.place])
    o = block.observations
    return Block(
        block.cameras,
        block.images,
        Points(given.ids, given.role, coordinates, given.sigma),
        ImageObservations(o.image, o.point, world.distorted, o.sigma),
    )


def _seen_enough(block: Block, image: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """(n): control, and other points with two rays in the chosen images."""
    o = block.observations
    rays = np.bincount(o.point[image[o.image]], minlength=len(block.points))
    return np.asarray((rays >= 2) | ((block.points.role == "control") & (rays > 0)))


def _weighted(block: Block, method: Method) -> Block:
    """The block with the standard deviations that the method tells the adjustment."""
    o, p = block.observations, block.points
    image_sigma, point_sigma = o.sigma, p.sigma
    if method.image_um is not None:
        um = method.image_um
        each = [float(um[c]) if isinstance(um, Mapping) else float(um) for c in block.camera_ids]
        image_sigma = np.repeat(np.array(each)[block.image_camera, None] / 1000.0, 2, axis=1)
    if method.control_mm is not None:
        point_sigma = np.where((p.role == "control")[:, None], method.control_mm / 1000.0, p.sigma)
    return Block(
        block.cameras,
        block.images,
        Points(p.ids, p.role, p.coordinates, point_sigma),
        ImageObservations(o.image, o.point, o.xy, image_sigma),
    )
