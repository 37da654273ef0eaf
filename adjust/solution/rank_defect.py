"""Singular normal equations explained: what is not determined, in words that a surveyor can act on.

The null space of the reduced matrix is taken apart in this order: images that their own points do not orient; the datum
(similarity transformations of the whole block that move no control); what is left, unknowns not to be separated.
All vectors here belong to the scaled matrix: a change dx of the unknowns appears as dx / scale.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from adjust.model import EXTERIOR_NAMES, Unknowns, point_motions, station_motions
from adjust.normals import SingularError
from adjust.observations import Observations
from simfield.block import Floats, Indices

NULL_SHARE = 1e-13
"""eigenvalues below this share of the largest belong to the null space; rounding leaves some 1e-16"""
SAME_WEAKNESS = 100.0
"""where the matrix is only nearly singular, eigenvalues up to so many times the smallest are explained with it"""
CONTAINED = 1e-5
"""sine of the angle within which a direction counts as contained in a space; eigenvectors are good to about 1e-9"""
ALIGNED = 1.0 - CONTAINED**2
"""the same as a squared cosine"""
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
        return _undetermined_point(u, (error.columns.start - u.orientation) // 3)
    if not error.scaled.size:
        return _too_large(u)
    empty = np.flatnonzero(np.diag(error.scaled) == 0.0)
    if empty.size:
        return _without_effect(u, int(empty[0]))
    null = _null_space(error.scaled)
    by_image = _loose_images(u, null)
    datum, free = _datum_inside(null, _datum_directions(u, x, error.scale))
    rest = _without(null, np.hstack([*by_image.values(), datum]))
    sentences = []
    if by_image:
        sentences.append(_say_loose(u, by_image))
    if free.shape[1]:
        sentences.append(_say_datum(u, free))
    if rest.shape[1]:
        sentences.append(_say_not_separable(u, rest))
    return "; ".join(sentences)


def _too_large(u: Unknowns) -> str:
    control = u.block.points.role == "control"
    given = (control[:, None] & np.isfinite(u.block.points.sigma)).sum(axis=0)
    return (
        f"the control has {given[0]} X, {given[1]} Y and {given[2]} Z coordinates; "
        f"the block of {len(u.block.images)} images "
        "is too large to name what is not determined, adjust a part of it and see"
    )


def _undetermined_point(u: Unknowns, point: int) -> str:
    name, rays = u.block.points.ids[point], int(u.block.rays[point])
    if rays >= 2:
        return f"point {name} is not determined: its {rays} rays are parallel"
    return f"point {name} is not determined: it has {rays} ray{'s' * (rays != 1)} and too few known coordinates"


def _without_effect(u: Unknowns, column: int) -> str:
    image = column // 6
    if image < len(u.block.images):
        return f"image {u.block.images.ids[image]} has no measured points"
    return f"{u.name(column)} has no effect on any measured point"


def _null_space(scaled: Floats) -> Floats:
    """(E, d) an orthonormal basis of the null space, of dimension one at least."""
    values, vectors = np.linalg.eigh(scaled)
    defect = int(np.sum(values < max(NULL_SHARE * values[-1], SAME_WEAKNESS * values[0])))
    return np.asarray(vectors[:, :defect])


def _without(null: Floats, taken: Floats) -> Floats:
    """An orthonormal basis of the part of span(null) that is orthogonal to the directions `taken` within it."""
    inside = null.T @ taken
    _, values, right = np.linalg.svd(inside.T, full_matrices=True)
    return np.asarray(null @ right[int(np.sum(values > CONTAINED)) :].T)


def _loose_images(u: Unknowns, null: Floats) -> dict[int, Floats]:
    """By image, the directions (E, l) in the null space that change this image alone."""
    loose: dict[int, Floats] = {}
    for image in range(len(u.block.images)):
        outside = np.ones(len(null), dtype=bool)
        outside[6 * image : 6 * image + 6] = False
        _, values, turn = np.linalg.svd(null[outside], full_matrices=True)
        values = np.pad(values, (0, null.shape[1] - len(values)))
        alone = turn[values < CONTAINED]
        if len(alone):
            loose[image] = null @ alone.T
    return loose


def _say_loose(u: Unknowns, images: Iterable[int]) -> str:
    counts = np.bincount(u.block.observations.image, minlength=len(u.block.images))
    said = [f"image {u.block.images.ids[i]} ({_points(int(counts[i]))})" for i in images]
    return _shortened(said) + " cannot be oriented: three or more points are needed, not on one line"


def _points(count: int) -> str:
    return f"{count} measured point{'s' * (count != 1)}"


def _datum_directions(u: Unknowns, x: Floats, scale: Floats) -> Floats:
    """(E, 7) the changes of the scaled orientation unknowns under the seven similarity transformations, normed."""
    exterior = u.exterior(x)
    moves = station_motions(exterior, _pivot(u, x), u.renamed)
    directions = np.zeros((len(scale), 7))
    directions[: 6 * len(exterior)] = moves.reshape(-1, 7)
    coupled = point_motions(u.points(x), _pivot(u, x)).reshape(-1, 7)[u.coupled]
    directions[len(directions) - len(coupled) :] = coupled
    directions /= scale[:, None]
    length = np.linalg.norm(directions, axis=0)
    return np.asarray(directions / np.where(length > 0.0, length, 1.0))


def _full_control(u: Unknowns) -> list[int]:
    """The points held or weighted in all three coordinates."""
    points = u.block.points
    return [int(i) for i in np.flatnonzero((points.fixed | points.weighted).all(axis=1))]


def _pivot(u: Unknowns, x: Floats) -> Floats:
    """(3) about what the block is turned and scaled: a control point, so that it need not be shifted as well."""
    at = u.points(x)
    full = _full_control(u)
    if full:
        return np.asarray(at[full[0]])
    held = u.block.points.fixed | u.block.points.weighted
    return np.array([at[held[:, i] if held[:, i].any() else slice(None), i].mean() for i in range(3)])


def _datum_inside(null: Floats, datum: Floats) -> tuple[Floats, Floats]:
    """What of the datum directions lies in the null space (E, f), and as motions (7, f): orthonormal combinations."""
    left, values, right = np.linalg.svd(datum, full_matrices=False)
    kept = values > CONTAINED * values[0]
    basis = left[:, kept]
    squared_cosine, turn = np.linalg.eigh(basis.T @ null @ (null.T @ basis))
    inside = turn[:, squared_cosine > ALIGNED]
    free, _ = np.linalg.qr((right[kept].T / values[kept]) @ inside)
    return basis @ inside, free


def _say_datum(u: Unknowns, free: Floats) -> str:
    defect = free.shape[1]
    if defect == 7:
        return "there is no control, so the datum is free (shift, rotation and scale of the whole block)"
    missing = [i for i in range(7) if np.linalg.norm(free[i]) > ALIGNED]
    said = [DATUM_NAMES[i] for i in missing]
    rest = _without(free, np.eye(7)[:, missing])
    full = _full_control(u)
    pure_turn = rest.shape[1] == 1 and np.linalg.norm(rest[3:6, 0]) > ALIGNED
    if pure_turn and len(full) >= 2:
        said.append(
            f"rotation about the line through the control points {_listed(u.block.points.ids[i] for i in full)}"
        )
    elif rest.shape[1]:
        share = np.linalg.norm(rest, axis=1)
        leading = [DATUM_NAMES[i] for i in range(7) if share[i] > LEADING * share.max()]
        said.append(("a combination of " if len(leading) > 1 else "mainly ") + _listed(leading))
    return f"the control fixes only {7 - defect} of the 7 datum elements; free: {_listed(said)}"


def _say_not_separable(u: Unknowns, null: Floats) -> str:
    leading = _leading(u, null)
    if len(leading) == 1:
        return f"{leading[0]} cannot be determined"
    combinations = f" (rank defect {null.shape[1]})" if null.shape[1] > 1 else ""
    return f"{_shortened(leading)} cannot be separated{combinations}"


def _leading(u: Unknowns, directions: Floats) -> list[str]:
    """The unknowns with the largest shares in the directions (E, d); an element of many images counts as one."""
    share = np.linalg.norm(directions, axis=1)
    images = 6 * len(u.block.images)
    found = [(float(share[i]), u.name(i)) for i in range(images, len(share))]
    for element, name in enumerate(EXTERIOR_NAMES):
        column = share[element:images:6]
        taking_part = np.flatnonzero(column >= LEADING * column.max())
        found.append((float(np.linalg.norm(column)), f"{name} of {_images(u, taking_part)}"))
    top = max(s for s, _ in found)
    return [name for s, name in found if s >= LEADING * top]


def _images(u: Unknowns, chosen: Indices) -> str:
    ids, camera = u.block.images.ids, u.block.images.camera
    mine = camera == camera[chosen[0]]
    if len(chosen) == 1:
        return f"image {ids[chosen[0]]}"
    if len(chosen) == len(ids):
        return f"all {len(ids)} images"
    if mine[chosen].all() and len(chosen) == mine.sum():
        return f"all {len(chosen)} images of camera {u.block.cameras[camera[chosen[0]]].camera_id}"
    if len(chosen) <= NAMES_MOST:
        return "images " + _listed(ids[i] for i in chosen)
    return f"{len(chosen)} of {len(ids)} images"


def _shortened(names: list[str]) -> str:
    """The first names, and how many more there are."""
    more = len(names) - NAMES_MOST
    return _listed([*names[:NAMES_MOST], f"{more} more"] if more > 0 else names)


def _listed(names: Iterable[str]) -> str:
    """a, b and c."""
    *front, last = names
    return f"{', '.join(front)} and {last}" if front else last
