"""Ceres through pycolmap: its C++ cost functions, its choice of linear solver (dense Schur here), its tolerances."""

from __future__ import annotations

from typing import Any

import numpy as np
import pycolmap

from benchmarks.problem import IDEAL4, TO_VISION, Answer, Problem

OTHER_TRIAL = 1_000_000
FORMAT = 100_000
"""width and height given to COLMAP, larger than any image; the solver does not use them"""


class Ceres:
    """One thread. Timed is what happens in C++: building the Ceres problem from the reconstruction, and solving it.

    tuned: as fast as it goes while the costs still agree: steps that are nearly Gauss-Newton's from the start, and a
    stop at a relative cost change of 1e-10. Otherwise pycolmap's defaults, whose gradient tolerance lies where rounding
    errors begin on this block: most trials take two steps more, and some stall in a dozen steps that are rejected.
    """

    def __init__(self, problem: Problem, form: str, tuned: bool = True) -> None:
        self.problem, self.form = problem, form
        self.options = pycolmap.BundleAdjustmentOptions()
        self.options.refine_focal_length = self.options.refine_principal_point = False
        self.options.refine_extra_params = form == IDEAL4
        self.options.print_summary = False
        solver = self.options.ceres.solver_options
        solver.num_threads = 1
        if tuned:
            solver.gradient_tolerance, solver.function_tolerance = 0.0, 1e-10
            solver.initial_trust_region_radius = 1e8
        self.reconstruction: Any = pycolmap.Reconstruction()
        self._add_cameras()
        self._add_images_and_points()
        self.config = pycolmap.BundleAdjustmentConfig()
        for i in range(len(problem.block.images)):
            self.config.add_image(i + 1)
        for point_id, held in zip(self.point_ids, problem.held, strict=True):
            if held:
                self.config.add_constant_point(point_id)

    def _add_cameras(self) -> None:
        sigma = self.problem.sigma_mm
        for c, (f, x0, y0) in enumerate(self.problem.interior):
            pinhole = [f / sigma, f / sigma, x0 / sigma, -y0 / sigma]
            model, more = ("OPENCV", [0.0] * 4) if self.form == IDEAL4 else ("PINHOLE", [])
            camera = pycolmap.Camera(
                camera_id=c + 1, model=model, width=FORMAT, height=FORMAT, params=[*pinhole, *more]
            )
            self.reconstruction.add_camera_with_trivial_rig(camera)

    def _add_images_and_points(self) -> None:
        o, images = self.problem.block.observations, self.problem.block.images
        tracks = [pycolmap.Track() for _ in range(len(self.problem.block.points))]
        xy = self.problem.in_vision_frame(o.xy)
        self.rows = [np.flatnonzero(o.image == i) for i in range(len(images))]
        for i, rows in enumerate(self.rows):
            image = pycolmap.Image(str(i), xy[rows], int(images.camera[i]) + 1, i + 1)
            self.reconstruction.add_image_with_trivial_frame(image, pycolmap.Rigid3d())
            for at, k in enumerate(rows):
                tracks[o.point[k]].add_element(i + 1, at)
        self.point_ids = [self.reconstruction.add_point3D(np.zeros(3), track) for track in tracks]
        self.places = [p for i in range(len(images)) for p in self.reconstruction.image(i + 1).points2D]

    def prepare(self, trial: int) -> None:
        self.write(self.problem.image_points(trial), self.problem.start(trial))

    def write(self, image_points: np.ndarray, start: Answer) -> None:
        """Image points and start values into the reconstruction; parameters start at `start`'s, or at zero."""
        xy = self.problem.in_vision_frame(image_points)[np.concatenate(self.rows)]
        for place, measured in zip(self.places, xy, strict=True):
            place.xy = measured
        for i, (rotation, station) in enumerate(zip(start.rotation, start.station, strict=True)):
            to_camera = TO_VISION @ rotation.T
            pose = pycolmap.Rigid3d(pycolmap.Rotation3d(to_camera), -to_camera @ station)
            self.reconstruction.frame(i + 1).rig_from_world = pose
        for point_id, point in zip(self.point_ids, start.points, strict=True):
            self.reconstruction.point3D(point_id).xyz = point
        if self.form == IDEAL4:
            for c in range(len(self.problem.interior)):
                camera = self.reconstruction.camera(c + 1)
                given = start.parameters[c] if start.parameters.size else np.zeros(4)
                camera.params = np.concatenate([camera.params[:4], given])

    def solve(self) -> None:
        adjuster = pycolmap.create_default_ceres_bundle_adjuster(self.options, self.config, self.reconstruction)
        self.summary: Any = adjuster.solve()

    def answer(self) -> Answer:
        poses = [
            self.reconstruction.frame(i + 1).rig_from_world.matrix() for i in range(len(self.problem.block.images))
        ]
        to_camera = np.array([pose[:, :3] for pose in poses])
        shift = np.array([pose[:, 3] for pose in poses])
        return Answer(
            to_camera.transpose(0, 2, 1) @ TO_VISION,
            -np.einsum("mij,mi->mj", to_camera, shift),
            np.array([self.reconstruction.point3D(p).xyz for p in self.point_ids]),
            np.array([self.reconstruction.camera(c + 1).params[4:] for c in range(len(self.problem.interior))]),
        )

    @property
    def note(self) -> str:
        s = self.summary.ceres_summary
        steps, unknowns = s.num_successful_steps, s.num_effective_parameters_reduced
        rejected = f" and {s.num_unsuccessful_steps} rejected" if s.num_unsuccessful_steps else ""
        return f"{steps} steps{rejected}, {s.linear_solver_type_used.name}, {unknowns} unknowns"


class CeresWarm(Ceres):
    """Started from the estimates of another trial, not from approximate values: what a Monte-Carlo loop could do."""

    def __init__(self, problem: Problem, form: str) -> None:
        super().__init__(problem, form)
        super().prepare(OTHER_TRIAL)
        self.solve()
        self.nominal = self.answer()

    def prepare(self, trial: int) -> None:
        self.write(self.problem.image_points(trial), self.nominal)


class CeresWritten(Ceres):
    """With the writing of the trial into the reconstruction in the time, which a loop in Python has to do."""

    def prepare(self, trial: int) -> None:
        self.given = self.problem.image_points(trial), self.problem.start(trial)

    def solve(self) -> None:
        self.write(*self.given)
        super().solve()
