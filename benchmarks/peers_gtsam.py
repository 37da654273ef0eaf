"""GTSAM with its own C++ factors: Levenberg-Marquardt, multifrontal Cholesky, METIS ordering, the best of ten tried."""

from __future__ import annotations

from typing import Any

import gtsam
import numpy as np
from gtsam.symbol_shorthand import K, L, X

from benchmarks.problem import IDEAL4, TO_VISION, Answer, Problem
from simfield.block import Floats

HELD_M = 1e-6
"""standard deviation of what is held constant: hard constraints send GTSAM to QR, forty times slower, and this moves
the cost by 2e-11 of it"""
FREE = 1e6


class Gtsam:
    """Timed are the optimiser's construction and its iterations; the factor graph is built before."""

    def __init__(self, problem: Problem, form: str) -> None:
        self.problem, self.form = problem, form
        self.settings = gtsam.LevenbergMarquardtParams()
        self.settings.setLinearSolverType("MULTIFRONTAL_CHOLESKY")
        self.settings.setOrderingType("METIS")
        self.settings.setRelativeErrorTol(1e-10)
        self.settings.setAbsoluteErrorTol(0.0)
        sigma = problem.sigma_mm
        self.interior = [(f / sigma, f / sigma, 0.0, x0 / sigma, -y0 / sigma) for f, x0, y0 in problem.interior]

    def prepare(self, trial: int) -> None:
        start = self.problem.start(trial)
        self.graph, self.start = gtsam.NonlinearFactorGraph(), gtsam.Values()
        self._add_image_points(self.problem.in_vision_frame(self.problem.image_points(trial)))
        held = gtsam.noiseModel.Isotropic.Sigma(3, HELD_M)
        for p, point in enumerate(start.points):
            self.start.insert(L(p), point)
            if self.problem.held[p]:
                self.graph.add(gtsam.PriorFactorPoint3(L(p), point, held))
        for i, (rotation, station) in enumerate(zip(start.rotation, start.station, strict=True)):
            self.start.insert(X(i), gtsam.Pose3(gtsam.Rot3(rotation @ TO_VISION), station))
        if self.form == IDEAL4:
            noise = gtsam.noiseModel.Diagonal.Sigmas(np.array([HELD_M] * 5 + [FREE] * 4))
            for c, interior in enumerate(self.interior):
                calibration = gtsam.Cal3DS2(*interior, 0.0, 0.0, 0.0, 0.0)
                self.start.insert(K(c), calibration)
                self.graph.add(gtsam.PriorFactorCal3DS2(K(c), calibration, noise))

    def _add_image_points(self, xy: np.ndarray) -> None:
        o, camera = self.problem.block.observations, self.problem.block.images.camera
        unit = gtsam.noiseModel.Unit.Create(2)
        constants = [gtsam.Cal3_S2(*interior) for interior in self.interior]
        factor: Any
        for measured, i, p in zip(xy, o.image.tolist(), o.point.tolist(), strict=True):
            if self.form == IDEAL4:
                factor = gtsam.GeneralSFMFactor2Cal3DS2(measured, unit, X(i), L(p), K(int(camera[i])))
            else:
                factor = gtsam.GenericProjectionFactorCal3_S2(measured, unit, X(i), L(p), constants[camera[i]])
            self.graph.add(factor)

    def solve(self) -> None:
        optimiser = gtsam.LevenbergMarquardtOptimizer(self.graph, self.start, self.settings)
        self.values = optimiser.optimize()
        self.iterations = optimiser.iterations()

    def answer(self) -> Answer:
        block = self.problem.block
        poses = [self.values.atPose3(X(i)) for i in range(len(block.images))]
        parameters = np.zeros((len(block.cameras), 0))
        if self.form == IDEAL4:
            parameters = np.array([self.values.atCal3DS2(K(c)).vector()[5:] for c in range(len(block.cameras))])
        return Answer(
            np.array([pose.rotation().matrix() for pose in poses]) @ TO_VISION,
            np.array([pose.translation() for pose in poses]),
            np.array([self.values.atPoint3(L(p)) for p in range(len(block.points))]),
            parameters,
        )

    def point_std(self) -> Floats:
        """(n, 3) standard deviations of the points for sigma0 = 1, m, marginal over everything else; 0 where held."""
        marginals = gtsam.Marginals(self.graph, self.values)
        variances = [np.diag(marginals.marginalCovariance(L(p))) for p in range(len(self.problem.held))]
        return np.where(self.problem.held[:, None], 0.0, np.sqrt(variances))

    @property
    def note(self) -> str:
        return f"{self.iterations} steps"
