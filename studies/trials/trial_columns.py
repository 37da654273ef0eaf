"""What is kept of every trial: deviations from the truth and tracked estimates, for many trials at once.

The estimand of an image or a point is the truth. That of an additional parameter is what the same adjustment finds
without any noise: where the model holds the true distortion this is its true coefficient, elsewhere no other value is
defined. What a wrong model does to the field is seen at the points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

from adjust import Adjustment, correlations
from adjust.model import EXTERIOR_NAMES, POINT_NAMES
from adjust.trials import STATUSES, Replicates
from simfield.block import Floats
from studies.comparison import CONFIDENCE
from studies.store import CODES, DEVIATIONS, OTHER, POINT_LABELS
from studies.trials.parts import MethodBlock
from studies.trials.trial_columns_compiled import point_deviations

Codes = npt.NDArray[np.int8]

_CODE_OF = np.array([CODES.get(status, OTHER) for status in STATUSES], dtype=np.int8)


@dataclass(frozen=True, eq=False)
class Tracked:
    """Unknowns that are followed one by one: names, their places in x, and their estimands."""

    names: tuple[str, ...]
    at: npt.NDArray[np.intp]
    estimand: Floats

    @classmethod
    def of(cls, nominal: Adjustment, part: MethodBlock) -> Tracked:
        """All additional parameters; of every camera the image nearest to the centre of the field, as "ww.Z0"; and the
        points nearest to the centre and farthest from it, as "centre.Z" and "edge.Z".
        """
        names, at, estimand = [], [], []
        layout = nominal.layout
        for s in layout.sets:
            names += [f"{s.id}.{name}" for name in s.model.parameters]
            at += list(range(s.columns.start, s.columns.stop))
            estimand += nominal.x[s.columns].tolist()
        origin = np.array([*layout.origin, 0.0, 0.0, 0.0])
        centre = 0.5 * (part.true[:, :2].min(axis=0) + part.true[:, :2].max(axis=0))
        for camera, image in _middle_images(part, centre).items():
            names += [f"{camera}.{name}" for name in EXTERIOR_NAMES]
            at += [6 * image + i for i in range(6)]
            estimand += (part.exterior[image] - origin).tolist()
        for label, point in _two_points(part, centre).items():
            names += [f"{label}.{name}" for name in POINT_NAMES]
            at += [layout.orientation + 3 * point + i for i in range(3)]
            estimand += (part.true[point] - layout.origin).tolist()
        return cls(tuple(names), np.array(at, dtype=np.intp), np.array(estimand))


def _middle_images(part: MethodBlock, centre: Floats) -> dict[str, int]:
    distance = np.hypot(*(part.exterior[:, :2] - centre).T)
    found = {}
    for number, camera in enumerate(part.block.camera_ids):
        own = np.flatnonzero(part.block.images.camera == number)
        if own.size:
            found[camera] = int(own[np.argmin(distance[own])])
    return found


def _two_points(part: MethodBlock, centre: Floats) -> dict[str, int]:
    free = np.flatnonzero(part.block.points.role != "control")
    if not free.size:
        return {}
    distance = np.hypot(*(part.true[free, :2] - centre).T)
    return dict(zip(POINT_LABELS, (int(free[np.argmin(distance)]), int(free[np.argmax(distance)])), strict=True))


def nominal_columns(nominal: Adjustment, tracked: Tracked) -> dict[str, Floats]:
    """The constants of a method, and of every tracked unknown its estimand, the root s of its cofactor and its formal
    correlations with all of them, one below the other. The estimand is reduced as x is.
    """
    q = nominal.cofactors.block(tracked.at, tracked.at)
    s, formal = np.sqrt(np.diag(q)), correlations(q)
    condition_number = 1.0 / nominal.cofactors.factor.condition
    constants = (nominal.redundancy, nominal.unit_weight_um, nominal.m0_um)
    more = (nominal.observations, condition_number, _largest_with_exterior(nominal))
    found: dict[str, Floats] = {"constants": np.array([*constants, *more], dtype=float)}
    for number, name in enumerate(tracked.names):
        found[name] = np.concatenate([[tracked.estimand[number], s[number]], formal[number]])
    return found


def _largest_with_exterior(nominal: Adjustment) -> float:
    exterior = np.arange(6 * len(nominal.block.images))
    ap = np.arange(len(exterior), nominal.layout.orientation)
    if not len(ap):
        return float("nan")
    std = np.sqrt(nominal.cofactors.diagonal)
    r = nominal.cofactors.block(exterior, ap) / std[exterior, None] / std[ap]
    return float(np.abs(r).max())


def trial_columns(
    replicates: Replicates, part: MethodBlock, tracked: Tracked, given: Floats
) -> dict[str, npt.NDArray[np.generic]]:
    """The columns of t trials; given (t or 1, n', 3) are the coordinates of the points that the surveyor gave, m."""
    nominal, layout = replicates.nominal, replicates.nominal.layout
    role = part.block.points.role
    q = nominal.cofactors.diagonal[layout.orientation :].reshape(-1, 3)
    t = stdtrit(nominal.redundancy, 0.5 + CONFIDENCE / 2.0)
    x, ok = replicates.x, replicates.ok
    found = np.empty((len(DEVIATIONS) - 1, len(x)))
    point_deviations(
        *(x, layout.orientation, part.true - layout.origin, given, layout.origin, role != "control", role == "check"),
        *(t * replicates.sigma0, np.sqrt(q), found),
    )
    found[:5] *= 1000.0
    found[:, ~ok] = np.nan
    columns: dict[str, npt.NDArray[np.generic]] = {"status": status_codes(replicates), "m0_um": replicates.m0_um}
    columns.update(zip(DEVIATIONS[1:], found, strict=True))
    columns.update(zip(tracked.names, np.ascontiguousarray(x[:, tracked.at].T), strict=True))
    return columns


def status_codes(replicates: Replicates) -> Codes:
    """(t) how every trial ended, in CODES."""
    return _CODE_OF[replicates.trials.status]
