"""Which pose an image has, where the points known in it leave several: three points do, and four seen from afar.

What one image leaves open, two may settle: the rays of the points that they share have to meet.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from adjust.model import angles_of, rotation_matrices
from adjust.observations import ImagePoints
from adjust.solution.resection import resected
from simfield.block import Floats, Indices

ALIKE_FACTOR, ALIKE_SIGMAS = 3.0, 4.0
"""poses whose mean misfit is no larger than so many times that of the best, and so many standard deviations, stay"""
SAME_ANGLE, SAME_SHARE = 0.03, 0.02
"""rad, and share of the distance to the points, within which two poses are one"""
POSES_MOST, PAIRS_MOST = 8, 12
BEHIND_MM = 1e3
"""what a point behind a camera counts as"""
UP_WEIGHT = 1e-3
"""of the tilt, by which poses are sorted that fit as well"""


def hypotheses(image: int, points: Floats, g: ImagePoints, last: bool = False) -> list[Floats]:
    """The poses (6) that the known points (n, 3) of an image, three at least, cannot tell apart, the best first.

    last: where three points have none, the vertical image that fits them as well as it can.
    """
    rows = np.arange(g.starts[image], g.starts[image + 1])
    rows = rows[np.isfinite(points[g.point[rows]]).all(axis=1)]
    if len(rows) < 3:
        return []
    known, camera = points[g.point[rows]], _camera(image, rows, g)
    stations, turns = resected(camera / np.linalg.norm(camera, axis=1, keepdims=True), known)
    resections, vertical = np.hstack([stations, angles_of(turns)]), _vertical(camera, known)
    # all that fit three points are as good, and the vertical image is not asked for
    poses = resections if len(rows) == 3 and (len(resections) or not last) else np.vstack([*vertical, resections])
    if not len(poses):
        return []
    rotations = rotation_matrices(poses[:, 3:])
    misfits = _missed(poses, rotations, camera, known).mean(axis=1)
    ranks = misfits + UP_WEIGHT * (1.0 - rotations[:, 2, 2])  # of those that fit as well the least tilted one first
    sigma_mm = float(np.mean(1.0 / np.sqrt(np.where(g.weight[rows] > 0.0, g.weight[rows], np.nan))))
    most = ALIKE_FACTOR * misfits.min() + ALIKE_SIGMAS * (sigma_mm if len(rows) > 3 else np.inf)
    same = _same(poses, rotations, known)
    chosen: list[int] = []
    for number in np.argsort(ranks):
        if not misfits[number] > most and not same[number, chosen].any() and len(chosen) < POSES_MOST:
            chosen.append(int(number))
    return list(poses[chosen])


def settled(
    open_ones: Mapping[int, Sequence[Floats]], exterior: Floats, points: Floats, g: ImagePoints, place: int = 0
) -> dict[int, Floats]:
    """Of images with several poses, one or two with the poses that agree best with another image: by image, the pose.

    exterior (m, 6) has the images that are oriented already, NaN elsewhere. place: 0 is the best answer, 1 the next.
    """
    poses: dict[int, Sequence[Floats]] = dict(open_ones)
    poses |= {int(i): [exterior[i]] for i in np.flatnonzero(np.isfinite(exterior[:, 0]))}
    by_pair = []
    for first, second, left, right in _pairs(open_ones, poses, g):
        scores = _disagreement(
            _Seen.of(first, poses[first], left, g), _Seen.of(second, poses[second], right, g), points
        )
        answers = [
            (float(scores[a, b]), {i: poses[i][at] for i, at in ((first, a), (second, b)) if i in open_ones})
            for a, b in np.ndindex(scores.shape)
        ]
        by_pair.append(sorted(answers, key=lambda answer: answer[0]))
    if not by_pair:
        image, own = next(iter(open_ones.items()))
        return {image: own[min(place, len(own) - 1)]}
    best = min(by_pair, key=lambda answers: answers[0][0])
    return best[min(place, len(best) - 1)][1]


def _pairs(
    open_ones: Mapping[int, Sequence[Floats]], poses: Mapping[int, Sequence[Floats]], g: ImagePoints
) -> Iterator[tuple[int, int, Indices, Indices]]:
    """Pairs of images of which one at least is open, with the rows of the points that they share; most points first."""
    found = []
    for first in open_ones:
        for second in poses:
            if second != first and (second not in open_ones or second > first):
                a, b = (np.arange(g.starts[i], g.starts[i + 1]) for i in (first, second))
                _, at, there = np.intersect1d(g.point[a], g.point[b], return_indices=True)
                if len(at) > 3:
                    found.append((first, second, a[at], b[there]))
    yield from sorted(found, key=lambda pair: -len(pair[2]))[:PAIRS_MOST]


@dataclass(frozen=True, eq=False)
class _Seen:
    """k points in an image with p poses (p, 6): their R (p, 3, 3), the points (k, 3) in the camera frame, mm, and which
    ones they are.
    """

    poses: Floats
    rotations: Floats
    camera: Floats
    point: Indices

    @classmethod
    def of(cls, image: int, poses: Sequence[Floats], rows: Indices, g: ImagePoints) -> _Seen:
        both = np.array(poses)
        return cls(both, rotation_matrices(both[:, 3:]), _camera(image, rows, g), g.point[rows])

    @property
    def directions(self) -> Floats:
        """(p, k, 3) unit vectors."""
        rays = self.camera @ self.rotations.transpose(0, 2, 1)
        return np.asarray(rays / np.linalg.norm(rays, axis=2, keepdims=True))


def _disagreement(one: _Seen, other: _Seen, points: Floats) -> Floats:
    """(p, q) the mean distances in the images, mm, by which the poses of two images miss the points that they share,
    known or intersected.
    """
    place = _between(one.poses[:, :3], other.poses[:, :3], one.directions, other.directions)
    known = points[one.point]
    place = np.where(np.isfinite(known), known, place)
    first = [_missed(one.poses, one.rotations, one.camera, place[:, j]) for j in range(place.shape[1])]
    second = [_missed(other.poses, other.rotations, other.camera, place[i]) for i in range(place.shape[0])]
    return np.asarray(0.5 * (np.stack(first, axis=1).mean(axis=2) + np.stack(second).mean(axis=2)))


def _between(first: Floats, second: Floats, a: Floats, b: Floats) -> Floats:
    """(p, q, k, 3) the points midway between two rays each, from stations (p, 3), (q, 3) along unit directions
    a (p, k, 3), b (q, k, 3).
    """
    base = (second - first[:, None])[:, :, None]
    a, b = a[:, None], b[None]
    c, along_a, along_b = np.sum(a * b, axis=3), np.sum(a * base, axis=3), np.sum(b * base, axis=3)
    with np.errstate(all="ignore"):
        s = ((along_a - c * along_b) / (1.0 - c**2))[..., None]
        t = ((c * along_a - along_b) / (1.0 - c**2))[..., None]
    return np.asarray(0.5 * (first[:, None, None] + s * a + second[:, None] + t * b))


def _camera(image: int, rows: Indices, g: ImagePoints) -> Floats:
    """(k, 3) image points in the camera frame, mm."""
    return np.column_stack([g.xy[rows] - g.interior[image, 1:], np.full(len(rows), -g.interior[image, 0])])


def _vertical(camera: Floats, known: Floats) -> list[Floats]:
    """The vertical image over known points (k, 3), by a plane similarity, seen along (k, 3) of the camera frame, mm."""
    z_image, z_object = camera[:, :2] @ [1.0, 1.0j], known[:, :2] @ [1.0, 1.0j]
    design = np.column_stack([z_image, np.ones(len(known))])
    (turn, shift), *_ = np.linalg.lstsq(design, z_object, rcond=None)
    height = -camera[0, 2] * abs(turn) + known[:, 2].mean()
    return [np.array([shift.real, shift.imag, height, 0.0, 0.0, np.angle(turn)])] if abs(turn) > 0.0 else []


def _missed(poses: Floats, rotations: Floats, camera: Floats, known: Floats) -> Floats:
    """(p, k) the distances in the image, mm, by which poses (p, 6) with R (p, 3, 3) miss points (k, 3) or (p, k, 3)."""
    seen = (known - poses[:, None, :3]) @ rotations
    with np.errstate(all="ignore"):
        missed = np.linalg.norm(camera[:, 2:] * seen[..., :2] / seen[..., 2:] - camera[:, :2], axis=-1)
    return np.where((seen[..., 2] < 0.0) & np.isfinite(missed), missed, BEHIND_MM)


def _same(poses: Floats, rotations: Floats, known: Floats) -> npt.NDArray[np.bool_]:
    """(p, p): which of the poses (p, 6), their R (p, 3, 3), are one."""
    cosine = (np.einsum("pij,qij->pq", rotations, rotations) - 1.0) / 2.0
    stations = poses[:, :3]
    apart = np.linalg.norm(stations[:, None] - stations, axis=-1)
    near = SAME_SHARE * np.linalg.norm(known.mean(axis=0) - stations, axis=1)
    return np.asarray((cosine > np.cos(SAME_ANGLE)) & (apart < near[:, None]))
