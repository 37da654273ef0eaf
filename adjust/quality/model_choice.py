"""Which set of additional parameters to take: information criteria, prediction, and stepwise deletion.

With n observations, u unknowns and normal errors of unknown common variance (constants left out):

    AIC = n ln(vPv / n) + 2 u          Akaike 1974
    BIC = n ln(vPv / n) + u ln n       Schwarz 1978

Only adjustments of the same observations with the same weights can be compared.

Leave-one-image-out: how well do all other images predict an image, once it is oriented? With R_ii the block of the
redundancy matrix that belongs to the image, e = R_ii^+ v_i are the residuals of its observations after resection in the
points and additional parameters that the others give. Directions of the null space (its own orientation, points that
the others do not determine) cannot be predicted and are left out, and so are those checked by less than LEAST_CHECKED.

A set of additional parameters that an image has for itself is nothing that others say. Were it fitted to the image,
sets for each image would have less to predict than one for all, and win. So it is predicted as the mean of the sets of
the same camera, weighted by their cofactors: with p that mean, v and h of the image become those of the adjustment in
which its set is held there,

    v - A Q_p Q_pp^-1 (p_found - p),    h - A Q_p Q_pp^-1 Q_p^T A^T,    Q_p the columns of its parameters.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from adjust.adjustment import Adjustment
from adjust.ap_models import ApModel, without
from adjust.bundle import remodelled
from adjust.quality.gross_errors import LEAST_CHECKED
from adjust.quality.influence import Influence
from adjust.quality.significance import ap_significance
from simfield.block import Floats, Indices

ALPHA = 0.05
CORRELATION_MOST = 0.999


def aic(a: Adjustment) -> float:
    """Akaike's criterion; the smallest is best."""
    n = a.observations
    return float(n * np.log(a.vpv / n) + 2 * (n - a.redundancy))


def bic(a: Adjustment) -> float:
    """Schwarz's criterion, harder on further parameters than Akaike's; the smallest is best."""
    n = a.observations
    return float(n * np.log(a.vpv / n) + (n - a.redundancy) * np.log(n))


@dataclass(frozen=True, eq=False)
class Prediction:
    """Leave-one-image-out: for each image (m) the sum of squared prediction errors, in a priori standard deviations,
    and the number of directions predicted."""

    squares: Floats
    count: Indices
    unit_weight_um: float

    @property
    def rms_um(self) -> float:
        """The prediction error of an image coordinate of unit weight, um."""
        return float(self.unit_weight_um * np.sqrt(self.squares.sum() / self.count.sum()))

    @property
    def by_image_um(self) -> Floats:
        """(m), NaN where nothing can be predicted."""
        share = np.where(self.count > 0, self.squares / np.maximum(self.count, 1), np.nan)
        return np.asarray(self.unit_weight_um * np.sqrt(share))


def leave_one_image_out(a: Adjustment) -> Prediction:
    """The prediction error of every image, in the linear model at the estimate. Raises ValueError after a failure."""
    influence = Influence.of(a)
    image, m, own_sets = a.block.observations.image, len(a.block.images), _OwnSets(a)
    squares, count = np.zeros(m), np.zeros(m, dtype=np.intp)
    for i in range(m):
        rows = (2 * np.flatnonzero(image == i)[:, None] + np.arange(2)).ravel()
        rows = rows[influence.rows.weight[rows] > 0.0]
        if not len(rows):
            continue
        standard, hat = influence.rows.standard[rows], influence.hat(rows, rows)
        own, mean = own_sets.of(i)
        if len(own):
            spread = influence.effect(rows, own)
            gain = np.linalg.solve(own_sets.a.cofactors.block(own, own), spread.T).T
            standard, hat = standard - gain @ (own_sets.a.x[own] - mean), hat - gain @ spread.T
        values, vectors = np.linalg.eigh(np.eye(len(rows)) - hat)
        predicted = values > LEAST_CHECKED
        projected = vectors[:, predicted].T @ standard
        squares[i], count[i] = np.sum((projected / values[predicted]) ** 2), int(predicted.sum())
    return Prediction(squares, count, a.unit_weight_um)


class _OwnSets:
    """The sets that single images have for themselves, and what those of the other images say of them."""

    def __init__(self, a: Adjustment) -> None:
        self.a = a.regular
        u = self.a.layout
        self.single = np.bincount(u.image_set, minlength=len(u.sets)) == 1
        self.camera = np.full(len(u.sets), -1)
        self.camera[u.image_set] = a.block.images.camera
        self.places = [np.arange(s.columns.start, s.columns.stop) for s in u.sets]
        self.weights = (
            [np.linalg.inv(self.a.cofactors.block(at, at)) for at in self.places] if self.single.any() else []
        )

    def of(self, image: int) -> tuple[Indices, Floats]:
        """The places in x of the parameters that no other image shares, and the weighted mean of the other sets of the
        camera; none where the camera has no other set of this model.
        """
        u = self.a.layout
        mine = int(u.image_set[image])
        model, alike = u.sets[mine].model, self.camera == self.camera[mine]
        others = [n for n in np.flatnonzero(alike) if n != mine and u.sets[n].model.parameters == model.parameters]
        if not self.single[mine] or not others or not model.parameters:
            return np.empty(0, dtype=np.intp), np.empty(0)
        right = sum(self.weights[n] @ self.a.x[self.places[n]] for n in others)
        return self.places[mine], np.asarray(np.linalg.solve(sum(self.weights[n] for n in others), right))


@dataclass(frozen=True)
class Deletion:
    """A parameter that was deleted, and why: its t and level, or its multiple correlation with the exterior
    orientation.
    """

    camera_id: str
    name: str
    t: float
    p: float
    with_exterior: float

    @property
    def reason(self) -> str:
        if self.with_exterior > CORRELATION_MOST:
            return f"cannot be told from the exterior orientation, multiple correlation {self.with_exterior:.5f}"
        return f"not significant, |t| = {abs(self.t):.2f}, p = {self.p:.3f}"


@dataclass(frozen=True, eq=False)
class Stepwise:
    """What was deleted, in this order, and the adjustment that is left."""

    deleted: tuple[Deletion, ...]
    adjustment: Adjustment


def delete_stepwise(a: Adjustment, alpha: float = ALPHA, correlation_most: float = CORRELATION_MOST) -> Stepwise:
    """Delete additional parameters one at a time and adjust again, until all that are left are needed.

    The rule: first the one with the highest multiple correlation with the exterior orientation, if above
    `correlation_most`; then the one with the smallest |t|, if its two-sided level exceeds alpha. Levels after a choice
    are no longer exact: of the noise parameters that remain, more than a share alpha may look significant.
    """
    if {s.id for s in a.layout.sets} - {c.camera_id for c in a.block.cameras}:
        raise ValueError("stepwise deletion needs one set of additional parameters a camera")
    deleted: list[Deletion] = []
    models: Mapping[str, ApModel] = {s.id: s.model for s in a.layout.sets}
    while (worst := _worst(a, alpha, correlation_most)) is not None:
        deleted.append(worst)
        models = {**models, worst.camera_id: without(models[worst.camera_id], worst.name)}
        a = remodelled(a, models)
        if not a.status.ok:
            raise ValueError(f"the block cannot be adjusted without {worst.name} of {worst.camera_id}: {a.message}")
    return Stepwise(tuple(deleted), a)


def _worst(a: Adjustment, alpha: float, correlation_most: float) -> Deletion | None:
    tested = []
    for s in a.layout.sets:
        found = ap_significance(a, s.id)
        columns = zip(found.names, found.t, found.p, found.with_exterior, strict=True)
        tested += [Deletion(s.id, name, float(t), float(p), float(r)) for name, t, p, r in columns]
    if not tested:
        return None
    highest = max(tested, key=lambda d: d.with_exterior)
    if highest.with_exterior > correlation_most:
        return highest
    weakest = min(tested, key=lambda d: abs(d.t))
    return weakest if weakest.p > alpha else None
