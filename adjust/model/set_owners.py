"""Which images share one set of additional parameters: those of a camera, a flight, a strip, or each image alone.

A block says the camera of an image, but not its flight or strip; these are read from ids such as "ww-before-h100-2":
image 2 of the strip heading 100 gon of the flight "ww-before", as the simulator and many surveyors name them. For
blocks with other ids `adjust_block` takes a mapping from image ids to set ids.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Literal, get_args

from simfield.block import Block

ApBy = Literal["camera", "flight", "strip", "image"]
CHOICES: tuple[ApBy, ...] = get_args(ApBy)
READABLE = re.compile(r"(?P<strip>(?P<flight>.+)-h[0-9.]+(-s[0-9]+)?)-[0-9]+")


def ap_sets(block: Block, by: ApBy) -> Mapping[str, str]:
    """The AP set of every image id.

    Raises ValueError for an unknown choice and for ids that name no flight or strip.
    """
    if by not in CHOICES:
        raise ValueError(f"no AP sets by {by!r}, allowed are {', '.join(CHOICES)}")
    ids = block.images.ids
    if by == "camera":
        return dict(zip(ids, (block.camera_ids[c] for c in block.images.camera), strict=True))
    if by == "image":
        return dict(zip(ids, ids, strict=True))
    sets = {}
    for image_id in ids:
        found = READABLE.fullmatch(image_id)
        if found is None:
            raise ValueError(
                f"the id {image_id!r} names no {by}: readable are ids such as 'ww-before-h100-2'; "
                "otherwise give the AP set of every image"
            )
        sets[image_id] = found[by]
    return sets
