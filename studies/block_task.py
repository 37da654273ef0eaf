"""The smallest unit of work: one block of trials of one condition, adjusted by every method, written as a shard."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from simfield.block import BlockError, Floats
from simfield.measurement import CountError
from simfield.simulate import World, build_world
from studies.conditions import Condition
from studies.methods import Method
from studies.store import NOMINAL, Store

if TYPE_CHECKING:
    from studies.parts import Part

Draw = Callable[[World, Sequence[int]], Floats]
Columns = dict[str, npt.NDArray[Any]]
BEFORE = "|"
"""stands between method and quantity in a column's name"""


@dataclass(frozen=True)
class BlockTask:
    """Trials first .. stop - 1 of a condition; lost: trials that are not computed any more, and what became of them."""

    condition: Condition
    methods: tuple[Method, ...]
    block: int
    first: int
    stop: int
    lost: Mapping[int, str] = field(default_factory=dict)

    def __len__(self) -> int:
        return self.stop - self.first

    @property
    def name(self) -> tuple[str, int]:
        return self.condition.id, self.block


def image_points(world: World, trials: Sequence[int]) -> Floats:
    """(t, k, 2) measured image coordinates of some trials, mm: the one place where trials are drawn."""
    runs = np.split(np.asarray(trials), np.flatnonzero(np.diff(trials) != 1) + 1)
    return np.concatenate([world.draws(int(run[0]), int(run[-1]) + 1)[:] for run in runs])


def run_task(store: Store, draw: Draw, task: BlockTask) -> int:
    """Compute a block and write its shard; the number of its trials. Raises OSError where it cannot be written."""
    from studies.worker import prepare

    prepare()
    columns, nominal, reasons = compute(task, draw)
    if task.block == 0:
        store.write_shard(task.condition.id, NOMINAL, nominal)
        if reasons:
            store.mark_reasons(task.condition.id, reasons)
    store.write_shard(task.condition.id, task.block, columns)
    return len(task)


def compute(task: BlockTask, draw: Draw = image_points) -> tuple[Columns, Columns, dict[str, str]]:
    """The columns of a block, the nominal columns of its condition, and why methods have none."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):  # two threads would change the last bits
        try:
            world = build_world(task.condition.scenario, task.condition.seed)
        except (CountError, ArithmeticError, ValueError) as error:
            nothing = {m.key: _nothing(task) for m in task.methods}
            return _flat(nothing), _flat({}), dict.fromkeys(nothing, str(error))
        xy, given, undrawn = _drawn(world, task, draw)
        trials, nominal, reasons = {}, {}, {}
        rays: dict[tuple[str, bool], Floats] = {}
        for method in task.methods:
            try:
                trials[method.key], nominal[method.key] = _adjusted(world, method, xy, given, rays)
            except (BlockError, ValueError) as error:
                trials[method.key], reasons[method.key] = _nothing(task), str(error)
            _blot_out(trials[method.key], task, {**task.lost, **undrawn})
    return _flat(trials), _padded(_flat(nominal)), reasons


def _drawn(world: World, task: BlockTask, draw: Draw) -> tuple[Floats, Floats, dict[int, str]]:
    """Image points (t, k, 2) mm, given coordinates (t, n, 3) m, and the trials that cannot be drawn.

    Lost trials are replaced by the world without noise. They keep their place, so that no other trial changes its
    neighbours in the computation.
    """
    kept = [trial for trial in range(task.first, task.stop) if trial not in task.lost]
    rows = [trial - task.first for trial in kept]
    xy = np.repeat(world.distorted[None], len(task), axis=0)
    given = np.repeat(world.field.coordinates[world.place][None], len(task), axis=0)
    undrawn = {}
    if kept:
        try:
            xy[rows] = draw(world, kept)
        except (ArithmeticError, ValueError):  # such as a film deformation that is too steep
            undrawn = _draw_one_by_one(world, draw, task.first, kept, xy)
        given[rows] = np.stack([world.given_coordinates(trial) for trial in kept])
    return xy, given, undrawn


def _draw_one_by_one(world: World, draw: Draw, first: int, trials: Sequence[int], xy: Floats) -> dict[int, str]:
    undrawn = {}
    for trial in trials:
        try:
            xy[trial - first] = draw(world, [trial])[0]
        except (ArithmeticError, ValueError):
            undrawn[trial] = "undrawn"
    return undrawn


def _adjusted(
    world: World, method: Method, xy: Floats, given: Floats, rays: dict[tuple[str, bool], Floats]
) -> tuple[Columns, Columns]:
    """The columns of a method's trials and its nominal columns; `rays` keeps the image points of parts seen before."""
    from adjust.replicates import adjust_replicates
    from studies.parts import Part
    from studies.trial_columns import nominal_columns, trial_columns

    part: Part = Part.of(world, method)
    which = (method.cameras, method.aux_points)
    if which not in rays:
        rays[which] = xy if len(part.rays) == xy.shape[1] else np.take(xy, part.rays, axis=1)
    own_given = given[:, part.points]
    replicates = adjust_replicates(part.block, method.ap_model(), rays[which], coordinates=own_given)
    return dict(trial_columns(replicates, part, own_given)), dict(nominal_columns(replicates.nominal, part))


def _nothing(task: BlockTask) -> Columns:
    from studies.trial_columns import NO_NOMINAL

    return {"status": np.full(len(task), NO_NOMINAL, dtype=np.int8)}


def _blot_out(columns: Columns, task: BlockTask, lost: Mapping[int, str]) -> None:
    """What was computed in the place of lost trials is no result."""
    from studies.trial_columns import LOST

    for trial, fate in lost.items():
        if task.first <= trial < task.stop:
            for values in columns.values():
                values[trial - task.first] = LOST[fate] if values.dtype == np.int8 else np.nan


def _flat(by_method: Mapping[str, Columns]) -> Columns:
    return {f"{key}{BEFORE}{name}": values for key, columns in by_method.items() for name, values in columns.items()}


def _padded(columns: Columns) -> Columns:
    """All columns of one length, filled up with NaN."""
    rows = max((len(values) for values in columns.values()), default=0)
    return {name: np.pad(v, (0, rows - len(v)), constant_values=np.nan) for name, v in columns.items()}
