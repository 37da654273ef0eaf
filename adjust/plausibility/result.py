"""The result of an adjustment against its start values: what was turned over, and whether another pose fits better."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from adjust.adjustment import Adjustment
from adjust.bundle import adjust_block
from adjust.model import rotation_matrices
from adjust.plausibility.finding import Finding, listed
from adjust.plausibility.predicted import group_medians
from simfield.block import Floats

MOVED = 0.5
"""of the distance to its points, by which a station moves from a start that was worth something"""
TURNED_DEG = 60.0
SMALL_BLOCK = 4
"""images up to which the whole block is started anew from poses of our own"""
BETTER = 0.8
"""of sigma0: the other pose fits better beyond doubt; closer ones are told apart by little"""


def findings(a: Adjustment) -> Iterator[Finding]:
    """Those of an adjustment that came to an end."""
    yield from _far_from_start(a)
    yield from _other_pose(a)


def _far_from_start(a: Adjustment) -> Iterator[Finding]:
    start, found = a.block.images.exterior, a.exterior
    given = np.isfinite(start).all(axis=1)
    distance = _distances(a)
    moved = np.linalg.norm(found[:, :3] - start[:, :3], axis=1)
    between = rotation_matrices(start[given, 3:]).transpose(0, 2, 1) @ rotation_matrices(found[given, 3:])
    turned = np.zeros(len(start))
    turned[given] = np.degrees(np.arccos(np.clip(0.5 * (np.trace(between, axis1=1, axis2=2) - 1.0), -1.0, 1.0)))
    with np.errstate(invalid="ignore"):
        far = given & ((moved > MOVED * distance) | (turned > TURNED_DEG))
    if not far.any():
        return
    rows = np.flatnonzero(far)
    first = int(rows[np.argmax((moved / distance)[rows])])
    over = 2 * len(rows) > int(given.sum())
    name = a.block.images.ids[first]
    yield Finding(
        "far from start",
        "worthless" if over else "doubtful",
        f"images {listed(a.block.images.ids[i] for i in rows)}",
        f"the adjusted orientation of {len(rows)} of {int(given.sum())} images is far from its start: {name} moved by "
        f"{moved[first]:.4g} m (Z0 from {start[first, 2]:.4g} to {found[first, 2]:.4g} m), "
        f"{moved[first] / distance[first]:.2g} times its distance from the points, turned by {turned[first]:.0f} deg",
        "if the start is right the block was turned over or scaled: look whether y of the image points counts upward, "
        "whether X is east and Y north, and at the units; if the start was made up, say so by leaving it empty",
    )


def _distances(a: Adjustment) -> Floats:
    """(m) median distance of an image's points from its station, m."""
    o = a.block.observations
    ray = np.linalg.norm(a.coordinates[o.point] - a.exterior[o.image, :3], axis=1)
    return group_medians(ray, o.image, len(a.block.images))


def _other_pose(a: Adjustment) -> Iterator[Finding]:
    """A small block may fit a second pose as well, such as that of a plane seen from its other side."""
    images = a.block.images
    if len(images) > SMALL_BLOCK or not np.isfinite(images.exterior).any():
        return
    anew = replace(a.block, images=replace(images, exterior=np.full_like(images.exterior, np.nan)))
    other = adjust_block(anew, a.layout.sets[0].model if a.layout.sets else None)
    if not other.status.ok or not other.sigma0 < BETTER * a.sigma0:
        return
    first = int(np.argmax(np.linalg.norm(other.exterior[:, :3] - a.exterior[:, :3], axis=1)))
    x, y, z = other.exterior[first, :3]
    yield Finding(
        "other pose",
        "worthless",
        f"image {images.ids[first]}",
        f"another pose fits better: sigma0 {other.sigma0:.4g} instead of {a.sigma0:.4g}, with the station at "
        f"{x:.6g}, {y:.6g}, {z:.6g} m",
        "leave the approximate orientation empty, or give this one: the start lies on the wrong side of a flat target",
    )
