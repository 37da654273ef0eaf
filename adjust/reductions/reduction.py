"""From the measured file to a block: the study chooses which reductions are applied, so that one can be left out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields

import numpy as np

from adjust import reductions
from adjust.reductions.comparator import DoubleMeasurement
from adjust.reductions.inner import InnerOrientation, Kind
from adjust.reductions.reduced_points import Reduced
from simfield.block import Block, Floats, ImageObservations, Indices, Raw


@dataclass(frozen=True)
class ReductionPlan:
    """The reductions that are applied, in this order: double measurement, drift, comparator, inner orientation,
    reseau (by a polynomial of a degree, None: not), lens certificate, refraction, earth curvature.
    """

    inner: Kind = "helmert"
    threshold_um: float = 15.0
    drift: bool = True
    comparator: bool = True
    reseau_degree: int | None = None
    lens: bool = True
    refraction: bool = True
    curvature: bool = True


REDUCTIONS = tuple(f.name for f in fields(ReductionPlan) if f.default is True)
"""the reductions that can be left out"""


@dataclass(frozen=True, eq=False)
class ReducedBlock:
    """The block, and what every reduction said: removed (k, 2) mm by name, in the order in which they were applied."""

    block: Block
    double: DoubleMeasurement
    inner: InnerOrientation
    removed: dict[str, Floats] = field(default_factory=dict)

    @property
    def rms_um(self) -> dict[str, float]:
        """The rms of what each reduction removed from a coordinate, um."""
        return {name: 1000.0 * float(np.sqrt(np.mean(d**2))) for name, d in self.removed.items()}


def reduce(raw: Raw, plan: ReductionPlan | None = None) -> ReducedBlock:
    """Turn machine coordinates into image coordinates. Raises ValueError where the marks do not suffice."""
    plan = ReductionPlan() if plan is None else plan
    b, o = raw.block, raw.block.observations
    double = reductions.double_measurement(raw.settings, plan.threshold_um)
    marks = reductions.double_measurement(raw.mark_settings, plan.threshold_um).mean
    xy, m = double.mean, len(b.images)
    removed: dict[str, Floats] = {}
    if plan.drift:
        found = reductions.drift(marks, raw.mark_image, raw.mark, raw.mark_time, m)
        marks = found.removed_from(marks, raw.mark_image, raw.mark_time).xy
        xy = _noted(removed, "drift", found.removed_from(xy, o.image, raw.time))
    if plan.comparator:
        marks = reductions.calibrated(marks, *raw.machine).xy
        xy = _noted(removed, "comparator", reductions.calibrated(xy, *raw.machine))
    inner, marks, oriented = _inner(raw, plan, marks, xy)
    # the frame changes here: what the transformation removes beyond a rigid motion is what deforms the image
    removed["inner orientation"] = _beyond_rigid(xy, oriented.xy, o.image, m)
    xy = oriented.xy
    if plan.reseau_degree is not None:
        is_reseau = np.array([kind == "reseau" for kind in raw.mark_kinds])[raw.mark]
        places = marks_of(raw)[is_reseau]
        corrected = reductions.reseau(
            xy, o.image, marks[is_reseau], places, raw.mark_image[is_reseau], plan.reseau_degree
        )
        xy = _noted(removed, "reseau", corrected)
    xy = through_lens_and_air(raw, plan, xy, o.image, removed)
    observations = ImageObservations(o.image, o.point, xy, o.sigma)
    return ReducedBlock(Block(b.cameras, b.images, b.points, observations), double, inner, removed)


def _inner(raw: Raw, plan: ReductionPlan, marks: Floats, xy: Floats) -> tuple[InnerOrientation, Floats, Reduced]:
    """The inner orientation, all marks in the image frame, and the points."""
    is_fiducial = np.array([kind == "fiducial" for kind in raw.mark_kinds])[raw.mark]
    image = raw.mark_image[is_fiducial]
    found = reductions.inner_orientation(
        plan.inner, marks[is_fiducial], marks_of(raw)[is_fiducial], image, len(raw.block.images)
    )
    return found, found.apply(marks, raw.mark_image).xy, found.apply(xy, raw.block.observations.image)


def through_lens_and_air(
    raw: Raw, plan: ReductionPlan, xy: Floats, image: Indices, removed: dict[str, Floats]
) -> Floats:
    """(k, 2): points xy (k, 2) in the images (k) without lens errors, refraction and curvature, as the plan says."""
    b = raw.block
    if plan.lens and raw.certificates:
        before, xy = xy, np.array(xy)
        for number, camera in enumerate(b.cameras):
            own = (b.images.camera == number)[image]
            if camera.camera_id in raw.certificates and own.any():
                xy[own] = reductions.radial(xy[own], *raw.certificates[camera.camera_id]).xy
        removed["lens"] = before - xy
    c = np.array([camera.c_mm for camera in b.cameras])[b.images.camera]
    camera_m, ground_m = raw.heights.T
    steps: tuple[tuple[str, bool, Callable[..., Reduced]], ...] = (
        ("refraction", plan.refraction, reductions.refraction),
        ("earth curvature", plan.curvature, reductions.earth_curvature),
    )
    for name, wanted, reduction in steps:
        if wanted:
            xy = _noted(removed, name, reduction(xy, image, c, camera_m, ground_m))
    return xy


def marks_of(raw: Raw) -> Floats:
    """(f, 2) the calibrated positions of all measured marks."""
    camera_ids = raw.block.camera_ids
    table = np.stack([raw.calibrated[c] for c in camera_ids])
    return np.asarray(table[raw.block.images.camera[raw.mark_image], raw.mark])


def _noted(removed: dict[str, Floats], name: str, reduced: Reduced) -> Floats:
    removed[name] = reduced.removed
    return reduced.xy


def _beyond_rigid(before: Floats, after: Floats, image: Indices, images: int) -> Floats:
    """(k, 2): what changed from before to after beyond a rotation and a shift of each image."""
    left = np.zeros_like(before)
    for i in range(images):
        own = image == i
        if own.sum() < 2:
            continue
        z, w = before[own] @ [1.0, 1.0j], after[own] @ [1.0, 1.0j]
        z, w = z - z.mean(), w - w.mean()
        turned = z * np.exp(1j * np.angle(np.vdot(z, w)))
        left[own] = np.column_stack([(turned - w).real, (turned - w).imag])
    return left
