"""Measured image points against those that known coordinates and approximate orientations predict.

What is predicted is predicted again under each of the usual mistakes: an axis that counts the other way, coordinates
exchanged, angles in another unit or in the other direction. The mistake is named that explains what nothing else does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np

from adjust.plausibility.finding import Finding, Severity, listed
from adjust.plausibility.image_plane import from_the_corner
from adjust.plausibility.predicted import PredictedRays, group_medians
from adjust.plausibility.usual_mistakes import MISTAKES
from simfield.block import Block, Floats, Indices

BAD, GOOD = 0.15, 0.1
"""miss of rays, in half diagonals of the format: what no start should be off, and what one may"""
FAR = 0.3
"""miss of a single image whose start is said to be wrong: ground that is not level explains less"""
NOTICED = 0.03
"""a miss from which an explanation is looked for"""
EXPLAINED = 0.5
"""share of the miss that is left by the right explanation"""
FEWEST_RAYS = 6
ALONE = 6.0
"""times the miss of the good ones, from which one image or point is odd"""
GOOD_SHARE = 0.25
"""of the rays that are good in any case: two of four control points may be exchanged"""


def _from_corner(rays: PredictedRays, block: Block) -> PredictedRays:
    """Image points of cameras whose origin is a corner, from the centre."""
    camera, xy = block.images.camera[rays.image], rays.xy.copy()
    for number, one in enumerate(block.cameras):
        half = 0.5 * np.array([one.width_mm, one.height_mm])
        rows = camera == number
        if from_the_corner(block.observations.xy[block.image_camera == number], half):
            xy[rows] -= half * np.where(np.median(xy[rows], axis=0) < 0.0, -1.0, 1.0)
    return replace(rays, xy=xy)


def findings(block: Block) -> Iterator[Finding]:
    """One of the mistakes for the whole block, or images and points that are odd."""
    rays = PredictedRays.of(block)
    rays = _from_corner(rays, block)
    seen = rays.misses()
    if np.sum(~np.isnan(seen)) < FEWEST_RAYS:
        return
    miss = rays.mean_miss()
    left = [mistake.undone(rays).mean_miss() for mistake in MISTAKES]
    best = int(np.argmin(left))
    if miss > NOTICED and left[best] <= min(GOOD, EXPLAINED * miss):
        mistake = MISTAKES[best]
        yield Finding(
            mistake.kind,
            mistake.severity,
            "the whole block",
            f"{mistake.text}: {_missed(miss)}, and by {left[best]:.2g} if that is undone",
            mistake.advice,
        )
        return
    odd = [*_odd_images(block, rays), *_odd_points(block, rays)]
    yield from odd
    if not odd and float(np.nanmedian(seen)) > BAD:
        yield Finding(
            "start",
            "note",
            "the whole block",
            _missed(miss),
            "check the approximate orientations, their unit (degrees) and the frame of the points",
        )


def _missed(miss: float) -> str:
    return f"the image points miss what the approximate orientations predict by {miss:.2g} half diagonals of the format"


def _odd(group: Indices, rays: PredictedRays, count: int) -> Indices:
    """Numbers of the groups (images or points) whose rays miss by far more than those of the others."""
    misses = rays.misses()
    usable = ~np.isnan(misses)
    misses, group = misses[usable], group[usable]
    most = max(BAD, ALONE * float(np.quantile(misses, GOOD_SHARE, method="lower"))) if len(misses) else np.inf
    return np.flatnonzero(np.nan_to_num(group_medians(misses, group, count), posinf=np.inf) > most)


def _odd_images(block: Block, rays: PredictedRays) -> Iterator[Finding]:
    odd = _odd(rays.image, rays, len(block.images))
    partners = _partners(odd, lambda i, j: replace(rays, exterior=_swapped_rows(rays.exterior, i, j)), rays, rays.image)
    for i, j in partners:
        names = " and ".join(block.images.ids[k] for k in (i, j))
        yield Finding(
            "names exchanged",
            "worthless",
            f"images {names}",
            "each fits the approximate orientation of the other and not its own",
            "exchange the names of the images, in images.csv or in observations.csv",
        )
    rest = [i for i in odd if not any(i in pair for pair in partners)]
    own = rays.misses()
    rest = [i for i in rest if np.nanmedian(own[rays.image == i]) > FAR]
    if rest:
        yield Finding(
            "start",
            "note",
            f"images {listed(block.images.ids[i] for i in rest)}",
            "the image points are far from what the approximate orientation predicts, unlike those of other images",
            "check the approximate orientation, and that the points belong to this image",
        )


def _odd_points(block: Block, rays: PredictedRays) -> Iterator[Finding]:
    rays = rays.of_known()
    odd = _odd(rays.point, rays, len(block.points))
    partners = _partners(odd, lambda i, j: replace(rays, known=_swapped_rows(rays.known, i, j)), rays, rays.point)
    for i, j in partners:
        names = " and ".join(block.points.ids[k] for k in (i, j))
        yield Finding(
            "names exchanged",
            "worthless",
            f"points {names}",
            "each is seen where the other is",
            "exchange the names of the points, in points.csv or in observations.csv",
        )
    for i in odd:
        if not any(i in pair for pair in partners):
            severity: Severity = "worthless" if block.points.role[i] == "control" else "doubtful"
            yield Finding(
                "coordinates",
                severity,
                f"{block.points.role[i]} point {block.points.ids[i]}",
                "its images are far from where its coordinates would be seen; those of the other points are not",
                "check its coordinates, digit by digit, and its name",
            )


def _swapped_rows(values: Floats, i: int, j: int) -> Floats:
    changed = values.copy()
    changed[[i, j]] = values[[j, i]]
    return changed


def _partners(
    odd: Indices, exchanged: Callable[[int, int], PredictedRays], rays: PredictedRays, group: Indices
) -> list[tuple[int, int]]:
    """Pairs of odd ones that fit once they are exchanged, the best first, each in one pair."""
    before, fits = rays.misses(), []
    for i, j in combinations(odd.tolist(), 2):
        rows = np.flatnonzero((group == i) | (group == j))
        after = float(np.nanmedian(exchanged(i, j).misses()[rows]))
        if after <= min(GOOD, EXPLAINED * float(np.nanmedian(before[rows]))):
            fits.append((after, i, j))
    found: list[tuple[int, int]] = []
    for _, i, j in sorted(fits):
        if not any(k in pair for pair in found for k in (i, j)):
            found.append((i, j))
    return found
