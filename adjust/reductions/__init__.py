"""From machine coordinates to image coordinates: reductions, each of which says what it removed."""

from adjust.reductions.air import earth_curvature, refraction
from adjust.reductions.comparator import DoubleMeasurement, calibrated, double_measurement, drift
from adjust.reductions.inner import InnerOrientation, inner_orientation
from adjust.reductions.lens import decentering, displaced, radial, tilt
from adjust.reductions.reduced import Reduced
from adjust.reductions.reseau import reseau

__all__ = [
    "DoubleMeasurement",
    "InnerOrientation",
    "Reduced",
    "calibrated",
    "decentering",
    "displaced",
    "double_measurement",
    "drift",
    "earth_curvature",
    "inner_orientation",
    "radial",
    "refraction",
    "reseau",
    "tilt",
]
