"""The bundle adjustment, told as a story."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from adjust import initial
from adjust.adjustment import Adjustment
from adjust.ap_models.mauelshagen import NoModel
from adjust.ap_models.model import ApModel
from adjust.observations import Observations
from adjust.solve import Solution, solve
from adjust.status import Status
from adjust.unknowns import Unknowns
from simfield.block import Block


def adjust_block(block: Block, model: ApModel | Mapping[str, ApModel] | None = None) -> Adjustment:
    """Adjust a block by bundles, with one set of additional parameters a camera.

    model is one AP model for all cameras (None: no additional parameters) or a mapping from camera id to model. The
    result's `status` says whether the adjustment succeeded; nothing is raised for data that cannot be adjusted. Raises
    KeyError for a mapping without one of the cameras.

    Least squares of measured + v = projected + d(measured) with weights 1/sigma^2, by Gauss-Newton with the points
    eliminated (Triggs et al. 2000, Bundle adjustment - a modern synthesis, sections 4 and 6).
    """
    unknowns = Unknowns.of(block, NoModel() if model is None else model)
    with np.errstate(all="ignore"):  # what is not finite ends with a status, not with a warning
        groups = Observations.of(block, unknowns)
        solution = _checked_solution(unknowns, groups)
    sentence = solution.status.value + (f": {solution.detail}" if solution.detail else "")
    return Adjustment(
        block, unknowns, groups, solution.x, solution.status, sentence, solution.iterations, solution.factor
    )


def _checked_solution(unknowns: Unknowns, groups: Observations) -> Solution:
    nothing = np.full(len(unknowns.free), np.nan)
    redundancy = groups.count - unknowns.count
    if redundancy <= 0:
        detail = f"{groups.count} observations for {unknowns.count} unknowns, redundancy {redundancy}"
        return Solution(nothing, None, None, Status.TOO_LITTLE_REDUNDANCY, detail, 0)
    try:
        start = initial.values(unknowns, groups.image_points)
    except initial.NoStartError as error:
        return Solution(nothing, None, None, Status.NO_START, str(error), 0)
    return solve(groups, start)
