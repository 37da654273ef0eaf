"""The memory in which blocks of trials are solved, laid out for the kernels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from adjust.adjustment import Adjustment
from adjust.trials import gradient_compiled as kernels, lane_copies_compiled as lane_copies
from adjust.trials.gradient_compiled import TILES
from simfield.block import Floats
from simfield.numerics import TOGETHER, WIDTH, WIDTH_SINGLE, Arena


@dataclass(frozen=True, eq=False)
class Workspace:
    """The arrays that one block of trials after another is computed in; nothing in them outlives a block.

    Trial t of a block is lane t % WIDTH of tile t // WIDTH, the last and the first axis of all but scaled and change,
    which are (f, TOGETHER) for the matrix product.
    """

    x: Floats
    y: Floats
    start: Floats
    gradient: Floats
    given: Floats
    fill: Callable[[slice, Floats], None]
    first: npt.NDArray[np.float32]
    scaled: npt.NDArray[np.float32]
    change: npt.NDArray[np.float32]
    xy: Floats
    turns: Floats
    contexts: tuple[Floats, ...]
    sums: tuple[Floats, ...]

    @classmethod
    def of(cls, nominal: Adjustment, free: int, image_points: Any, arena: Arena) -> Workspace:
        """For trials image_points (t, k, 2) of the geometry of `nominal`, in which `free` unknowns are free.

        Every array is written before it is read, so what the arena's memory was used for before does not matter.
        """
        layout = nominal.layout
        images, size = len(layout.block.images), len(nominal.x)
        widths = [len(s.model.parameters) for s in layout.sets]

        def tiles(*shape: int) -> Floats:
            return arena.array(TILES, *shape, WIDTH)

        room = cls(
            fill=_lanes_of(image_points, nominal.groups.image_points.order),
            x=tiles(size),
            y=tiles(free),
            start=tiles(size),
            gradient=tiles(size),
            given=tiles(3 * len(layout.block.points)),
            first=arena.array(size, TILES // 2, WIDTH_SINGLE, dtype=np.float32),
            scaled=arena.array(free, TOGETHER, dtype=np.float32),
            change=arena.array(free, TOGETHER, dtype=np.float32),
            xy=tiles(len(layout.block.observations), 2),
            turns=tiles(images, 2),
            contexts=tuple(tiles(images, kernels.PARAMETERS + a) for a in widths),
            sums=tuple(tiles(images, kernels.PULL + a) for a in widths),
        )
        room.start[:] = nominal.x[:, None]
        room.given[:] = (layout.block.points.coordinates - layout.origin).reshape(-1, 1)
        return room

    def begin(self, trials: slice) -> None:
        """Fetch the image coordinates of at most TOGETHER trials and go back to the start."""
        self.fill(trials, self.xy)
        for empty in range(trials.stop - trials.start, TOGETHER):  # a lane without a trial repeats the first one
            self.xy[empty // WIDTH, :, :, empty % WIDTH] = self.xy[0, :, :, 0]
        self.x[:], self.y[:] = self.start, 0.0


def _lanes_of(image_points: Any, order: npt.NDArray[np.intp]) -> Callable[[slice, Floats], None]:
    """A function that writes a slice of trials into lanes (TILES, k, 2, WIDTH), the observations sorted by image."""
    if hasattr(image_points, "fill_lanes"):
        fill: Callable[[slice, Floats], None] = image_points.only(order).fill_lanes
        return fill
    return lambda trials, lanes: lane_copies.transpose(
        np.ascontiguousarray(image_points[trials], dtype=float), order, lanes
    )
