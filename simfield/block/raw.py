"""The measured file: what a surveyor has before any reduction. Machine coordinates, marks, certificates, heights.

Its files: simfield.files.raw_folder. time runs from 0 to 1 in the session of an image; fiducials are set at its start
and at its end.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from simfield.block.block import Block, Floats, Indices


@dataclass(frozen=True, eq=False)
class Raw:
    """block: cameras, images and points, its observations the means of the settings in the machine's frame.

    settings (k, s, 2) and time (k) of the image points in the order of the block's observations; mark_image, mark,
    mark_time (f) and mark_settings (f, s, 2) of all settings of marks; mark_ids and mark_kinds (M) name the marks,
    calibrated gives (M, 2) mm for each camera; heights (m, 2) of camera and ground, m; machine: scale x, scale y and
    non-orthogonality, ppm; certificates: radii (r) mm and distortions (4, r) um of cameras that have one.
    """

    block: Block
    settings: Floats
    time: Floats
    mark_image: Indices
    mark: Indices
    mark_time: Floats
    mark_settings: Floats
    mark_ids: tuple[str, ...]
    mark_kinds: tuple[str, ...]
    calibrated: Mapping[str, Floats]
    heights: Floats
    machine: tuple[float, float, float]
    certificates: Mapping[str, tuple[Floats, Floats]]
