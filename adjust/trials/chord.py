"""Chord iteration for blocks of trials: the cofactors of one geometry, the exact gradient of every trial.

See adjust.trials.replicates for the idea. In units of standard deviations, y = (x - x_nominal) / s, one step is
y <- y - C (s g), with the correlation matrix C = Q / (s s^T). C is kept in single precision: the gradient is exact, so
rounding of the step only slows the contraction, to about 1e-6 a step at best.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from adjust.adjustment import Adjustment
from adjust.ap_models import ApModel
from adjust.bundle import adjust_block
from adjust.normals import Cofactors, Compiled
from adjust.observations import Observations
from adjust.solution import minimised
from adjust.status import Status
from adjust.trials import gradient_compiled as kernels, lane_copies_compiled as lane_copies
from adjust.trials.gradient_compiled import TILES
from adjust.trials.solved import CHORD, GAUSS_NEWTON, STATUSES, SolvedTrials
from adjust.trials.traced_terms import UntraceableError, compile_gradient
from adjust.trials.workspace import Workspace
from simfield.block import Block, Floats, ImageObservations, Points
from simfield.numerics import TOGETHER, WIDTH

ERROR_LEFT = 1e-8
"""bound of the error left in any unknown, in its standard deviations"""
SLOWER_MODES = 4.0
"""the first steps show how the bulk of the error contracts, its slowest part does so up to 3.6 times less (measured)"""
SMALL_STEP = 1e-9
"""a step this small ends the iteration whatever the contraction: rounding makes about 3e-11"""
CONTRACTION_MOST = 0.2
"""a trial that contracts less is left to full Gauss-Newton"""
STEPS_MOST = 8


@dataclass(frozen=True, eq=False)
class Chord:
    """What all trials share: the nominal adjustment, and of the unknowns that are free (f rows of x) their standard
    deviations s (f) and correlations C (f, f)."""

    nominal: Adjustment
    free: npt.NDArray[np.intp]
    s: Floats
    correlation: npt.NDArray[np.float32]
    exact_std: bool = False

    @classmethod
    def of(cls, block: Block, model: ApModel | Mapping[str, ApModel] | None, exact_std: bool = False) -> Chord:
        """Raises ValueError when the block itself cannot be adjusted."""
        nominal = adjust_block(block, model)
        if not nominal.status.ok:
            raise ValueError(f"the block has no nominal adjustment, {nominal.message}")
        cofactors = nominal.working_cofactors
        free = np.flatnonzero(cofactors.diagonal > 0.0)
        q = cofactors.block(free, free)
        s = np.sqrt(np.diag(q))
        return cls(nominal, free, s, (q / s / s[:, None]).astype(np.float32), exact_std)

    @cached_property
    def gradients(self) -> list[tuple[Callable[..., Any], npt.NDArray[np.uint64], int]] | None:
        """(compiled gradient, images, first row in x) of each AP set; None where one is not linear or not traceable."""
        layout = self.nominal.layout
        if not all(s.model.linear for s in layout.sets):
            return None
        try:
            return [
                (
                    compile_gradient(s.model),
                    np.flatnonzero(layout.image_set == number).astype(np.uint64),
                    int(s.columns.start),
                )
                for number, s in enumerate(layout.sets)
            ]
        except UntraceableError:
            return None

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name not in ("gradients", "linearised")}

    @cached_property
    def s_single(self) -> npt.NDArray[np.float32]:
        """s in single precision."""
        return self.s.astype(np.float32)

    @cached_property
    def indices(self) -> tuple[Any, Any, Any, Any]:
        """What the kernel wants to know of the image points: starts, point, weight, interior."""
        g = self.nominal.groups.image_points
        return g.starts.astype(np.uint64), g.point, g.weight, g.interior

    def solve(
        self, image_points: Any, coordinates: Floats | None, trials: slice, room: Workspace, solved: SolvedTrials
    ) -> None:
        """Solve at most TOGETHER trials of image_points (t, k, 2) and coordinates (t, n, 3; None: those of the block).

        room: made for these image points; solved: where the results go, as many trials.
        """
        count = trials.stop - trials.start
        coordinates = None if coordinates is None else coordinates[trials]
        vpv, iterations = np.full(TOGETHER, np.nan), np.zeros(TOGETHER, dtype=np.int16)
        converged = np.zeros(TOGETHER, dtype=bool)
        if self.gradients is not None:
            room.begin(trials)
            if coordinates is not None:
                self._give_coordinates(coordinates, room)
            ahead = self._step_ahead(room) if coordinates is None else np.full(TOGETHER, np.inf)
            converged = self._iterate(room, ahead, vpv, iterations, np.arange(TOGETHER) < count)
        lane_copies.untile(room.x, solved.x)
        solved.vpv[:], solved.iterations[:] = vpv[:count], iterations[:count]
        solved.status[:] = STATUSES.index(Status.CONVERGED)
        solved.route[:] = np.where(converged[:count], CHORD, GAUSS_NEWTON)
        left = range(count) if self.exact_std else np.flatnonzero(~converged[:count])
        for trial in left:
            at = trials.start + int(trial)
            xy_of_trial = np.asarray(image_points[at : at + 1], dtype=float)[0]
            groups, reduced = self._groups(xy_of_trial, None if coordinates is None else coordinates[trial])
            if not converged[trial]:
                self._finish(solved, int(trial), groups, reduced)
            if solved.cofactors is not None and STATUSES[solved.status[trial]].ok:
                compiled = Compiled(groups)
                factor = compiled.factorise(compiled.at(solved.x[trial]))
                solved.cofactors[trial] = Cofactors(self.nominal.layout, factor).diagonal

    def _give_coordinates(self, coordinates: Floats, room: Workspace) -> None:
        """The reduced given coordinates (t, n, 3) into room.given, and those held fixed into room.x and room.start."""
        layout = self.nominal.layout
        rows = np.ascontiguousarray(coordinates, dtype=float)
        lane_copies.give(rows, layout.origin, self.fixed, layout.orientation, room.given, room.start, room.x)

    @cached_property
    def renamed(self) -> npt.NDArray[np.bool_]:
        """(m): images with renamed axes."""
        layout = self.nominal.layout
        return np.zeros(len(layout.block.images), dtype=bool) if layout.renamed is None else layout.renamed

    @cached_property
    def fixed(self) -> npt.NDArray[np.bool_]:
        """(3n): point coordinates that are held fixed."""
        return self.nominal.layout.block.points.fixed.ravel()

    @cached_property
    def linearised(self) -> tuple[Any, ...]:
        """What `kernels.first_gradient` wants to know of the nominal trial."""
        layout, g = self.nominal.layout, self.nominal.groups.image_points
        at = g.jacobian(self.nominal.x)
        weight = g.weight[:, :, None]
        parameters = np.array([s.columns.start for s in layout.sets], dtype=np.intp)[layout.image_set]
        jacobian, by_point = (np.asarray(weight * j, dtype=np.float32) for j in (at.by_orientation, at.by_point))
        return layout.orientation, parameters, at.v, g.xy, jacobian, by_point

    def _step_ahead(self, room: Workspace) -> Floats:
        """A first step of all trials with the nominal derivatives, in single precision; returns the steps' lengths."""
        starts, point, _, _ = self.indices
        first, parameters, v, xy, jacobian, by_point = self.linearised
        kernels.first_gradient(starts, point, first, parameters, v, xy, jacobian, by_point, room.xy, room.first)
        np.multiply(room.first.reshape(-1, TOGETHER)[self.free], self.s_single[:, None], out=room.scaled)
        np.matmul(self.correlation, room.scaled, out=room.change)
        kernels.advance(room.change, np.ones((TILES, WIDTH)), self.free, self.s, room.start, room.y, room.x)
        length = np.empty(TOGETHER)
        kernels.longest(room.change, length)
        return length

    def _iterate(
        self,
        room: Workspace,
        before: Floats,
        vpv: Floats,
        iterations: npt.NDArray[np.int16],
        active: npt.NDArray[np.bool_],
    ) -> npt.NDArray[np.bool_]:
        """Iterate room.x in place; returns which trials have converged, and leaves their vPv and steps.

        before (TOGETHER): the length of a step that was already taken, infinite if none was.
        """
        converged = np.zeros(TOGETHER, dtype=bool)
        length, worst = np.empty(TOGETHER), np.zeros(TOGETHER)
        for step in range(1, STEPS_MOST + 1):
            cost, depth = self._gradient(room)
            kernels.scale(room.gradient, self.free, self.s, room.scaled)
            np.matmul(self.correlation, room.scaled, out=room.change)
            kernels.longest(room.change, length)
            active = active & (depth > 0.0) & np.isfinite(length)
            contraction = length / before
            if step > 1:
                active &= (contraction < CONTRACTION_MOST) | (length < SMALL_STEP)
            moving = active.astype(float).reshape(TILES, WIDTH)
            kernels.advance(room.change, moving, self.free, self.s, room.start, room.y, room.x)
            vpv[active], iterations[active] = cost[active], step
            # the first step measures a distance, not an error: nothing is known of the contraction yet
            worst = np.maximum(worst, contraction)
            next_one = np.minimum(SLOWER_MODES * worst, 0.5)
            left = length * next_one / (1.0 - next_one)
            done = active & ((left < ERROR_LEFT) & (step > 1) | (length < SMALL_STEP))
            converged |= done
            active &= ~done
            before = length.copy()
            if not active.any():
                break
        return converged

    def _gradient(self, room: Workspace) -> tuple[Floats, Floats]:
        """A^T P v at room.x into room.gradient; returns vPv (TOGETHER) and the least depth (TOGETHER)."""
        layout, x = self.nominal.layout, room.x
        room.gradient[:] = 0.0
        vpv, depth = np.zeros((TILES, WIDTH)), np.full((TILES, WIDTH), np.inf)
        assert self.gradients is not None
        for number, (compiled, members, first) in enumerate(self.gradients):
            contexts, sums = room.contexts[number], room.sums[number]
            kernels.fill_contexts(members, self.renamed, x, first, room.turns, contexts)
            compiled(members, *self.indices, contexts, layout.orientation, room.xy, x, sums, room.gradient)
            kernels.collect(members, self.renamed, sums, contexts, room.turns, first, room.gradient, vpv, depth)
        control = self.nominal.groups.control
        if len(control.columns):
            v = x[:, control.columns] - room.given[:, control.columns - layout.orientation]
            room.gradient[:, control.columns] += control.weight[:, None] * v
            vpv += control.weight @ v**2
        return vpv.ravel(), depth.ravel()

    def _groups(self, xy: Floats, coordinates: Floats | None) -> tuple[Observations, Floats]:
        """The observations of one trial, and the reduced given coordinates (3n) of its points."""
        layout = self.nominal.layout
        b, o = layout.block, layout.block.observations
        points = b.points if coordinates is None else Points(b.points.ids, b.points.role, coordinates, b.points.sigma)
        block = Block(b.cameras, b.images, points, ImageObservations(o.image, o.point, xy, o.sigma))
        return Observations.of(block, layout), (points.coordinates - layout.origin).ravel()

    def _finish(self, trials: SolvedTrials, trial: int, groups: Observations, reduced: Floats) -> None:
        """Solve one trial by full Gauss-Newton, from the nominal estimate, and write it into `trials`."""
        layout = self.nominal.layout
        start, fixed = self.nominal.x.copy(), layout.block.points.fixed.ravel()
        start[layout.orientation :][fixed] = reduced[fixed]
        solution = minimised(groups, start, Compiled(groups))
        trials.x[trial] = solution.x if solution.status.ok else np.nan
        trials.vpv[trial] = groups.cost(solution.x) if solution.status.ok else np.nan
        trials.status[trial] = STATUSES.index(solution.status)
        trials.iterations[trial] += solution.iterations
