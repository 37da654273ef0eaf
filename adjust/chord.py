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
from adjust.kernels import LANES
from adjust.observations import Observations
from adjust.rotation import rotation_rows
from adjust.solve import solve
from adjust.status import Status
from adjust.traced_terms import UntraceableError, compile_gradient
from simfield.block import Block, Floats, ImageObservations, Points

ERROR_LEFT = 1e-8
"""bound of the error left in any unknown, in its standard deviations"""
CONTRACTION_MOST = 0.2
"""a trial that contracts less is left to full Gauss-Newton"""
STEPS_MOST = 8
STATUSES = tuple(Status)
CHORD, GAUSS_NEWTON = 0, 1
"""routes by which a trial can be solved"""


@dataclass(frozen=True, eq=False)
class Trials:
    """Solved trials: x (t, size), vPv (t), status (t) indices into STATUSES, iterations (t), route (t)."""

    x: Floats
    vpv: Floats
    status: npt.NDArray[np.int8]
    iterations: npt.NDArray[np.int16]
    route: npt.NDArray[np.int8]

    @classmethod
    def joined(cls, parts: list[Trials], size: int) -> Trials:
        if not parts:
            return cls(np.empty((0, size)), np.empty(0), np.empty(0, "i1"), np.empty(0, "i2"), np.empty(0, "i1"))
        return cls(*(np.concatenate([getattr(p, name) for p in parts]) for name in cls.__dataclass_fields__))


@dataclass(frozen=True, eq=False)
class Chord:
    """What all trials share: the nominal adjustment, the standard deviations s (size, 0 for fixed coordinates), and C."""

    nominal: Adjustment
    s: Floats
    correlation: npt.NDArray[np.float32]

    @classmethod
    def of(cls, block: Block, model: ApModel | Mapping[str, ApModel] | None) -> Chord:
        """Raises ValueError when the block itself cannot be adjusted."""
        nominal = adjust_block(block, model)
        if not nominal.status.ok:
            raise ValueError(f"the block has no nominal adjustment, {nominal.message}")
        everything = np.arange(len(nominal.x))
        q = nominal.cofactors.block(everything, everything)
        s = np.sqrt(np.diag(q))
        inverse = np.divide(1.0, s, out=np.zeros_like(s), where=s > 0.0)
        return cls(nominal, s, np.asarray(q * inverse * inverse[:, None], dtype=np.float32))

    @cached_property
    def gradients(self) -> list[tuple[Callable[..., Any], npt.NDArray[np.uint64], Any]] | None:
        """(compiled gradient, images, set) for each AP set; None when a model cannot be compiled."""
        layout = self.nominal.layout
        try:
            return [
                (compile_gradient(s.model), np.flatnonzero(layout.image_set == number).astype(np.uint64), s)
                for number, s in enumerate(layout.sets)
            ]
        except UntraceableError:
            return None

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "gradients"}

    @cached_property
    def indices(self) -> tuple[Any, Any, Any, Any]:
        """What the kernel wants to know of the image points: starts, point, weight, interior."""
        g = self.nominal.groups.image_points
        return g.starts.astype(np.uint64), g.point.astype(np.uint64), g.weight, g.interior

    def solve(self, image_points: Any, coordinates: Floats | None, trials: slice) -> Trials:
        """Solve at most LANES trials of image_points (t, k, 2) and coordinates (t, n, 3; None: those of the block)."""
        count = trials.stop - trials.start
        coordinates = None if coordinates is None else coordinates[trials]
        x = np.repeat(self.nominal.x[:, None], LANES, axis=1)
        given = self._given(coordinates)
        vpv, iterations = np.full(LANES, np.nan), np.zeros(LANES, dtype=np.int16)
        converged = np.zeros(LANES, dtype=bool)
        if self.gradients is not None:
            xy = _lanes(image_points, trials, self.nominal.groups.image_points.order)
            x[~self.nominal.layout.free] = given[~self.nominal.layout.free]
            converged = self._iterate(x, xy, given, vpv, iterations, np.arange(LANES) < count)
        solved = Trials(
            np.ascontiguousarray(x[:, :count].T),
            vpv[:count],
            np.full(count, STATUSES.index(Status.CONVERGED), dtype=np.int8),
            iterations[:count],
            np.where(converged[:count], CHORD, GAUSS_NEWTON).astype(np.int8),
        )
        for trial in np.flatnonzero(~converged[:count]):
            at = trials.start + int(trial)
            xy_of_trial = np.asarray(image_points[at : at + 1], dtype=float)[0]
            self._finish(solved, int(trial), xy_of_trial, None if coordinates is None else coordinates[trial])
        return solved

    def _given(self, coordinates: Floats | None) -> Floats:
        """(size, LANES) the reduced coordinates given for the points; other rows are not used."""
        layout = self.nominal.layout
        given = np.repeat(self.nominal.x[:, None], LANES, axis=1)
        source = layout.block.points.coordinates[None] if coordinates is None else coordinates
        rows = (source - layout.origin).reshape(len(source), -1).T
        given[layout.orientation :, : len(source)] = rows
        given[layout.orientation :, len(source) :] = rows[:, :1]
        return given

    def _iterate(
        self, x: Floats, xy: Floats, given: Floats, vpv: Floats, iterations: npt.NDArray[np.int16], active: Any
    ) -> npt.NDArray[np.bool_]:
        """Iterate x (size, LANES) in place; returns which trials have converged."""
        converged = np.zeros(LANES, dtype=bool)
        before = np.full(LANES, np.inf)
        y = np.zeros_like(x)
        s = self.s[:, None]
        start = x.copy()
        for step in range(1, STEPS_MOST + 1):
            gradient, cost, depth = self._gradient(x, xy, given)
            gradient *= s
            change = self.correlation @ gradient.astype(np.float32)
            length = np.maximum(change.max(axis=0), -change.min(axis=0)).astype(float)
            active = active & (depth > 0.0) & np.isfinite(length)
            contraction = length / before
            if step > 1:
                active &= contraction < CONTRACTION_MOST
            if not active.all():
                change[:, ~active] = 0.0
            y -= change
            np.multiply(s, y, out=x)
            x += start
            vpv[active], iterations[active] = cost[active], step
            # the first step measures a distance, not an error: nothing is known of the contraction yet
            left = length * contraction / (1.0 - np.minimum(contraction, CONTRACTION_MOST))
            done = active & (left < ERROR_LEFT) & (step > 1)
            converged |= done
            active &= ~done
            before = length
            if not active.any():
                break
        return converged

    def _gradient(self, x: Floats, xy: Floats, given: Floats) -> tuple[Floats, Floats, Floats]:
        """A^T P v (size, LANES), vPv (LANES) and the least depth (LANES) at x."""
        layout = self.nominal.layout
        images = len(layout.block.images)
        exterior = x[: 6 * images].reshape(images, 6, LANES)
        rotation = rotation_rows(exterior[:, 3:])
        gradient = np.zeros_like(x)
        vpv, depth = np.zeros(LANES), np.full(LANES, np.inf)
        starts, point, weight, interior = self.indices
        assert self.gradients is not None
        for compiled, members, ap_set in self.gradients:
            parameters = x[ap_set.columns]
            contexts = np.empty((images, kernels.PARAMETERS + len(parameters), LANES))
            contexts[:, : kernels.STATION] = rotation
            contexts[:, kernels.STATION : kernels.PARAMETERS] = exterior[:, :3]
            contexts[:, kernels.PARAMETERS :] = parameters
            sums = compiled(members, starts, point, weight, interior, contexts, layout.orientation, xy, x, gradient)[
                members
            ]
            vpv += sums[:, kernels.VPV].sum(axis=0)
            depth = np.minimum(depth, sums[:, kernels.DEPTH].min(axis=0, initial=np.inf))
            gradient[ap_set.columns] = sums[:, kernels.PULL :].sum(axis=0)
            at = gradient[: 6 * images].reshape(images, 6, LANES)
            at[members, :3] = -sums[:, : kernels.TORQUE]
            at[members, 3:] = _by_angles(exterior[members], rotation[members], sums[:, kernels.TORQUE : kernels.VPV])
        control = self.nominal.groups.control
        v = x[control.columns] - given[control.columns]
        gradient[control.columns] += control.weight[:, None] * v
        vpv += control.weight @ v**2
        return gradient, vpv, depth

    def _finish(self, trials: Trials, trial: int, xy: Floats, coordinates: Floats | None) -> None:
        """Solve one trial by full Gauss-Newton, from the nominal estimate, and write it into `trials`."""
        layout = self.nominal.layout
        b = layout.block
        points = b.points if coordinates is None else Points(b.points.ids, b.points.role, coordinates, b.points.sigma)
        o = b.observations
        block = Block(b.cameras, b.images, points, ImageObservations(o.image, o.point, xy, o.sigma))
        start = self.nominal.x.copy()
        reduced = (points.coordinates - layout.origin).ravel()
        start[layout.orientation :][points.fixed.ravel()] = reduced[points.fixed.ravel()]
        groups = Observations.of(block, layout)
        solution = solve(groups, start)
        trials.x[trial] = solution.x if solution.status.ok else np.nan
        trials.vpv[trial] = groups.cost(solution.x) if solution.status.ok else np.nan
        trials.status[trial] = STATUSES.index(solution.status)
        trials.iterations[trial] += solution.iterations


def _by_angles(exterior: Floats, rotation: Floats, torque: Floats) -> Floats:
    """The gradient by omega, phi, kappa (m, 3, LANES) from the torque: each angle turns about its own axis.

    The axes are e1, R1 e2 and R e3, and a turn about axis a changes vPv / 2 by -a . torque.
    """
    omega = exterior[:, 3]
    second = np.cos(omega) * torque[:, 1] + np.sin(omega) * torque[:, 2]
    third = np.einsum("mat,mat->mt", rotation[:, 2::3], torque)
    return -np.stack([torque[:, 0], second, third], axis=1)


def _lanes(image_points: Any, trials: slice, order: npt.NDArray[np.intp]) -> Floats:
    """(k, 2, LANES): trials inmost, sorted by image; lanes without a trial repeat the first one."""
    lanes = np.empty((len(order), 2, LANES))
    if hasattr(image_points, "fill_lanes"):
        image_points.fill_lanes(trials, order, lanes)
    else:
        kernels.transpose(np.ascontiguousarray(image_points[trials], dtype=float), order, lanes)
    lanes[:, :, trials.stop - trials.start :] = lanes[:, :, :1]
    return lanes
