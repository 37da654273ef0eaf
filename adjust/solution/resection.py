"""Space resection from three points in closed form, and the best of several triples.

Grunert's solution as in Haralick, Lee, Ottenberg & Noelle: Review and analysis of solutions of the three point
perspective pose estimation problem, International Journal of Computer Vision 13 (1994), eqs. 5 to 9: the distances of
the station from three points out of a quartic, then the station by a rigid motion.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from simfield.block import Floats

TRIPLES_MOST = 24
REAL = 0.1
"""share of the imaginary part up to which a root of the quartic is taken for a double real one that noise has parted"""
NARROW_TRIANGLE = 1e-6


def seen_at(directions: Floats, points: Floats) -> list[Floats]:
    """Up to four times three points (3, 3) in the camera frame, as they are seen along unit directions (3, 3)."""
    a, b, c = (float(np.linalg.norm(points[i] - points[j])) for i, j in ((1, 2), (0, 2), (0, 1)))
    if min(a, b, c) <= 0.0:
        return []
    cos_a, cos_b, cos_c = (float(directions[i] @ directions[j]) for i, j in ((1, 2), (0, 2), (0, 1)))
    q, s = (a**2 - c**2) / b**2, (a**2 + c**2) / b**2
    quartic = [
        (q - 1.0) ** 2 - 4.0 * c**2 / b**2 * cos_a**2,
        4.0 * (q * (1.0 - q) * cos_b - (1.0 - s) * cos_a * cos_c + 2.0 * c**2 / b**2 * cos_a**2 * cos_b),
        2.0
        * (
            q**2 - 1.0 + 2.0 * q**2 * cos_b**2 + 2.0 * (b**2 - c**2) / b**2 * cos_a**2
            - 4.0 * s * cos_a * cos_b * cos_c + 2.0 * (b**2 - a**2) / b**2 * cos_c**2
        ),
        4.0 * (-q * (1.0 + q) * cos_b + 2.0 * a**2 / b**2 * cos_c**2 * cos_b - (1.0 - s) * cos_a * cos_c),
        (1.0 + q) ** 2 - 4.0 * a**2 / b**2 * cos_c**2,
    ]  # fmt: skip
    found = []
    for root in np.roots(quartic):
        v = float(root.real)
        if abs(root.imag) > REAL * max(1.0, abs(v)) or v <= 0.0:
            continue
        denominator = 2.0 * (cos_c - v * cos_a)
        nearest = b**2 / (1.0 + v**2 - 2.0 * v * cos_b)
        if denominator == 0.0 or not nearest > 0.0:
            continue
        u = ((q - 1.0) * v**2 - 2.0 * q * cos_b * v + 1.0 + q) / denominator
        if u <= 0.0:
            continue
        found.append(np.sqrt(nearest) * np.array([[1.0], [u], [v]]) * directions)
    return found


def resected(directions: Floats, points: Floats) -> tuple[Floats, Floats]:
    """Poses from the wide triangles among k points (k, 3) seen along unit directions (k, 3): stations (p, 3) and
    rotations (p, 3, 3), camera to object.
    """
    seen, there = [], []
    for triple in _wide_triples(directions):
        corners = points[list(triple)]
        found = seen_at(directions[list(triple)], corners)
        seen += found
        there += [corners] * len(found)
    if not seen:
        return np.empty((0, 3)), np.empty((0, 3, 3))
    camera, known = np.array(seen), np.array(there)
    rotations = _axes(known) @ _axes(camera).transpose(0, 2, 1)
    return known.mean(axis=1) - np.einsum("pij,pj->pi", rotations, camera.mean(axis=1)), rotations


def _axes(triangles: Floats) -> Floats:
    """(p, 3, 3), in the columns: axes along the first side of triangles (p, 3, 3), in their plane, and across it."""
    first = triangles[:, 1] - triangles[:, 0]
    across = np.cross(first, triangles[:, 2] - triangles[:, 0])
    first, across = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (first, across))
    return np.stack([first, np.cross(across, first), across], axis=2)


def _wide_triples(directions: Floats) -> list[tuple[int, ...]]:
    """Of points as far from each other in the image as can be, the triples with the largest area."""
    chosen = [int(np.argmax(np.linalg.norm(directions - directions.mean(axis=0), axis=1)))]
    while len(chosen) < min(len(directions), 8):
        distance = np.min([np.linalg.norm(directions - directions[i], axis=1) for i in chosen], axis=0)
        chosen.append(int(np.argmax(distance)))
    triples = list(combinations(sorted(set(chosen)), 3))
    area = [abs(float(np.linalg.det(directions[list(triple)]))) for triple in triples]
    order = np.argsort(area)[::-1][:TRIPLES_MOST]
    return [triples[i] for i in order if area[i] > NARROW_TRIANGLE]
