"""What the tables of a block say about themselves: roles and their use, units, standard deviations, connection."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from adjust.plausibility.finding import Finding, listed
from simfield.block import Block

NARROWEST, WIDEST = 50.0, 0.15
"""principal distance over half the diagonal of the format, of any perspective: 1000 mm and 3 mm on 36 x 24"""
LARGEST_SHARE, SMALLEST_MM = 0.005, 1e-6
"""standard deviations of image coordinates: half a percent of the format, and a nanometre"""
SMALLEST_M = 1e-7
"""a standard deviation of control below which nobody measures"""


def findings(block: Block) -> Iterator[Finding]:
    """All of them."""
    yield from _principal_distances(block)
    yield from _standard_deviations(block)
    yield from _control_in_use(block)
    yield from _parts(block)


def _principal_distances(block: Block) -> Iterator[Finding]:
    for camera in block.cameras:
        ratio = abs(camera.c_mm) / (0.5 * float(np.hypot(camera.width_mm, camera.height_mm)))
        if not WIDEST < ratio < NARROWEST:
            yield Finding(
                "principal distance",
                "worthless",
                f"camera {camera.camera_id}",
                f"c_mm {camera.c_mm:g} does not go with a format of {camera.width_mm:g} x {camera.height_mm:g} mm: the "
                f"angle of view would be {np.degrees(2.0 * np.arctan(1.0 / ratio)):.3g} degrees",
                "check the units of c_mm, width_mm and height_mm, which are mm and not m or pixels",
            )


def _standard_deviations(block: Block) -> Iterator[Finding]:
    o = block.observations
    size = np.array([np.hypot(c.width_mm, c.height_mm) for c in block.cameras])[block.image_camera]
    largest, smallest = o.sigma.max(axis=1), o.sigma.min(axis=1)
    for rows, said in ((largest > LARGEST_SHARE * size, "so large"), (smallest < SMALLEST_MM, "so small")):
        if rows.any():
            row = int(np.argmax(rows))
            value = float(largest[row] if said == "so large" else smallest[row])
            yield Finding(
                "standard deviations",
                "worthless" if rows.all() else "doubtful",
                f"{int(rows.sum())} of {len(o)} image points, the first {block.points.ids[o.point[row]]} in image "
                f"{block.images.ids[o.image[row]]}",
                f"a standard deviation of {value:g} mm is {said} that the coordinate has "
                f"{'no weight' if said == 'so large' else 'all weight'}",
                "check the unit: standard deviations of image coordinates are in mm, 4 um are 0.004",
            )
    p = block.points
    known = p.coordinates[p.role == "control"]
    if not len(known):
        return
    extent = float(np.nanmax(np.nanmax(known, axis=0) - np.nanmin(known, axis=0))) if np.isfinite(known).any() else 0.0
    weighted = p.weighted & np.isfinite(p.sigma)
    for cells, said in (
        (weighted & (p.sigma > max(extent, 1e-3)), "larger than the control is wide"),
        (weighted & (p.sigma < SMALLEST_M), "smaller than anybody measures"),
    ):
        if cells.any():
            rows = np.flatnonzero(cells.any(axis=1))
            yield Finding(
                "standard deviations",
                "doubtful",
                f"control {listed(p.ids[i] for i in rows)}",
                f"a standard deviation of {float(p.sigma[cells][0]):g} m is {said}",
                "check the unit: standard deviations of control are in m; 0 holds it fixed, empty leaves it open",
            )


def _control_in_use(block: Block) -> Iterator[Finding]:
    p = block.points
    control = p.role == "control"
    idle = control[:, None] & np.isfinite(p.coordinates) & np.isnan(p.sigma)
    if idle.any():
        rows = np.flatnonzero(idle.any(axis=1))
        whole = int((idle | ~np.isfinite(p.coordinates))[rows].all(axis=1).sum())
        yield Finding(
            "control not used",
            "worthless" if whole == int(control.sum()) else "doubtful",
            f"control {listed(p.ids[i] for i in rows)}",
            f"{int(idle.sum())} coordinates of {len(rows)} of {int(control.sum())} control points have no standard "
            "deviation, so they hold nothing: an empty one leaves a coordinate open",
            "give a standard deviation in m, or 0 to hold the coordinate fixed",
        )


def _parts(block: Block) -> Iterator[Finding]:
    """Images that are connected by common points, and those that are not."""
    o, m, n = block.observations, len(block.images), len(block.points)
    graph = coo_array((np.ones(len(o)), (o.image, m + o.point)), shape=(m + n, m + n))
    _, part = connected_components(graph, directed=False)
    of_images = part[:m]
    seen, sizes = np.unique(of_images, return_counts=True)
    if len(seen) < 2:
        return
    order = np.argsort(-sizes)
    said = [listed(block.images.ids[i] for i in np.flatnonzero(of_images == seen[k])) for k in order[:4]]
    more = f"; and {len(seen) - 4} more parts" if len(seen) > 4 else ""
    yield Finding(
        "parts",
        "doubtful",
        f"images {said[1]}",
        f"the block falls into {len(seen)} parts without a common point: images {'; images '.join(said)}{more}",
        "measure points in images of both, or adjust the parts by themselves; each needs control of its own",
    )
