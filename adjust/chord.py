"""Chord iteration for blocks of trials: the cofactors of one geometry, the exact gradient of every trial.

See adjust.replicates for the idea. In units of standard deviations, y = (x - x_nominal) / s, one step is
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

from adjust import kernels
from adjust.adjustment import Adjustment
from adjust.ap_models.model import ApModel
from adjust.bundle import adjust_block
from adjust.compiled_normals import Compiled
from adjust.kernels import LANES
from adjust.observations import Observations
from adjust.precision import Cofactors
from adjust.solve import solve
from adjust.status import Status
from adjust.traced_terms import UntraceableError, compile_gradient
from simfield.block import Block, Floats, ImageObservations, Points

ERROR_LEFT = 1e-8
"""bound of the error left in any unknown, in its standard deviations"""
SLOWER_MODES = 4.0
"""the first steps show how the bulk of the error contracts, its slowest part does so up to 3.6 times less (measured)"""
SMALL_STEP = 1e-9
"""a step this small ends the iteration whatever the contraction: rounding makes about 3e-11"""
CONTRACTION_MOST = 0.2
"""a trial that contracts less is left to full Gauss-Newton"""
STEPS_MOST = 8
STATUSES = tuple(Status)
CHORD, GAUSS_NEWTON = 0, 1
"""routes by which a trial can be solved"""


@dataclass(frozen=True, eq=False)
class Trials:
    """Solved trials: x (t, size), vPv (t), status (t) indices into STATUSES, iterations (t), route (t).

    cofactors (t, size): the cofactor of every unknown in every trial, None where nobody asked for them.
    """

    x: Floats
    vpv: Floats
    status: npt.NDArray[np.int8]
    iterations: npt.NDArray[np.int16]
    route: npt.NDArray[np.int8]
    cofactors: Floats | None = None

    @classmethod
    def joined(cls, parts: list[Trials], size: int) -> Trials:
        if not parts:
            return cls(np.empty((0, size)), np.empty(0), np.empty(0, "i1"), np.empty(0, "i2"), np.empty(0, "i1"))
        names = ("x", "vpv", "status", "iterations", "route")
        cofactors = [p.cofactors for p in parts if p.cofactors is not None]
        joined = {name: np.concatenate([getattr(p, name) for p in parts]) for name in names}
        return cls(**joined, cofactors=np.concatenate(cofactors) if cofactors else None)


@dataclass(frozen=True, eq=False)
class Chord:
    """What all trials share: the nominal adjustment, the standard deviations s (size, 0 for what is fixed), and C."""

    nominal: Adjustment
    s: Floats
    correlation: npt.NDArray[np.float32]
    exact_std: bool = False

    @classmethod
    def of(cls, block: Block, model: ApModel | Mapping[str, ApModel] | None, exact_std: bool = False) -> Chord:
        """Raises ValueError when the block itself cannot be adjusted."""
        nominal = adjust_block(block, model)
        if not nominal.status.ok:
            raise ValueError(f"the block has no nominal adjustment, {nominal.message}")
        everything = np.arange(len(nominal.x))
        q = nominal.cofactors.block(everything, everything)
        s = np.sqrt(np.diag(q))
        inverse = np.divide(1.0, s, out=np.zeros_like(s), where=s > 0.0)
        return cls(nominal, s, np.asarray(q * inverse * inverse[:, None], dtype=np.float32), exact_std)

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
    def indices(self) -> tuple[Any, Any, Any, Any]:
        """What the kernel wants to know of the image points: starts, point, weight, interior."""
        g = self.nominal.groups.image_points
        return g.starts.astype(np.uint64), g.point.astype(np.uint64), g.weight, g.interior

    def solve(self, image_points: Any, coordinates: Floats | None, trials: slice, room: Workspace) -> Trials:
        """Solve at most LANES trials of image_points (t, k, 2) and coordinates (t, n, 3; None: those of the block)."""
        count = trials.stop - trials.start
        coordinates = None if coordinates is None else coordinates[trials]
        vpv, iterations = np.full(LANES, np.nan), np.zeros(LANES, dtype=np.int16)
        converged = np.zeros(LANES, dtype=bool)
        room.x[:] = room.start[:] = self.nominal.x[:, None]
        room.y[:] = 0.0
        if self.gradients is not None:
            _fill_lanes(image_points, trials, self.nominal.groups.image_points.order, room.xy)
            self._give_coordinates(coordinates, room)
            ahead = self._step_ahead(room) if coordinates is None else np.full(LANES, np.inf)
            converged = self._iterate(room, ahead, vpv, iterations, np.arange(LANES) < count)
        solved = Trials(
            np.ascontiguousarray(room.x[:, :count].T),
            vpv[:count],
            np.full(count, STATUSES.index(Status.CONVERGED), dtype=np.int8),
            iterations[:count],
            np.where(converged[:count], CHORD, GAUSS_NEWTON).astype(np.int8),
            np.full((count, len(self.s)), np.nan) if self.exact_std else None,
        )
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
        return solved

    def _give_coordinates(self, coordinates: Floats | None, room: Workspace) -> None:
        """The reduced given coordinates into room.given, and those held fixed into room.x."""
        layout = self.nominal.layout
        source = layout.block.points.coordinates[None] if coordinates is None else coordinates
        rows = (source - layout.origin).reshape(len(source), -1).T
        room.given[:, : len(source)] = rows
        room.given[:, len(source) :] = rows[:, :1]
        fixed = layout.block.points.fixed.ravel()
        room.x[layout.orientation :][fixed] = room.start[layout.orientation :][fixed] = room.given[fixed]

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
        kernels.first_gradient(starts, point, first, parameters, v, xy, jacobian, by_point, room.xy, room.scaled)
        np.multiply(room.scaled, self.s[:, None], out=room.scaled, casting="same_kind")
        np.matmul(self.correlation, room.scaled, out=room.change)
        kernels.advance(room.change, np.ones(LANES), self.s, room.start, room.y, room.x)
        length = np.empty(LANES)
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

        before (LANES): the length of a step that was already taken, infinite if none was.
        """
        converged = np.zeros(LANES, dtype=bool)
        length, worst = np.empty(LANES), np.zeros(LANES)
        for step in range(1, STEPS_MOST + 1):
            cost, depth = self._gradient(room)
            kernels.scale(room.gradient, self.s, room.scaled)
            np.matmul(self.correlation, room.scaled, out=room.change)
            kernels.longest(room.change, length)
            active = active & (depth > 0.0) & np.isfinite(length)
            contraction = length / before
            if step > 1:
                active &= (contraction < CONTRACTION_MOST) | (length < SMALL_STEP)
            kernels.advance(room.change, active, self.s, room.start, room.y, room.x)
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
        """A^T P v at room.x into room.gradient; returns vPv (LANES) and the least depth (LANES)."""
        layout, x = self.nominal.layout, room.x
        images = len(layout.block.images)
        angles = x[: 6 * images].reshape(images, 6, LANES)[:, 3:]
        np.sin(angles, out=room.sine)
        np.cos(angles, out=room.cosine)
        room.gradient[:] = 0.0
        vpv, depth = np.zeros(LANES), np.full(LANES, np.inf)
        assert self.gradients is not None
        for number, (compiled, members, first) in enumerate(self.gradients):
            contexts, sums = room.contexts[number], room.sums[number]
            kernels.fill_contexts(members, room.sine, room.cosine, x, first, contexts)
            compiled(members, *self.indices, contexts, layout.orientation, room.xy, x, sums, room.gradient)
            kernels.collect(members, sums, contexts, room.sine, room.cosine, first, room.gradient, vpv, depth)
        control = self.nominal.groups.control
        if len(control.columns):
            v = x[control.columns] - room.given[control.columns - layout.orientation]
            room.gradient[control.columns] += control.weight[:, None] * v
            vpv += control.weight @ v**2
        return vpv, depth

    def _groups(self, xy: Floats, coordinates: Floats | None) -> tuple[Observations, Floats]:
        """The observations of one trial, and the reduced given coordinates (3n) of its points."""
        layout = self.nominal.layout
        b, o = layout.block, layout.block.observations
        points = b.points if coordinates is None else Points(b.points.ids, b.points.role, coordinates, b.points.sigma)
        block = Block(b.cameras, b.images, points, ImageObservations(o.image, o.point, xy, o.sigma))
        return Observations.of(block, layout), (points.coordinates - layout.origin).ravel()

    def _finish(self, trials: Trials, trial: int, groups: Observations, reduced: Floats) -> None:
        """Solve one trial by full Gauss-Newton, from the nominal estimate, and write it into `trials`."""
        layout = self.nominal.layout
        start, fixed = self.nominal.x.copy(), layout.block.points.fixed.ravel()
        start[layout.orientation :][fixed] = reduced[fixed]
        solution = solve(groups, start, Compiled(groups))
        trials.x[trial] = solution.x if solution.status.ok else np.nan
        trials.vpv[trial] = groups.cost(solution.x) if solution.status.ok else np.nan
        trials.status[trial] = STATUSES.index(solution.status)
        trials.iterations[trial] += solution.iterations


@dataclass(frozen=True, eq=False)
class Workspace:
    """The arrays that one block of trials after another is computed in; nothing in them outlives a block."""

    x: Floats
    y: Floats
    start: Floats
    gradient: Floats
    given: Floats
    scaled: npt.NDArray[np.float32]
    change: npt.NDArray[np.float32]
    xy: Floats
    sine: Floats
    cosine: Floats
    contexts: tuple[Floats, ...]
    sums: tuple[Floats, ...]

    @classmethod
    def of(cls, chord: Chord) -> Workspace:
        layout = chord.nominal.layout
        images, size = len(layout.block.images), len(chord.nominal.x)
        widths = [len(s.model.parameters) for s in layout.sets]
        return cls(
            x=np.empty((size, LANES)),
            y=np.empty((size, LANES)),
            start=np.empty((size, LANES)),
            gradient=np.empty((size, LANES)),
            given=np.empty((3 * len(layout.block.points), LANES)),
            scaled=np.empty((size, LANES), dtype=np.float32),
            change=np.empty((size, LANES), dtype=np.float32),
            xy=np.empty((len(layout.block.observations), 2, LANES)),
            sine=np.empty((images, 3, LANES)),
            cosine=np.empty((images, 3, LANES)),
            contexts=tuple(np.empty((images, kernels.PARAMETERS + a, LANES)) for a in widths),
            sums=tuple(np.empty((images, kernels.PULL + a, LANES)) for a in widths),
        )


def _fill_lanes(image_points: Any, trials: slice, order: npt.NDArray[np.intp], lanes: Floats) -> None:
    """lanes (k, 2, LANES): trials inmost, sorted by image; lanes without a trial repeat the first one."""
    if hasattr(image_points, "fill_lanes"):
        image_points.fill_lanes(trials, order, lanes)
    else:
        kernels.transpose(np.ascontiguousarray(image_points[trials], dtype=float), order, lanes)
    lanes[:, :, trials.stop - trials.start :] = lanes[:, :, :1]
