"""Image coordinates against the format: units, origin, and what lies outside."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from adjust.plausibility.finding import Finding, listed
from simfield.block import Block, Floats

OUTSIDE = 1.05
"""a coordinate beyond the edge by 5 % of the half format: more than a frame wears"""
FAR_OUTSIDE, SMALL = 20.0, 0.02
"""in half formats: from here on it is the unit"""
FEWEST = 8
"""image points of a camera, for what all of them have in common"""
AT_THE_CORNER = 0.02


def findings(block: Block) -> Iterator[Finding]:
    """For every camera at most one of unit, origin and points outside: the first explains the others."""
    o = block.observations
    for number, camera in enumerate(block.cameras):
        rows = np.flatnonzero(block.image_camera == number)
        if not len(rows):
            continue
        half = 0.5 * np.array([camera.width_mm, camera.height_mm])
        share = np.abs(o.xy[rows]) / half
        place = f"camera {camera.camera_id}"
        if finding := _unit(share, place, len(rows)):
            yield finding
        elif corner := from_the_corner(o.xy[rows], half):
            yield Finding(
                "origin",
                "worthless",
                place,
                f"all {len(rows)} image points have {corner}, up to {float(share.max()):.2f} half formats: they are "
                "counted from a corner",
                "count from the centre of the format: subtract half of width_mm and height_mm, with y up",
            )
        else:
            outside = rows[(share > OUTSIDE).any(axis=1)]
            if len(outside):
                at = [f"{block.points.ids[o.point[k]]} in image {block.images.ids[o.image[k]]}" for k in outside]
                yield Finding(
                    "format",
                    "doubtful",
                    place,
                    f"{len(outside)} points lie outside the format, {camera.width_mm:g} x {camera.height_mm:g} mm: "
                    f"{listed(at)}",
                    "check these coordinates, and width_mm and height_mm of the camera",
                )


def _unit(share: Floats, place: str, count: int) -> Finding | None:
    largest = float(share.max())
    if largest > FAR_OUTSIDE and float(np.median(share)) > 1.0:
        text = f"the image points reach to {largest:.3g} half formats"
        return Finding(
            "units", "worthless", place, text, "give mm: divide micrometres by 1000, multiply pixels by their size"
        )
    if largest < SMALL and count >= FEWEST:
        text = f"all {count} image points lie within {largest:.2g} half formats of the centre"
        return Finding("units", "worthless", place, text, "give mm: multiply metres by 1000")
    return None


def from_the_corner(xy: Floats, half: Floats) -> str | None:
    """What the signs of image points (k, 2) say of a corner as origin, in words; None where nothing does."""
    if len(xy) < FEWEST or not (np.abs(xy).max(axis=0) > OUTSIDE * half).any():
        return None
    low, high = xy.min(axis=0), xy.max(axis=0)
    if low[0] < -AT_THE_CORNER * half[0]:
        return None
    if low[1] >= -AT_THE_CORNER * half[1]:
        return "x and y above 0"
    if high[1] <= AT_THE_CORNER * half[1]:
        return "x above and y below 0"
    return None
