"""Space resection from three points in closed form, and the best of several triples.

Grunert's solution as in Haralick, Lee, Ottenberg & Noelle: Review and analysis of solutions of the three point
perspective pose estimation problem, International Journal of Computer Vision 13 (1994), eqs. 5 to 9: the distances of
the station from three points out of a quartic, then the station by a rigid motion.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from adjust.model import Similarity
from simfield.block import Floats

TRIPLES_MOST = 24
REAL = 0.1
"""share of the imaginary part up to which a root of the quartic is taken for a double real one that noise has parted"""
NARROW_TRIANGLE = 1e-6


def poses(directions: Floats, points: Floats) -> list[tuple[Floats, Floats]]:
    """Up to four (station (3), R (3, 3) camera to object) from which three points (3, 3) are seen along unit directions
    (3, 3) of the camera frame.
    """
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
        seen = np.sqrt(nearest) * np.array([[1.0], [u], [v]]) * directions
        found.append(_rigid(seen, points))
    return found


def _rigid(seen: Floats, points: Floats) -> tuple[Floats, Floats]:
    """Station and rotation that bring what is seen (k, 3), in the camera frame, onto the points (k, 3)."""
    turn = Similarity.between(seen, points).turn
    return points.mean(axis=0) - turn @ seen.mean(axis=0), turn


def resected(directions: Floats, points: Floats) -> list[tuple[Floats, Floats]]:
    """Poses from the wide triangles among k points (k, 3) seen along unit directions (k, 3), each with its station."""
    found = []
    for triple in _wide_triples(directions):
        found += poses(directions[list(triple)], points[list(triple)])
    return found


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
