"""What additional parameters say about a camera, beside what is true: the radial curve and the decentering vectors.

Distortions are contained in the measurement (measured = ideal + d), in um; the radial one is positive outward.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adjust import Adjustment, ApModel
from simfield import Truth
from simfield.block import Floats
from simfield.disturbances import Decentering
from studies.comparison.measures import root_mean_square
from studies.comparison.perspective import perspective_reduction

RADIAL = {"optical": ("a3", "a4"), "torlegard": ("a3", "a4"), "brown14": ("b10", "b11", "b12")}
DECENTERING = {"optical": ("a5", "a6"), "torlegard": ("a5", "a6"), "brown14": ("b13", "b14")}
"""the parameters of each model that are radial-symmetric distortion, and decentering distortion"""
RADIUS_MOST_MM = 150.0
CREST_RADII_MM = np.linspace(0.0, RADIUS_MOST_MM, 151)
"""at which radial curves are computed, and their crest is sought"""
GRID_HALF_MM, GRID_STEP_MM = 100.0, 20.0
DIRECTIONS = 72


@dataclass(frozen=True, eq=False)
class RadialCurve:
    """Radial-symmetric distortion at radii r_mm (n): estimated_um with std_um, and true_um with the same zero r0."""

    camera: str
    model: str
    r0_mm: float
    r_mm: Floats
    estimated_um: Floats
    std_um: Floats
    true_um: Floats

    @property
    def crest_um(self) -> float:
        """The extreme value between the centre and r0."""
        return crest(self.r_mm, self.estimated_um, self.r0_mm)


@dataclass(frozen=True, eq=False)
class VectorField:
    """Distortion vectors (n, 2) in um at image points xy_mm (n, 2)."""

    xy_mm: Floats
    vectors_um: Floats

    @property
    def rms_um(self) -> float:
        """The quadratic mean of the lengths of the vectors."""
        return root_mean_square(np.hypot(*self.vectors_um.T))

    @property
    def corner_um(self) -> float:
        """The length of the longest vector in a corner of the grid."""
        reach = np.abs(self.xy_mm).sum(axis=1)
        return float(np.hypot(*self.vectors_um[np.isclose(reach, reach.max())].T).max())


@dataclass(frozen=True, eq=False)
class DecenteringFields:
    """Decentering as estimated and as true, and both after the perspective reduction; tilt_deg (2) is phi, omega
    taken out.
    """

    camera: str
    model: str
    estimated: VectorField
    true: VectorField
    reduced: VectorField
    true_reduced: VectorField
    tilt_deg: Floats


def radial_curve(a: Adjustment, camera: str, truth: Truth) -> RadialCurve:
    """The radial curve of a camera from its additional parameters. Raises KeyError for a model without a known one."""
    model = _model(a, camera)
    names = RADIAL[model.id]
    columns = [model.parameters.index(name) for name in names]
    r0 = float(model.settings["r0_mm"])
    r = CREST_RADII_MM
    terms = 1000.0 * model.basis(r, np.zeros_like(r))[:, 0, columns]
    covariance = a.covariance(*((camera, name) for name in names))
    std = np.sqrt(np.einsum("ni,ij,nj->n", terms, covariance, terms))
    return RadialCurve(
        camera, model.id, r0, r, terms @ a.ap[camera].values[columns], std, true_radial(truth, camera, r, r0)
    )


def true_radial(truth: Truth, camera: str, r_mm: Floats, r0_mm: float) -> Floats:
    """The true distortion of a camera along the radius, um: the mean over all directions, brought to zero at r0.

    What is proportional to r is a change of the principal distance, which a block over flat ground cannot see; it is
    taken out (for r0 = 0: left in).
    """

    def mean_over_directions(r: Floats) -> Floats:
        angle = np.arange(DIRECTIONS) * 2.0 * np.pi / DIRECTIONS
        outward = np.column_stack([np.cos(angle), np.sin(angle)])
        xy = r[:, None, None] * outward
        d = truth.camera_distortion(camera, xy.reshape(-1, 2)).reshape(xy.shape)
        return np.asarray(1000.0 * np.mean(np.sum(d * outward, axis=2), axis=1))

    curve = mean_over_directions(r_mm)
    if r0_mm == 0.0:
        return curve
    return np.asarray(curve - r_mm / r0_mm * mean_over_directions(np.array([r0_mm]))[0])


def decentering_fields(a: Adjustment, camera: str, truth: Truth) -> DecenteringFields:
    """The decentering vectors of a camera on the grid of the figures. Raises KeyError for a model without any."""
    model = _model(a, camera)
    columns = [model.parameters.index(name) for name in DECENTERING[model.id]]
    xy = format_grid()
    estimated = model.basis(*xy.T)[:, :, columns] @ a.ap[camera].values[columns]
    true = np.zeros_like(xy)
    for on in truth.effects:
        if isinstance(on.effect, Decentering) and on.acts_on(camera, "", ""):
            true = true + on.effect.displacement(xy)
    c = next(one.c_mm for one in a.block.cameras if one.camera_id == camera)
    reduced, true_reduced = (perspective_reduction(xy, field, c) for field in (estimated, true))
    return DecenteringFields(
        camera=camera,
        model=model.id,
        estimated=VectorField(xy, 1000.0 * estimated),
        true=VectorField(xy, 1000.0 * true),
        reduced=VectorField(xy, 1000.0 * reduced.field),
        true_reduced=VectorField(xy, 1000.0 * true_reduced.field),
        tilt_deg=np.rad2deg([reduced.phi, reduced.omega]),
    )


def format_grid() -> Floats:
    """(n, 2) the image points, mm, at which vectors are drawn and averaged."""
    steps = np.arange(-GRID_HALF_MM, GRID_HALF_MM + GRID_STEP_MM / 2.0, GRID_STEP_MM)
    return np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)


def crest(r_mm: Floats, curve_um: Floats, r0_mm: float) -> float:
    """The extreme value of a radial curve between the centre and its second zero r0."""
    inside = curve_um[r_mm <= r0_mm]
    return float(inside[np.argmax(np.abs(inside))])


def _model(a: Adjustment, camera: str) -> ApModel:
    return next(s.model for s in a.layout.sets if s.id == camera)
