"""Thousands of trials of one geometry.

Noise moves the estimates by a few standard deviations, so one factorisation at the nominal geometry serves all trials:
every trial iterates x <- x - Q g(x) with the cofactors Q of the nominal adjustment and its own exact gradient
g = A^T P v (adjust.trials.chord). This contracts about a thousandfold a step, and ends where g vanishes, which is
where full Gauss-Newton ends. A trial has converged when the error left, bounded by the last step and the contraction
observed, is below 1e-8 standard deviations for every unknown. A trial that does not contract is finished by full
Gauss-Newton.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import joblib
import numpy as np
import numpy.typing as npt

from adjust.adjustment import Adjustment
from adjust.ap_models import ApModel
from adjust.status import Status
from adjust.trials.chord import Chord
from adjust.trials.solved import GAUSS_NEWTON, STATUSES, SolvedTrials
from adjust.trials.workspace import Workspace
from simfield.block import Block, Floats
from simfield.numerics import TOGETHER, Arena, one_thread

TASK = 16 * TOGETHER
"""trials a task: fixed, so that a trial's neighbours are the same for any number of jobs"""


class ImagePointTrials(Protocol):
    """Image coordinates of many trials: an array (t, k, 2), or an object that draws such slices on demand.

    An object that also has `only(rows)`, the same trials with these observations in this order, and `fill_lanes(trials,
    lanes)` is asked to write trial number t of a slice into lane t % 8 of tile t // 8 of lanes (tiles, k, 2, 8).
    """

    def __len__(self) -> int: ...

    def __getitem__(self, trials: slice, /) -> Floats: ...


@dataclass(frozen=True, eq=False)
class Replicates:
    """Estimates of t trials; those of trials that failed are NaN.

    nominal: the adjustment of the block itself, whose cofactors serve all trials; trials: the estimates in the layout
    of `nominal.layout`, with the status and the route of every trial.
    """

    nominal: Adjustment
    trials: SolvedTrials

    def __len__(self) -> int:
        return len(self.trials.x)

    @property
    def status(self) -> list[Status]:
        """How each trial ended."""
        return [STATUSES[code] for code in self.trials.status]

    @property
    def ok(self) -> npt.NDArray[np.bool_]:
        """(t) the trials that converged."""
        return np.asarray(self.trials.status == STATUSES.index(Status.CONVERGED))

    @property
    def iterations(self) -> npt.NDArray[np.int16]:
        """(t) the number of steps that each trial took."""
        return self.trials.iterations

    @property
    def finished_by_gauss_newton(self) -> int:
        """The number of trials that the chord iteration left to full Gauss-Newton."""
        return int(np.sum(self.trials.route == GAUSS_NEWTON))

    @property
    def sigma0(self) -> Floats:
        """(t) sqrt(vPv / redundancy), free of unit."""
        return np.asarray(np.sqrt(self.trials.vpv / self.nominal.redundancy))

    @property
    def m0_um(self) -> Floats:
        """(t) sigma0 times the standard deviation of unit weight, um."""
        return self.sigma0 * self.nominal.unit_weight_um

    @property
    def x(self) -> Floats:
        """(t, size) the estimates in layout and units of `nominal.layout`, m and rad, the angles as people see them."""
        return self.nominal.layout.told(self.trials.x)

    @property
    def images(self) -> Floats:
        """(t, m, 6) exterior orientations, m and rad."""
        images = (
            self.x[:, : 6 * len(self.nominal.block.images)].reshape(len(self), len(self.nominal.block.images), 6).copy()
        )
        images[:, :, :3] += self.nominal.layout.origin
        return images

    @property
    def points(self) -> Floats:
        """(t, n, 3) adjusted coordinates, m."""
        reduced = self.trials.x[:, self.nominal.layout.orientation :].reshape(
            len(self), len(self.nominal.block.points), 3
        )
        return np.asarray(reduced + self.nominal.layout.origin)

    def ap(self, set_id: str) -> Floats:
        """(t, a) the additional parameters of a camera, in the units of `ApEstimate`.

        Raises KeyError for an id that has none.
        """
        for s in self.nominal.layout.sets:
            if s.id == set_id:
                return self.trials.x[:, s.columns]
        raise KeyError(f"no additional parameters of {set_id!r} in this adjustment")

    @property
    def std(self) -> Floats:
        """(t, size) formal standard deviations: each trial's sigma0 times the root of the cofactors, in the units of x.

        The cofactors are those of each trial where `exact_std` was asked for, else the nominal ones for all, which is
        good to about 2e-4.
        """
        q = self.nominal.cofactors.diagonal if self.trials.cofactors is None else self.trials.cofactors
        return np.asarray(self.sigma0[:, None] * np.sqrt(q))


def adjust_replicates(
    block: Block,
    model: ApModel | Mapping[str, ApModel] | None,
    image_points: ImagePointTrials,
    *,
    coordinates: Floats | None = None,
    exact_std: bool = False,
    jobs: int = 1,
) -> Replicates:
    """Adjust t trials that share the geometry of `block`.

    image_points (t, k, 2), mm, in the order of the block's observations: an array, or an object with a length whose
    slices are such arrays. coordinates (t, n, 3), m: the given coordinates of the points in every trial, where control
    is disturbed too; None: those of the block. exact_std: also the cofactors of every trial, which costs as much as
    adjusting it singly. jobs: processes; the result does not depend on their number.

    Returns what `adjust_block` finds for every trial, to 1e-8 standard deviations of every unknown. Trials with a set
    that is not linear are all solved by full Gauss-Newton, and `finished_by_gauss_newton` counts them. Raises
    ValueError when the block itself cannot be adjusted or shapes do not fit.
    """
    _check_shapes(block, image_points, coordinates)
    return adjust_prepared(
        prepared(block, model, exact_std=exact_std), image_points, coordinates=coordinates, jobs=jobs
    )


def prepared(block: Block, model: ApModel | Mapping[str, ApModel] | None, *, exact_std: bool = False) -> Chord:
    """What all trials of a geometry share, for several calls of `adjust_prepared`: the adjustment of the block itself
    and its cofactors. Raises ValueError when the block cannot be adjusted.
    """
    with one_thread():
        return Chord.of(block, model, exact_std)


def adjust_prepared(
    chord: Chord,
    image_points: ImagePointTrials,
    *,
    coordinates: Floats | None = None,
    jobs: int = 1,
    arena: Arena | None = None,
) -> Replicates:
    """`adjust_replicates` for a geometry that has been prepared. Raises ValueError where shapes do not fit.

    arena: memory to compute in, for a caller that comes again and again; it is taken anew in every call.
    """
    count = len(image_points)
    _check_shapes(chord.nominal.block, image_points, coordinates)
    tasks = [slice(first, min(first + TASK, count)) for first in range(0, count, TASK)]
    if jobs == 1 or len(tasks) <= 1:
        trials = SolvedTrials.empty(count, len(chord.nominal.x), chord.exact_std)
        room = _workspace(chord, image_points, arena)
        for task in tasks:
            _solve(chord, image_points, coordinates, task, room, trials.part(task))
    else:
        trials = SolvedTrials.joined(
            joblib.Parallel(n_jobs=jobs)(
                joblib.delayed(_solved)(chord, *_portion(image_points, coordinates, task)) for task in tasks
            )
        )
    return Replicates(chord.nominal, trials)


def _check_shapes(block: Block, image_points: ImagePointTrials, coordinates: Floats | None) -> None:
    if block.further:
        raise ValueError("trials know image points and control only; leave the others out: block.without()")
    k, n = len(block.observations), len(block.points)
    shape = np.shape(image_points[0:1])
    if len(shape) != 3 or shape[1:] != (k, 2):
        raise ValueError(f"image_points: a slice has shape {shape}, needed is (t, {k}, 2)")
    if coordinates is not None and coordinates.shape != (len(image_points), n, 3):
        raise ValueError(f"coordinates has shape {coordinates.shape}, needed is ({len(image_points)}, {n}, 3)")


def _portion(
    image_points: ImagePointTrials, coordinates: Floats | None, task: slice
) -> tuple[ImagePointTrials, Floats | None, slice]:
    """What travels to another process: arrays are cut to the task, objects that draw go whole and draw over there."""
    if isinstance(image_points, np.ndarray):
        cut = None if coordinates is None else coordinates[task]
        return image_points[task], cut, slice(0, task.stop - task.start)
    return image_points, coordinates, task


def _solved(chord: Chord, image_points: ImagePointTrials, coordinates: Floats | None, task: slice) -> SolvedTrials:
    """Some trials, in another process."""
    trials = SolvedTrials.empty(task.stop - task.start, len(chord.nominal.x), chord.exact_std)
    _solve(chord, image_points, coordinates, task, _workspace(chord, image_points), trials)
    return trials


def _workspace(chord: Chord, image_points: ImagePointTrials, arena: Arena | None = None) -> Workspace:
    arena = arena or Arena()
    arena.take_back()
    return Workspace.of(chord.nominal, len(chord.free), image_points, arena)


def _solve(
    chord: Chord,
    image_points: ImagePointTrials,
    coordinates: Floats | None,
    task: slice,
    room: Workspace,
    trials: SolvedTrials,
) -> None:
    """Solve some trials in blocks of TOGETHER, into `trials`."""
    with one_thread():
        for first in range(task.start, task.stop, TOGETHER):
            block = slice(first, min(first + TOGETHER, task.stop))
            into = trials.part(slice(block.start - task.start, block.stop - task.start))
            chord.solve(image_points, coordinates, block, room, into)
