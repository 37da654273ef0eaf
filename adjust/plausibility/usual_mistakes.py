"""The usual mistakes in the frames of a block, as data: a new one is a new entry."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from adjust.model import angles_of, rotation_matrices
from adjust.plausibility.finding import Severity
from adjust.plausibility.predicted import PredictedRays
from simfield.block import Floats


@dataclass(frozen=True)
class Mistake:
    """What it is called, how bad it is, what undoes it, and what to say and to try."""

    kind: str
    severity: Severity
    undone: Callable[[PredictedRays], PredictedRays]
    text: str
    advice: str


def _turned(*matrix: tuple[float, float]) -> Callable[[PredictedRays], PredictedRays]:
    return lambda r: replace(r, xy=r.xy @ np.array(matrix).T)


def _orientation(change: Callable[[Floats], Floats]) -> Callable[[PredictedRays], PredictedRays]:
    return lambda r: replace(r, exterior=change(r.exterior))


def _angles(change: Callable[[Floats], Floats]) -> Callable[[PredictedRays], PredictedRays]:
    return _orientation(lambda e: np.hstack([e[:, :3], change(e[:, 3:])]))


def _exchanged(values: Floats) -> Floats:
    return values[:, [1, 0, *range(2, values.shape[1])]]


def _height(factor: float) -> Callable[[PredictedRays], PredictedRays]:
    return _orientation(lambda e: e * np.array([1.0, 1.0, factor, 1.0, 1.0, 1.0]))


FRAME = "the image frame has x to the right and y up, seen from behind the camera"
MISTAKES = (
    Mistake(
        "axes",
        "worthless",
        _turned((1, 0), (0, -1)),
        "y of the image points counts downward",
        f"change the sign of y: {FRAME}",
    ),
    Mistake(
        "axes",
        "worthless",
        _turned((-1, 0), (0, 1)),
        "x of the image points counts to the left",
        f"change the sign of x: {FRAME}",
    ),
    Mistake(
        "axes",
        "worthless",
        _turned((0, 1), (1, 0)),
        "x and y of the image points are exchanged",
        f"exchange them: {FRAME}",
    ),
    Mistake(
        "axes",
        "worthless",
        _turned((0, -1), (-1, 0)),
        "x and y of the image points are exchanged and count the other way",
        f"exchange them and change both signs: {FRAME}",
    ),
    Mistake(
        "axes",
        "worthless",
        lambda r: replace(r, known=_exchanged(r.known)),
        "X and Y of the points are exchanged (northing before easting)",
        "give X to the east and Y to the north, or any other frame that is right-handed with Z up",
    ),
    Mistake(
        "axes",
        "worthless",
        lambda r: replace(r, exterior=_exchanged(r.exterior)),
        "X0 and Y0 of the approximate stations are exchanged against the points",
        "give X0 to the east and Y0 to the north, as X and Y of the points",
    ),
    Mistake(
        "axes",
        "worthless",
        lambda r: replace(r, known=_exchanged(r.known), exterior=_exchanged(r.exterior)),
        "X and Y of points and stations are exchanged (northing before easting)",
        "give X to the east and Y to the north, or any other frame that is right-handed with Z up",
    ),
    Mistake(
        "axes",
        "doubtful",
        _turned((-1, 0), (0, -1)),
        "the image points are turned by 180 degrees against the approximate orientations",
        "change the signs of x and y, or add 180 degrees to kappa",
    ),
    Mistake(
        "axes",
        "doubtful",
        _turned((0, -1), (1, 0)),
        "the image points are turned by 90 degrees against the approximate orientations",
        "subtract 90 degrees from kappa, or turn x and y",
    ),
    Mistake(
        "axes",
        "doubtful",
        _turned((0, 1), (-1, 0)),
        "the image points are turned by -90 degrees against the approximate orientations",
        "add 90 degrees to kappa, or turn x and y",
    ),
    Mistake(
        "angles",
        "doubtful",
        _angles(lambda a: 0.9 * a),
        "the angles of the approximate orientations are in gon",
        "give degrees: multiply them by 0.9",
    ),
    Mistake(
        "angles",
        "doubtful",
        _angles(lambda a: np.rad2deg(a)),
        "the angles of the approximate orientations are in radians",
        "give degrees",
    ),
    Mistake(
        "angles",
        "doubtful",
        _angles(lambda a: a * np.array([1.0, 1.0, -1.0])),
        "kappa of the approximate orientations counts the other way",
        "change its sign: kappa turns from X to Y",
    ),
    Mistake(
        "angles",
        "doubtful",
        _angles(lambda a: angles_of(rotation_matrices(a).transpose(0, 2, 1))),
        "the approximate rotations go from the object to the image",
        "give omega, phi, kappa of the rotation from the image to the object",
    ),
    Mistake(
        "heights",
        "doubtful",
        _height(0.3048),
        "Z0 of the approximate stations is in feet",
        "give metres: multiply by 0.3048",
    ),
    Mistake("heights", "doubtful", _height(1000.0), "Z0 of the approximate stations is in kilometres", "give metres"),
)
