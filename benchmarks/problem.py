"""What all solvers of the benchmark are given, what they hand back, and the one cost that judges them.

Four forms of the same block. "none": the collinearity equations alone, which every solver states exactly. "ideal4":
two radial and two decentering parameters a camera, evaluated at the projected point; this is what Ceres (through
pycolmap) and GTSAM have built in. "optical": as many, of the same kind, at the measured point, the form of this engine.
"brown14": 14 parameters a camera, at the measured point.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Protocol

import numpy as np

from adjust import ap_models
from adjust.ap_models import ApModel
from adjust.model import Unknowns, rotation_matrices
from adjust.observations import Observations
from adjust.solution import initial
from simfield import Block, World, build_world, presets
from simfield.block import Floats

NONE, IDEAL4, OPTICAL, BROWN14 = "none", "ideal4", "optical", "brown14"
TO_VISION = np.diag([1.0, -1.0, -1.0])
"""from the camera frame of photogrammetry (y up, looking along -z) to that of computer vision (y down, along +z)"""
PRESET, SEED = "rheidt-1980", 1980


@dataclass(frozen=True, eq=False)
class Answer:
    """Estimates: rotation (m, 3, 3) camera to object, station (m, 3) and points (n, 3) reduced to the origin, m;
    parameters (cameras, a) in the form's own units."""

    rotation: Floats
    station: Floats
    points: Floats
    parameters: Floats


class Solver(Protocol):
    """A solver under measurement. `prepare` is not timed, `solve` is; `answer` is read after a solve."""

    form: str

    def prepare(self, trial: int) -> None: ...

    def solve(self) -> None: ...

    def answer(self) -> Answer: ...


@dataclass(frozen=True, eq=False)
class Problem:
    """The block of a preset, its trials, and the start values that all solvers share."""

    world: World
    block: Block

    @classmethod
    def of(cls, preset: str = PRESET, seed: int = SEED) -> Problem:
        world = build_world(presets[preset], seed)
        return cls(world, world.observe(0)[0])

    def model(self, form: str) -> ApModel:
        """The AP model of this engine for a form. Raises KeyError for one that it cannot state."""
        return {name: ap_models.get(name) for name in (NONE, OPTICAL, BROWN14)}[form]

    def unknowns(self, form: str) -> int:
        per_camera = {NONE: 0, IDEAL4: 4, OPTICAL: 4, BROWN14: 14}[form]
        return 6 * len(self.block.images) + per_camera * len(self.block.cameras) + int((~self.block.points.fixed).sum())

    def image_points(self, trial: int) -> Floats:
        """(k, 2) of a trial, mm, in the order of the block."""
        return self.world.image_points(trial)

    def trial_block(self, trial: int) -> Block:
        return self.block.replace_image_points(self.image_points(trial))

    @lru_cache(maxsize=4)  # noqa: B019  a problem lives as long as the run
    def start(self, trial: int) -> Answer:
        """The approximate orientations of the block and the points intersected with them: where everybody starts."""
        layout = Unknowns.of(self.trial_block(trial), ap_models.get("none"))
        x = initial.values(layout, Observations.of(layout.block, layout).image_points)
        exterior = layout.exterior(x)
        rotation = rotation_matrices(exterior[:, 3:])
        return Answer(rotation, exterior[:, :3].copy(), layout.points(x).copy(), np.zeros((len(self.block.cameras), 0)))

    @cached_property
    def sigma_mm(self) -> float:
        """The one standard deviation of all image coordinates; peers take coordinates in this unit."""
        sigma = np.unique(self.block.observations.sigma)
        assert sigma.size == 1, "the peers are given one weight for all"
        return float(sigma[0])

    @cached_property
    def interior(self) -> Floats:
        """(cameras, 3) c, x0, y0, mm."""
        return np.array([(c.c_mm, c.x0_mm, c.y0_mm) for c in self.block.cameras])

    @cached_property
    def held(self) -> Floats:
        """(n) the control points, which all solvers hold constant."""
        fixed = self.block.points.fixed
        assert (fixed.all(axis=1) == fixed.any(axis=1)).all(), "the peers are given whole points as control"
        return np.asarray(fixed.all(axis=1))

    def in_vision_frame(self, xy: Floats) -> Floats:
        """Image coordinates (.., 2), mm, as a computer vision library wants them: y down, in units of sigma."""
        return xy / self.sigma_mm * [1.0, -1.0]

    def cost(self, answer: Answer, form: str, trial: int) -> float:
        """vPv of an answer; the same function for every solver, and none of their own."""
        o = self.block.observations
        camera = self.block.images.camera[o.image]
        interior = self.interior[camera]
        ray = answer.points[o.point] - answer.station[o.image]
        p = np.einsum("kij,ki->kj", answer.rotation[o.image], ray)
        u = -p[:, :2] / p[:, 2:]
        measured = self.image_points(trial)
        distortion = np.zeros_like(u)
        if form == IDEAL4:
            u = u + _opencv(u * [1.0, -1.0], answer.parameters[camera]) * [1.0, -1.0]
        elif form != NONE:
            basis = self.model(form).basis(measured[:, 0], measured[:, 1])
            distortion = np.einsum("kij,kj->ki", basis, answer.parameters[camera])
        v = interior[:, 1:] + interior[:, :1] * u + distortion - measured
        return float(np.sum((v / o.sigma) ** 2))


def _opencv(u: Floats, parameters: Floats) -> Floats:
    """k1, k2, p1, p2 of OpenCV's model (COLMAP: OPENCV, GTSAM: Cal3DS2), in the frame of computer vision."""
    k1, k2, p1, p2 = parameters.T
    x, y = u.T
    r2 = x**2 + y**2
    radial = k1 * r2 + k2 * r2**2
    return np.column_stack(
        [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x**2),
            y * radial + 2.0 * p2 * x * y + p1 * (r2 + 2.0 * y**2),
        ]
    )
