"""Singular normal equations explained: which unknowns cannot be separated, and whether the datum is at fault."""

from __future__ import annotations

import numpy as np

from adjust.normals import PIVOT_LEAST, SingularError
from adjust.observations import Observations
from adjust.rotation import rotation_matrices
from adjust.unknowns import Unknowns
from simfield.block import Floats

NULL_SHARE = 1e-10
"""eigenvalues of a unit-diagonal matrix below this belong to its null space"""
LEADING = 0.25
"""an unknown is named when its share is at least this part of the largest"""
NAMES_MOST = 6
DATUM_NAMES = (
    "shift in X",
    "shift in Y",
    "shift in Z",
    "rotation about X",
    "rotation about Y",
    "rotation about Z",
    "scale",
)


def explain(error: SingularError, observations: Observations, x: Floats) -> str:
    """A sentence that names the unknowns in the null space."""
    u = observations.image_points.unknowns
    if error.columns.start >= u.orientation:
        point = u.block.points.ids[(error.columns.start - u.orientation) // 3]
        return f"point {point} is not determined: its rays are parallel or too few"
    values, vectors = np.linalg.eigh(error.scaled)
    null = vectors[:, values < max(NULL_SHARE, 10 * PIVOT_LEAST)]
    if null.shape[1] == 0:
        null = vectors[:, :1]
    datum = _datum_directions(u, x, error.scale)
    inside = _contained(datum, null)
    if inside:
        what = ", ".join(DATUM_NAMES[i] for i in inside)
        more = null.shape[1] - len(inside)
        rest = f"; {more} further combinations: {_leading(u, null)}" if more > 0 else ""
        return f"rank defect {null.shape[1]}: the control does not fix the datum ({what}){rest}"
    return f"rank defect {null.shape[1]}: cannot be separated: {_leading(u, null)}"


def _leading(u: Unknowns, null: Floats) -> str:
    """The unknowns with the largest share in the null space, sets of additional parameters first."""
    share = np.sqrt(np.sum(null**2, axis=1))
    names = [i for i in np.argsort(-share, kind="stable") if share[i] >= LEADING * share.max()]
    images = 6 * len(u.block.images)
    parameters = [i for i in np.argsort(-share, kind="stable") if i >= images and share[i] >= 1e-3 * share.max()]
    chosen = list(dict.fromkeys([*parameters[:3], *names]))[:NAMES_MOST]
    rest = len(names) - len([i for i in names if i in chosen])
    return ", ".join(u.name(int(i)) for i in chosen) + (f" and {rest} more" if rest > 0 else "")


def _datum_directions(u: Unknowns, x: Floats, scale: Floats) -> Floats:
    """(E, 7) the changes of the scaled orientation unknowns under the seven similarity transformations, normed."""
    exterior = u.exterior(x)
    directions = np.zeros((len(scale), 7))
    rotation = rotation_matrices(exterior[:, 3:])
    for image, (position, matrix) in enumerate(zip(exterior[:, :3], rotation, strict=True)):
        row = 6 * image
        directions[row : row + 3, :3] = np.eye(3)
        for axis in range(3):
            turn = np.cross(np.eye(3)[axis], position)
            directions[row : row + 3, 3 + axis] = turn
            directions[row + 3 : row + 6, 3 + axis] = _angle_change(exterior[image, 3:], matrix, axis)
        directions[row : row + 3, 6] = position
    directions /= scale[:, None]
    return np.asarray(directions / np.linalg.norm(directions, axis=0))


def _angle_change(angles: Floats, matrix: Floats, axis: int) -> Floats:
    """The change of omega, phi, kappa when the object frame turns about `axis`: solve dR = [axis]_x R."""
    from adjust.rotation import rotation_derivatives

    _, derivatives = rotation_derivatives(angles[None])
    wanted = np.cross(np.eye(3)[axis], matrix.T).T
    columns = derivatives[:, 0].reshape(3, 9).T
    return np.asarray(np.linalg.lstsq(columns, wanted.ravel(), rcond=None)[0])


def _contained(datum: Floats, null: Floats) -> list[int]:
    """Which datum directions lie in the null space (a point held in one coordinate spoils only some of them)."""
    left = datum - null @ (null.T @ datum)
    return [i for i in range(7) if np.linalg.norm(left[:, i]) < 1e-4]
