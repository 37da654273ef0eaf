"""scipy.optimize.least_squares with an analytic sparse Jacobian: trust region, x_scale="jac", LSMR run to the end.

The residuals and derivatives are this engine's numpy functions. The dense variants (tr_solver="exact", method="lm")
take 5 to 50 times as long on this block, and LSMR with its own tolerances stops short of the minimum.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse
from scipy.optimize import least_squares

from adjust.model import Unknowns, rotation_matrices
from adjust.observations import Observations
from benchmarks.problem import Answer, Problem
from simfield.block import Floats


class Scipy:
    """Timed is the call of least_squares."""

    def __init__(self, problem: Problem, form: str) -> None:
        self.problem, self.form, self.model = problem, form, problem.model(form)

    def prepare(self, trial: int) -> None:
        start = self.problem.start(trial)
        self.layout = Unknowns.of(self.problem.trial_block(trial), self.model)
        self.group = Observations.of(self.layout.block, self.layout).image_points
        exterior = np.column_stack([start.station, self.problem.block.images.exterior[:, 3:]])
        between = np.zeros(self.layout.orientation - exterior.size)
        self.x = np.concatenate([exterior.ravel(), between, start.points.ravel()])
        self.free = np.flatnonzero(self.layout.free)
        self.root_weight = np.sqrt(self.group.weight)
        self._find_places()

    def _find_places(self) -> None:
        """Rows and columns of the Jacobian's numbers, which do not change."""
        g, u = self.group, self.layout
        column_of = np.full(len(self.x), -1)
        column_of[self.free] = np.arange(len(self.free))
        first_parameter = np.array([s.columns.start for s in u.sets])[u.image_set[g.image]]
        at = [
            6 * g.image[:, None] + np.arange(6),
            first_parameter[:, None] + np.arange(g.basis.shape[2]),
            u.orientation + 3 * g.point[:, None] + np.arange(3),
        ]
        columns = column_of[np.repeat(np.column_stack(at), 2, axis=0)]
        self.kept = columns.ravel() >= 0
        self.columns = columns.ravel()[self.kept]
        self.rows = np.repeat(np.arange(2 * len(g.image)), columns.shape[1])[self.kept]

    def _at(self, y: Floats) -> Floats:
        self.x[self.free] = y
        return self.x

    def _residuals(self, y: Floats) -> Floats:
        return np.asarray((self.group.residuals(self._at(y))[0] * self.root_weight).ravel())

    def _jacobian(self, y: Floats) -> scipy.sparse.csr_matrix:
        j = self.group.jacobian(self._at(y))
        numbers = np.concatenate([j.by_orientation, j.by_point], axis=2) * self.root_weight[:, :, None]
        shape = (2 * len(self.group.image), len(self.free))
        return scipy.sparse.csr_matrix((numbers.ravel()[self.kept], (self.rows, self.columns)), shape=shape)

    def solve(self) -> None:
        self.found = least_squares(
            self._residuals,
            self.x[self.free],
            self._jacobian,
            x_scale="jac",
            tr_solver="lsmr",
            tr_options={"atol": 1e-12, "btol": 1e-12, "maxiter": 5000},
            ftol=1e-12,
            xtol=1e-14,
            gtol=None,
            max_nfev=100,
        )

    def answer(self) -> Answer:
        x = self._at(self.found.x)
        exterior = self.layout.exterior(x)
        return Answer(
            rotation_matrices(exterior[:, 3:]),
            exterior[:, :3],
            self.layout.points(x),
            np.array([x[s.columns] for s in self.layout.sets]),
        )

    @property
    def note(self) -> str:
        return f"{self.found.njev} Jacobians"
