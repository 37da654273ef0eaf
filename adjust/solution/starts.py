"""From which start values the minimum is sought, and which of several minima is the answer.

Given orientations come first. Images without any get poses by resection, and where the known points leave several, the
minima tell which it was: what is seen from afar is as well turned inside out. Where given orientations lead nowhere, or
to residuals that nobody would believe, those of our own making are tried too; but an answer far from what was given is
none: then the given angles, units or axes are wrong, which is for people to know.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from adjust.model import Unknowns, rotation_matrices, steep
from adjust.normals import Arithmetic, Compiled, Plain
from adjust.observations import Observations
from adjust.solution import initial
from adjust.solution.damped import minimised
from adjust.solution.determinability import judged
from adjust.solution.iteration import Solution, solve
from adjust.status import Status
from simfield.block import Floats

PLACES = 4
"""starts that are tried where poses are left open"""
UNBELIEVABLE = 3.0
"""sigma0 beyond which orientations of our own making are tried beside the given ones"""
OTHER_MINIMUM = 0.5
"""share of vPv below which the minimum from them is another one, and not the same by another way"""
OF_OUR_OWN = "from orientations by resection, since those given lead elsewhere"
IMAGES_MOST = 50
"""of a block that is adjusted again from the beginning for this"""
NEAR_ANGLE, NEAR_SHARE = 0.5, 0.5
"""rad, and share of the distance to the points, by which a given orientation may be wrong"""
RENAMINGS_MOST = 3
"""how often an iteration that came to an image along the object's X axis is begun again there, by other angles"""


@dataclass(frozen=True, eq=False)
class Reached:
    """A solution, and the groups and the arithmetic in whose layout it is."""

    solution: Solution
    groups: Observations
    arithmetic: Arithmetic

    @property
    def vpv(self) -> float:
        return self.groups.cost(self.solution.x)


def reached(groups: Observations, arithmetic: Arithmetic) -> Reached:
    """The least minimum from all starts that are tried."""
    unknowns = groups.image_points.unknowns
    redundancy = groups.count - unknowns.count
    if redundancy <= 0:
        detail = f"{groups.count} observations for {unknowns.count} unknowns, redundancy {redundancy}"
        return _nowhere(groups, arithmetic, Status.TOO_LITTLE_REDUNDANCY, detail)
    exterior = unknowns.block.images.exterior
    some_open, all_open = (bool(f(np.isnan(exterior[:, 0]))) for f in (np.any, np.all))
    try:
        best = _least(groups, arithmetic, _starts(groups, True, PLACES if some_open else 1))
    except initial.NoStartError as error:
        best = _nowhere(groups, arithmetic, Status.NO_START, str(error))
    if some_open:
        best = _finished(best)
    singular_start = best.solution.status is Status.SINGULAR and best.solution.iterations <= 1
    if all_open or len(exterior) > IMAGES_MOST or singular_start:
        return best
    if best.solution.status.ok and best.vpv <= UNBELIEVABLE**2 * redundancy:
        return best
    try:
        other = _least(groups, arithmetic, _starts(groups, False, PLACES))
    except initial.NoStartError:
        return best
    if best.solution.status.ok:
        taken = other.vpv <= OTHER_MINIMUM * best.vpv and _is_believed(other.groups, other.solution.x)
    else:
        taken = _is_near(other.groups.image_points.unknowns, other.solution.x)
    if not (other.solution.status.ok and taken):
        return best
    done = _finished(other)
    return replace(done, solution=replace(done.solution, detail=OF_OUR_OWN))


def _starts(groups: Observations, given: bool, places: int) -> Iterator[Floats]:
    """Different start values, the best first. Raises NoStartError where there are none."""
    before: Floats | None = None
    for place in range(places):
        try:
            x = initial.values(groups.image_points.unknowns, groups.image_points, place, given)
        except initial.NoStartError:
            if place == 0:
                raise
            return
        if before is not None and np.array_equal(x, before):
            return
        before = x.copy()
        yield x


def _least(groups: Observations, arithmetic: Arithmetic, starts: Iterator[Floats]) -> Reached:
    best = _from(next(starts), groups, arithmetic)
    for x in starts:
        found = _from(x, groups, arithmetic)
        if found.solution.status.ok and not (best.solution.status.ok and best.vpv <= found.vpv):
            best = found
    return best


def _from(x: Floats, groups: Observations, arithmetic: Arithmetic) -> Reached:
    """The solution from a start x, in the layout of `groups`."""
    unknowns = groups.image_points.unknowns
    for _ in range(RENAMINGS_MOST):
        layout, x = unknowns.with_renamed(x)
        if layout.renamed is not None:
            again = Observations.of(layout.block, layout, groups.stated)
            unknowns, groups = layout, again.with_weights(groups.weights, groups.taken_out)
            arithmetic = Compiled(groups) if isinstance(arithmetic, Compiled) else Plain(groups)
        solution = minimised(groups, x, arithmetic, partial(_is_believed, groups))
        solution = judged(solution, unknowns, arithmetic)
        x = solution.x
        if solution.status.ok or not np.isfinite(x).all() or not steep(unknowns.exterior(x)[:, 3:]).any():
            break
    return Reached(solution, groups, arithmetic)


def _is_believed(groups: Observations, x: Floats) -> bool:
    """Whether a minimum may be the answer, seen from the orientations that were given.

    Where all observations fit and yet the images look or stand elsewhere, something is wrong with the given angles,
    their units or the axes, and that is to be said, not to be healed. Where they do not fit, as with exchanged control,
    the minimum is what shows which.
    """
    unknowns = groups.image_points.unknowns
    return groups.cost(x) > UNBELIEVABLE**2 * (groups.count - unknowns.count) or _is_near(unknowns, x)


def _is_near(unknowns: Unknowns, x: Floats) -> bool:
    """Whether the images that were given an orientation still look and stand about as they were said to."""
    given = unknowns.block.images.exterior
    seen = np.isfinite(given[:, 0])
    if not seen.any():
        return True
    found = unknowns.exterior(unknowns.told(x))[seen]
    turned = rotation_matrices(found[:, 3:]).transpose(0, 2, 1) @ rotation_matrices(given[seen, 3:])
    angle = np.arccos(np.clip((np.trace(turned, axis1=1, axis2=2) - 1.0) / 2.0, -1.0, 1.0))
    moved = np.linalg.norm(found[:, :3] + unknowns.origin - given[seen, :3], axis=1)
    middle = np.median(unknowns.points(x), axis=0)
    away = np.linalg.norm(found[:, :3] - middle, axis=1)
    return bool((angle < NEAR_ANGLE).all() and (moved < NEAR_SHARE * away).all())


def _finished(found: Reached) -> Reached:
    """The same minimum once more from itself: a way from afar may end on a step that promised more than it kept."""
    if not found.solution.status.ok:
        return found
    again = solve(found.groups, found.solution.x, found.arithmetic)
    steps = found.solution.iterations + again.iterations
    return replace(found, solution=replace(again, iterations=steps)) if again.status.ok else found


def _nowhere(groups: Observations, arithmetic: Arithmetic, status: Status, detail: str) -> Reached:
    nothing = np.full(len(groups.image_points.unknowns.free), np.nan)
    return Reached(Solution(nothing, status, detail, 0), groups, arithmetic)
