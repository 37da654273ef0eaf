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
from adjust.observations import ApPriors, Distances, Group, Observations, stated_groups, unknowns_of
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
                "a free network cannot hold observed stations or height differences; take the datum by control, or "
                "leave them out"
            )
        block = datum.prepared(block, scaled=any(isinstance(group, Distances) for group in observations))
    except (initial.NoStartError, ValueError) as error:
        return _without_datum(block, model, str(error))
    sets = ap_sets(block, ap_by) if isinstance(ap_by, str) else ap_by
    unknowns = Unknowns.of(block, model, None if ap_by == "camera" else sets, names, _tied_points(observations))
    return datum.finished(_from_the_beginning(_bound(block, unknowns, observations), compiled))


def reweighted(a: Adjustment, weights: Floats, taken_out: int = 0) -> Adjustment:
    """The same adjustment with other weights, in the order of `a.groups.weights`, from its estimate on.

    weights (n) of all n observations are 1/sigma^2 of mm, m or rad. The datum stays what it is. A weight of 0 rejects
    an observation: it keeps a residual, but counts no more. taken_out: how many observations' worth of weight is taken
    away beside those, see `Observations`.
    """
    r = a.regular
    groups = r.groups.with_weights(weights, taken_out)
    with np.errstate(all="ignore"), one_thread():
        found = by_either(
            groups, isinstance(r.arithmetic, Compiled), lambda by: _answer(groups, minimised(groups, r.x, by), by)
        )
    return a.tied(found)


def remodelled(a: Adjustment, models: Mapping[str, ApModel]) -> Adjustment:
    """The same adjustment with other sets of additional parameters, one a camera, from the beginning.

    Datum, weights, further observations and arithmetic stay what they are; of the priors those whose parameters are
    left.
    """
    r = a.regular
    left = {(camera, name) for camera, model in models.items() for name in model.parameters}
    stated = [group.restricted(left) if isinstance(group, ApPriors) else group for group in r.groups.stated]
    unknowns = Unknowns.of(r.block, models, None, unknowns_of(stated, r.block), _tied_points(stated))
    groups = _bound(r.block, unknowns, stated)
    groups = groups.with_weights(_left_of(r.groups, groups), r.groups.taken_out)
    return a.tied(_from_the_beginning(groups, isinstance(r.arithmetic, Compiled)))


def _tied_points(observations: Sequence[Group]) -> list[str]:
    return [point for group in observations for point in group.coupled]


def _left_of(before: Observations, groups: Observations) -> Floats:
    """The weights that `groups` have in the observations before, of which some priors may have been left out."""
    kept = np.ones(before.rows, dtype=bool)
    labels = [label for group in before.further for label in group.labels]
    remaining = {label for group in groups.further for label in group.labels}
    kept[before.rows - len(labels) :] = [label in remaining for label in labels]
    return before.weights[kept]


# what is not finite ends with a status, not with a warning
def _bound(block: Block, unknowns: Unknowns, observations: Sequence[Group]) -> Observations:
    with np.errstate(all="ignore"):
        return Observations.of(block, unknowns, observations)


def _from_the_beginning(groups: Observations, compiled: bool) -> Adjustment:
    with np.errstate(all="ignore"), one_thread():
        return by_either(groups, compiled, lambda by: _told(reached(groups, by)))


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
