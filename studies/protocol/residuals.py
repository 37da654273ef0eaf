"""Residuals in the protocol: by image, and by camera and ring about the principal point."""

from __future__ import annotations

from typing import Any

import numpy as np

from adjust import Adjustment
from simfield.block import Floats

Record = dict[str, Any]
RINGS = 8


def by_image(a: Adjustment) -> list[Record]:
    """Number, mean and rms of the residuals of every image, um."""
    found = []
    for i, name in enumerate(a.block.images.ids):
        v = 1000.0 * a.residuals[a.block.observations.image == i]
        if len(v):
            found.append({"image": name, "n": len(v), **_moments(v, ("x", "y"))})
    return found


def by_radius(a: Adjustment) -> list[Record]:
    """Of every camera and ring about its principal point: number, mean and rms of radial and tangential residuals,
    um.
    """
    b, found = a.block, []
    camera = b.images.camera[b.observations.image]
    for i, c in enumerate(b.cameras):
        mine = camera == i
        if not mine.any():
            continue
        reduced = b.observations.xy[mine] - [c.x0_mm, c.y0_mm]
        radius = np.hypot(*reduced.T)
        direction = reduced / np.where(radius > 0.0, radius, 1.0)[:, None]
        across = np.column_stack([-direction[:, 1], direction[:, 0]])
        v = 1000.0 * a.residuals[mine]
        turned = np.column_stack([np.sum(v * direction, axis=1), np.sum(v * across, axis=1)])
        bounds = np.linspace(0.0, radius.max() * (1.0 + 1e-12), RINGS + 1)
        ring = np.digitize(radius, bounds) - 1
        for j in range(RINGS):
            if (ring == j).any():
                limits = {"camera": c.camera_id, "from_mm": float(bounds[j]), "to_mm": float(bounds[j + 1])}
                found.append(
                    {**limits, "n": int(np.sum(ring == j)), **_moments(turned[ring == j], ("radial", "tangential"))}
                )
    return found


def _moments(v: Floats, names: tuple[str, str]) -> Record:
    mean, rms = v.mean(axis=0), np.sqrt(np.mean(v**2, axis=0))
    return {
        **{f"mean_{name}_um": float(m) for name, m in zip(names, mean, strict=True)},
        **{f"rms_{name}_um": float(m) for name, m in zip(names, rms, strict=True)},
    }
