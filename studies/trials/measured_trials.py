"""Image coordinates of many trials through the whole measurement chain and its reductions, drawn when asked for.

The fast route to what `simfield.chain.PreparedChain.measure` and `adjust.reductions.reduction.reduce` say trial by
trial: what is deterministic for a geometry is computed once, what is random in compiled loops over blocks of trials. It
agrees with the readable route to 1e-9 mm, and a trial has the same bits in any block.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from adjust.reductions import (
    MEAN_RADIUS_M,
    Frame,
    ReductionPlan,
    Work,
    bending,
    drift_weights,
    marks_of,
    optics,
    through_lens_and_air,
)
from simfield.block import Floats, Indices, Raw
from simfield.chain import PreparedChain, Room, share_of_words, tables
from simfield.disturbances import second_order
from simfield.numerics import TOGETHER, WIDTH, Arena
from simfield.random import counter_key
from studies.trials.measured_trials_compiled import Confusion, Tail, measure_and_reduce

SCRATCH = 1 << 18
"""bytes: about what an image needs to be worked on"""
NEAR_CENTRE_MM = 10.0
"""where a certificate's second order goes with the inverse of the radius, and the formula itself is used"""


@dataclass(frozen=True, eq=False)
class MeasuredTrials:
    """The trials start .. stop - 1 of a prepared chain, reduced by a plan, to be sliced like an array (t, k, 2) in mm.

    plan None: the means of the settings in the machine's frame, not reduced. rows (k): which of the world's
    observations, all if None. Goes into `adjust_replicates` as it is.
    """

    prepared: PreparedChain
    plan: ReductionPlan | None
    start: int
    stop: int
    rows: Indices | None = None

    def __post_init__(self) -> None:
        if self.prepared.chain.errors.missed_rate > 0.0:
            raise ValueError("missed points make every trial a geometry of its own: measure and adjust them one by one")
        if not 0 <= self.start <= self.stop < 2**32:
            raise ValueError(f"trials are numbered from 0 to 2^32 - 1, found {self.start} to {self.stop}")

    def __len__(self) -> int:
        return self.stop - self.start

    def between(self, start: int, stop: int) -> MeasuredTrials:
        """Other trials of the same chain, which share what is computed once."""
        others = replace(self, start=start, stop=stop)
        vars(others)["_tables"] = self._tables
        return others

    def only(self, rows: Indices) -> MeasuredTrials:
        """The same trials of these observations alone, as in a sub-block."""
        return replace(self, rows=np.asarray(rows) if self.rows is None else self.rows[rows])

    def __getitem__(self, trials: slice) -> Floats:
        """(t, k, 2). Raises ValueError for a step other than 1."""
        first, last, step = trials.indices(len(self))
        if step != 1:
            raise ValueError(f"trials come one after the other, found a step of {step}")
        count = max(last - first, 0)
        drawn = np.empty((-(-count // WIDTH), self._count, 2, WIDTH))
        self.fill_lanes(slice(first, first + count), drawn)
        return np.ascontiguousarray(drawn.transpose(0, 3, 1, 2)).reshape(-1, self._count, 2)[:count]

    def fill_lanes(self, trials: slice, lanes: Floats) -> None:
        """Measure into lanes (tiles, k, 2, WIDTH), as `simfield.disturbances.draws.ImagePointDraws.fill_lanes` does."""
        number = self.start + trials.start
        early, tiles = number % TOGETHER, len(lanes)
        if not early and not WIDTH * tiles % TOGETHER:
            self._fill(lanes, number)
            return
        blocks = -(-(early + WIDTH * tiles) // TOGETHER)
        whole = np.empty((blocks * TOGETHER // WIDTH, *lanes.shape[1:]))
        self._fill(whole, number - early)
        in_a_row = whole.transpose(0, 3, 1, 2).reshape(-1, *lanes.shape[1:3])[early : early + WIDTH * tiles]
        lanes[:] = in_a_row.reshape(tiles, WIDTH, *lanes.shape[1:3]).transpose(0, 2, 3, 1)

    @property
    def _count(self) -> int:
        return self.prepared.count if self.rows is None else len(self.rows)

    def _fill(self, lanes: Floats, number: int) -> None:
        parts, kept, places = self._tables
        wide = lanes if kept is None else np.empty((len(lanes), self.prepared.count, 2, WIDTH))
        arena, tiles, marks = Arena(SCRATCH), TOGETHER // WIDTH, parts[1]
        room, work = Room.of(tiles, marks.modes.shape[1], arena), Work.of(tiles, arena)
        mark_xy = arena.zeros(tiles, len(marks.place) // len(self.prepared.world.plan), 2, WIDTH)
        for tile in range(0, len(wide), tiles):
            own = wide[tile : tile + tiles]
            if not measure_and_reduce(own, number + WIDTH * tile, *parts, places, room, work, mark_xy):
                raise ValueError("an error has thrown a point beyond the certificate of its lens")
        if kept is not None:
            lanes[:] = wide[:, kept]

    @cached_property
    def _raw(self) -> Raw:
        """A measured file of this chain: what the reductions know of camera, marks, machine and heights."""
        return self.prepared.measure(0)

    @property
    def _whole(self) -> bool:
        """Whether all observations are measured and some picked afterwards: where points are taken for each other."""
        return self.rows is None or self.prepared.chain.errors.confused_rate > 0.0

    @cached_property
    def _sorted(self) -> Indices:
        """(n) the observations that are measured, sorted by image."""
        image = self.prepared.world.image
        rows = np.arange(self.prepared.count) if self._whole or self.rows is None else self.rows
        return rows[np.argsort(image[rows], kind="stable")]

    @cached_property
    def _tables(self) -> tuple[tuple[Any, ...], Indices | None, Indices]:
        """What the compiled loop wants to know, which of its rows are picked afterwards, and where it puts them."""
        image = self.prepared.world.image
        rows = np.arange(self.prepared.count) if self._whole or self.rows is None else self.rows
        places = np.argsort(image[rows], kind="stable")
        points, marks, session = tables(self.prepared, self._sorted)
        parts = (points, marks, session, self._frame(), self._tail(), self._optics(), self._confusion(places))
        return parts, self.rows if self._whole else None, places

    def _frame(self) -> Any:
        raw, plan, images = self._raw, self.plan, len(self.prepared.world.plan)
        settings = len(raw.mark) // images
        if plan is None:
            return Frame.nothing_reduced(images, settings)
        kinds = np.array(raw.mark_kinds)[raw.mark[:settings]]
        weights = drift_weights(raw.mark_image, raw.mark, raw.mark_time, images)
        scale_x, scale_y, shear = (1e-6 * v if plan.comparator else 0.0 for v in raw.machine)
        return Frame.of(
            plan.inner,
            weights if plan.drift else np.zeros_like(weights),
            (scale_x, scale_y, shear),
            marks_of(raw).reshape(images, settings, 2),
            np.flatnonzero(kinds == "fiducial"),
            plan.reseau_degree or 0,
            np.flatnonzero(kinds == "reseau"),
        )

    def _tail(self) -> Any:
        plan = self.plan
        # before lens and air are taken out, a point lies where it was exposed, but for errors and what is left of film
        place = self.prepared.exposed[self._sorted]
        image = self.prepared.world.image[self._sorted]
        if plan is None or not (plan.lens or plan.refraction or plan.curvature):
            return Tail(
                place, np.zeros_like(place), np.zeros((len(place), 2, 5)), np.ones(len(place), dtype=bool), False
            )

        def removed(xy: Floats) -> Floats:
            return xy - through_lens_and_air(self._raw, plan, xy, image, {})

        smooth = np.hypot(*place.T) > NEAR_CENTRE_MM
        return Tail(place, removed(place), second_order(removed, place), smooth, True)

    def _optics(self) -> Any:
        raw, plan = self._raw, self.plan
        cameras, camera = raw.block.cameras, raw.block.images.camera
        camera_m, ground_m = raw.heights.T
        nothing = np.zeros(len(camera))
        numbers = {c.camera_id: i for i, c in enumerate(cameras)}
        return optics(
            {numbers[name]: own for name, own in raw.certificates.items()} if plan is not None and plan.lens else {},
            camera,
            bending(camera_m, ground_m) if plan is not None and plan.refraction else nothing,
            0.5 * (camera_m - ground_m) / MEAN_RADIUS_M if plan is not None and plan.curvature else nothing,
            np.array([c.c_mm for c in cameras])[camera],
        )

    def _confusion(self, places: Indices) -> Any:
        p, world = self.prepared, self.prepared.world
        share = np.uint64(share_of_words(p.chain.errors.confused_rate))
        key = np.array(counter_key(world.seed, "confused"), dtype=np.uint64)
        if not share:
            none = np.zeros(0, dtype=np.intp)
            return Confusion(
                np.zeros(len(world.plan) + 1, dtype=np.intp), none, none, none.astype(np.uint64), key, share
            )
        at = np.argsort(places)
        image = world.image[p.first_of_pairs]
        ends = np.searchsorted(image, np.arange(len(world.plan) + 1))
        word = p.place_words[p.first_of_pairs]
        return Confusion(ends, at[p.first_of_pairs], at[p.second_of_pairs], word, key, share)
