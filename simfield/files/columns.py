"""The files that a block folder or the folder of a measured file may have, with the header of each.

What each column means, its unit and what an empty field says: docs/conventions.md.
"""

from __future__ import annotations

from collections.abc import Mapping

from simfield.block import ATTITUDE, COORDINATES, EXTERIOR, POSITION, SIGMA_ATTITUDE, SIGMA_POSITION, SIGMAS

INTERIOR = ("c_mm", "x0_mm", "y0_mm", "width_mm", "height_mm")
BLOCK: Mapping[str, tuple[str, ...]] = {
    "cameras": ("camera_id", *INTERIOR),
    "images": ("image_id", "camera_id", *EXTERIOR),
    "points": ("point_id", "role", *COORDINATES, *SIGMAS),
    "observations": ("image_id", "point_id", "x_mm", "y_mm", "sigma_x_mm", "sigma_y_mm"),
}
"""every block has these, by the table's name in a BlockError; the file is the name with .csv"""
FURTHER: Mapping[str, tuple[str, ...]] = {
    "strips": ("strip_id", "position_bias", "attitude_bias"),
    "stations": ("image_id", "strip_id", "time_s", *POSITION, *SIGMA_POSITION, *ATTITUDE, *SIGMA_ATTITUDE),
    "distances": ("from_point_id", "to_point_id", "distance_m", "sigma_m"),
    "height_differences": ("from_point_id", "to_point_id", "height_difference_m", "sigma_m"),
    "ap_priors": ("camera_id", "parameter", "value", "sigma"),
}
"""beside them, where further observations were made"""
RAW: Mapping[str, tuple[str, ...]] = {
    "settings": ("image_id", "kind", "id", "setting", "time", "x_mm", "y_mm"),
    "marks": ("camera_id", "kind", "id", "x_mm", "y_mm"),
    "heights": ("image_id", "camera_m", "ground_m"),
    "machine": ("scale_x_ppm", "scale_y_ppm", "non_orthogonality_ppm"),
    "certificates": ("camera_id", "radius_mm", "d45_um", "d135_um", "d225_um", "d315_um"),
    "sigmas": ("image_id", "sigma_mm"),
}
"""a measured file, beside cameras, images and points"""
TRUTH_FILE = "truth.json"
ALL_FILES = (*(f"{name}.csv" for name in {**BLOCK, **FURTHER, **RAW}), TRUTH_FILE)
"""what a folder holds of one flight: none of them survives from another one"""
