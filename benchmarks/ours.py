"""This engine under the same measurement."""

from __future__ import annotations

import numpy as np

from adjust import Adjustment, adjust_block
from adjust.model import rotation_matrices
from adjust.trials import Replicates, adjust_replicates
from benchmarks.problem import Answer, Problem
from simfield.block import Floats


class AdjustBlock:
    """Timed is adjust_block from the block to the estimates, start values included; with_std: and all their std.

    compiled False: the readable arithmetic in plain numpy.
    """

    def __init__(self, problem: Problem, form: str, with_std: bool = False, compiled: bool = True) -> None:
        self.problem, self.form, self.with_std, self.compiled = problem, form, with_std, compiled
        self.model = problem.model(form)

    def prepare(self, trial: int) -> None:
        self.block = self.problem.trial_block(trial)

    def solve(self) -> None:
        self.adjustment = adjust_block(self.block, self.model, compiled=self.compiled)
        if self.with_std:
            self.std = self.adjustment.std

    def answer(self) -> Answer:
        return answer_of(self.adjustment, self.adjustment.x)

    def point_std(self) -> Floats:
        """(n, 3) standard deviations of the points for sigma0 = 1, m; 0 where held."""
        return np.sqrt(np.einsum("nii->ni", self.adjustment.cofactors.points))

    @property
    def note(self) -> str:
        return f"{self.adjustment.iterations} steps, {self.adjustment.unknowns} unknowns"


class AdjustReplicates:
    """Timed is adjust_replicates over `count` trials in one process, the drawing included."""

    def __init__(self, problem: Problem, form: str, count: int) -> None:
        self.problem, self.form, self.count, self.model = problem, form, count, problem.model(form)
        self.trials = problem.world.draws(0, count)

    def prepare(self, trial: int) -> None:
        self.trial = trial

    def solve(self) -> None:
        self.replicates: Replicates = adjust_replicates(self.problem.block, self.model, self.trials, jobs=1)

    def answer(self) -> Answer:
        return answer_of(self.replicates.nominal, self.replicates.trials.x[self.trial])

    @property
    def note(self) -> str:
        r = self.replicates
        steps, left = r.iterations.mean(), r.finished_by_gauss_newton
        return f"{self.count} trials, {steps:.2f} steps a trial, {left} by Gauss-Newton"


def answer_of(adjustment: Adjustment, x: Floats) -> Answer:
    layout = adjustment.layout
    exterior = layout.exterior(x)
    return Answer(
        rotation_matrices(exterior[:, 3:]),
        exterior[:, :3],
        layout.points(x),
        np.array([x[s.columns] for s in layout.sets]),
    )
