"""The bundle adjustment, told as a story."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from adjust.adjustment import Adjustment
from adjust.ap_models import ApModel
from adjust.ap_models.catalogue import NoModel
from adjust.datum import ByControl, Datum
from adjust.model import ApBy, Unknowns, ap_sets
from adjust.normals import Arithmetic, Compiled, Plain, by_either
from adjust.observations import Group, Observations, stated_groups, unknowns_of
from adjust.solution import Reached, Solution, initial, minimised, reached
from adjust.status import Status
from simfield.block import Block, Floats
from simfield.numerics import one_thread


def adjust_block(
    block: Block,
    model: ApModel | Mapping[str, ApModel] | None = None,
    *,
    datum: Datum | None = None,
    observations: Sequence[Group] = (),
    ap_by: ApBy | Mapping[str, str] = "camera",
    compiled: bool = True,
) -> Adjustment:
    """Adjust a block by bundles, with one set of additional parameters a camera, or as ap_by says.

    model is one AP model for all cameras (None: no additional parameters) or a mapping from camera id to model. The
    result's `status` says whether the adjustment succeeded; nothing is raised for data that cannot be adjusted. Raises
    KeyError for a mapping without one of the cameras. datum says what ties the block to its frame (adjust.datum), the
    control of the block by default. The further observations of the block are used; observations are other groups
    (adjust.observations.stations, adjust.observations.ap_priors); ValueError or KeyError for those that do not fit
    the block or the model. ap_by says whose AP sets there are (adjust.model.set_owners): those of cameras, flights,
    strips or images, or a mapping from image ids to set ids; ValueError if images of two cameras share one or ids
    name no flight or strip, KeyError for an image that a mapping lacks. compiled=False takes the readable arithmetic
    in plain numpy, with the same result; it is taken in any case where an observation lies between two images.

    Least squares of measured + v = projected + d(measured) with weights 1/sigma^2, by Gauss-Newton with the points
    eliminated (Triggs et al. 2000, Bundle adjustment - a modern synthesis, sections 4 and 6).
    """
    datum = ByControl() if datum is None else datum
    model = NoModel() if model is None else model
    observations = (*stated_groups(block, model), *observations)
    names = unknowns_of(observations, block)
    try:
        if not isinstance(datum, ByControl) and any(group.ties_datum for group in observations):
            raise ValueError(
                "a free network cannot hold observed stations, distances or heights; take the datum by control, or "
                "leave them out"
            )
        block = datum.prepared(block)
    except (initial.NoStartError, ValueError) as error:
        return _without_datum(block, model, str(error))
    sets = ap_sets(block, ap_by) if isinstance(ap_by, str) else ap_by
    tied = [point for group in observations for point in group.coupled]
    unknowns = Unknowns.of(block, model, None if ap_by == "camera" else sets, names, tied)
    # what is not finite ends with a status, not with a warning
    with np.errstate(all="ignore"), one_thread():
        groups = Observations.of(block, unknowns, observations)
        return datum.finished(by_either(groups, compiled, lambda by: _told(reached(groups, by, observations))))


def reweighted(a: Adjustment, weights: Floats) -> Adjustment:
    """The same adjustment with other weights, from its estimate on; weights in the order of `a.groups.weights`.

    A weight of 0 rejects an observation: it keeps a residual, but counts no more.
    """
    groups = a.groups.with_weights(weights)
    with np.errstate(all="ignore"), one_thread():
        return by_either(
            groups, isinstance(a.arithmetic, Compiled), lambda by: _answer(groups, minimised(groups, a.x, by), by)
        )


def _answer(groups: Observations, solution: Solution, arithmetic: Arithmetic) -> Adjustment:
    sentence = solution.status.value + (f": {solution.detail}" if solution.detail else "")
    u = groups.image_points.unknowns
    return Adjustment(u.block, u, groups, solution.x, solution.status, sentence, solution.iterations, arithmetic)


def _told(r: Reached) -> Adjustment:
    return _answer(r.groups, r.solution, r.arithmetic)


def _without_datum(block: Block, model: ApModel | Mapping[str, ApModel], why: str) -> Adjustment:
    unknowns = Unknowns.of(block, model)
    groups = Observations.of(block, unknowns)
    return _answer(groups, Solution(np.full(len(unknowns.free), np.nan), Status.NO_START, why, 0), Plain(groups))
