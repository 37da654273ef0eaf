"""What can be computed about a set: independence, orthogonality, and what of a lens's distortion it can take up.

On a flat object seen by near-vertical images, a small change of the exterior orientation moves the image points by the
six orientation effects. A set that contains one of them, alone or combined, cannot be estimated beside the orientation.
Singular values are those of columns scaled to unit length: 1 for orthogonal columns, 0 for dependent ones.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from adjust.ap_models.model import ApModel
from simfield.block import Floats

HALF_FORMAT_MM = 108.0
POINTS_A_SIDE = 19
ORIENTATION_EFFECTS = ("X0", "Y0", "Z0", "kappa", "phi", "omega")


def grid(half_format_mm: float = HALF_FORMAT_MM, n: int = POINTS_A_SIDE) -> tuple[Floats, Floats]:
    """x, y (n^2), mm: an even grid over the format, edges included."""
    return product_grid(np.linspace(-half_format_mm, half_format_mm, n))


def product_grid(positions_mm: Sequence[float] | Floats) -> tuple[Floats, Floats]:
    """x, y of the grid with these positions along both axes."""
    x, y = np.meshgrid(np.asarray(positions_mm, float), np.asarray(positions_mm, float))
    return x.ravel(), y.ravel()


def orientation_effects(x: Floats, y: Floats) -> Floats:
    """(k, 2, 6) what X0, Y0, Z0, kappa, phi and omega do to the image of flat ground, up to constants and scale."""
    zero, one = np.zeros_like(x), np.ones_like(x)
    dx = np.stack([one, zero, x, y, x**2, x * y], axis=-1)
    dy = np.stack([zero, one, y, -x, x * y, y**2], axis=-1)
    return np.stack([dx, dy], axis=1)


def with_orientation(model: ApModel, x: Floats, y: Floats, leave_out: Sequence[str] = ()) -> Floats:
    """(2k, 6 + a) the orientation effects and the terms of the model but those left out, columns of unit length."""
    kept = [j for j, name in enumerate(model.parameters) if name not in leave_out]
    return _columns(np.concatenate([orientation_effects(x, y), model.basis(x, y)[:, :, kept]], axis=2))


def independence(model: ApModel, half_format_mm: float = HALF_FORMAT_MM, n: int = POINTS_A_SIDE) -> float:
    """The smallest singular value of the terms of the model among themselves; 1 without terms."""
    return smallest_singular_value(_columns(model.basis(*grid(half_format_mm, n))))


def independence_of_orientation(
    model: ApModel,
    leave_out: Sequence[str] = (),
    half_format_mm: float = HALF_FORMAT_MM,
    n: int = POINTS_A_SIDE,
) -> float:
    """The smallest singular value of the terms and the orientation effects together, above that of the effects alone.

    The effects are made orthonormal first, so their own correlation (X0 with phi, Y0 with omega) does not count.
    """
    columns = with_orientation(model, *grid(half_format_mm, n), leave_out)
    effects, _ = np.linalg.qr(columns[:, :6])
    return smallest_singular_value(np.hstack([effects, columns[:, 6:]]))


def dependence_on_others(model: ApModel, name: str, half_format_mm: float = HALF_FORMAT_MM) -> float:
    """The share (rms) of one term that neither the orientation nor the estimable terms take up; 0 if not estimable."""
    x, y = grid(half_format_mm)
    term = _columns(model.basis(x, y))[:, model.parameters.index(name)]
    others = with_orientation(model, x, y, (*model.not_estimable, name))
    return float(np.linalg.norm(_remainder(term, others)))


def largest_cosines(model: ApModel, x: Floats, y: Floats) -> tuple[float, float]:
    """Of the points x, y: the largest |cosine| between two terms, and between a term and an orientation effect."""
    columns = with_orientation(model, x, y)
    effects, terms = columns[:, :6], columns[:, 6:]
    among = np.abs(terms.T @ terms) - np.eye(terms.shape[1])
    return float(np.max(among, initial=0.0)), float(np.max(np.abs(effects.T @ terms), initial=0.0))


def span_gap(one: ApModel, other: ApModel, half_format_mm: float = HALF_FORMAT_MM) -> float:
    """The sine of the largest angle between the spaces of two sets, each with the orientation effects.

    0 if they are the same space, 1 as soon as their dimensions differ.
    """
    x, y = grid(half_format_mm)
    a, b = (_orthonormal(with_orientation(model, x, y)) for model in (one, other))
    if a.shape[1] != b.shape[1]:
        return 1.0
    return float(np.linalg.norm(b - a @ (a.T @ b), ord=2))


def share_of_radial_cubic(model: ApModel, half_format_mm: float = HALF_FORMAT_MM, n: int = POINTS_A_SIDE) -> float:
    """The share of a pure radial r^3 distortion that the set takes up beside the orientation.

    1 - (what is left with the set) / (what is left with the orientation alone), in sums of squares over the grid.
    """
    x, y = grid(half_format_mm, n)
    r2 = x**2 + y**2
    signal = np.stack([x * r2, y * r2], axis=1).ravel()
    columns = with_orientation(model, x, y)
    alone, left = _remainder(signal, columns[:, :6]), _remainder(signal, columns)
    return float(1.0 - (left @ left) / (alone @ alone))


def smallest_singular_value(columns: Floats) -> float:
    """1 without columns."""
    return float(np.linalg.svd(columns, compute_uv=False)[-1]) if columns.shape[1] else 1.0


def _columns(basis: Floats) -> Floats:
    """(2k, a) of unit length from a basis (k, 2, a); a column of zeros stays."""
    columns = basis.reshape(2 * len(basis), basis.shape[2])
    length = np.linalg.norm(columns, axis=0)
    return np.asarray(columns / np.where(length > 0.0, length, 1.0))


def _orthonormal(columns: Floats, tolerance: float = 1e-9) -> Floats:
    u, s, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(u[:, s > tolerance * s[0]])


def _remainder(signal: Floats, columns: Floats) -> Floats:
    q = _orthonormal(columns)
    return np.asarray(signal - q @ (q.T @ signal))
