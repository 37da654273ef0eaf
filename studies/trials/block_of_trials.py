"""What a block of trials comes to: those of one condition, drawn, adjusted by every method, turned into columns."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from adjust.trials import replicates
from simfield import World
from simfield.block import Floats
from simfield.numerics import WIDTH, Arena, one_thread
from simfield.world import CountError
from studies.design import BlockTask
from studies.store import BEFORE, LOST, NO_NOMINAL, Columns
from studies.trials.drawn_trials import DrawnTrials, image_points, put, repeated
from studies.trials.geometry import PreparedMethod, geometry_of
from studies.trials.trial_columns import nominal_columns, trial_columns

Draw = Callable[[World, Sequence[int]], Floats]
"""draws trials as `drawn_trials.image_points` does"""
_alone = threading.Lock()
"""a worker of a cluster may have several threads; the number of BLAS threads is the whole process's"""


def compute(task: BlockTask, draw: Draw = image_points) -> tuple[Columns, Columns, dict[str, str]]:
    """The columns of a block, with block 0 the nominal columns of its condition, and why methods have none."""
    with _alone, one_thread():  # two threads would change the last bits
        try:
            geometry = geometry_of(task.condition)
        except (CountError, ArithmeticError, ValueError) as error:
            nothing = {m.key: _nothing(task) for m in task.methods}
            return _flat(nothing), _flat({}), dict.fromkeys(nothing, str(error))
        tiles, given, undrawn = _drawn(geometry.world, task, draw)
        trials, nominal, reasons = {}, {}, {}
        for method in task.methods:
            try:
                prepared = geometry.prepared(method)
                trials[method.key] = _adjusted(prepared, tiles, given, len(task), geometry.arena)
                if task.block == 0:
                    nominal[method.key] = dict(nominal_columns(prepared.chord.nominal, prepared.tracked))
            except ValueError as error:
                trials[method.key], reasons[method.key] = _nothing(task), str(error)
            _blot_out(trials[method.key], task, {**task.lost, **undrawn})
    return _flat(trials), _padded(_flat(nominal)), reasons


def _drawn(world: World, task: BlockTask, draw: Draw) -> tuple[Floats, Floats | None, dict[int, str]]:
    """Image points (tiles, k, 2, 8) mm, given coordinates (t, n, 3) m, and the trials that cannot be drawn.

    Lost trials are replaced by the world without noise. They keep their place, so that no other trial changes its
    neighbours in the computation.
    """
    everyone = range(task.first, task.stop)
    kept: Sequence[int] = [t for t in everyone if t not in task.lost] if task.lost else everyone
    undrawn: dict[int, str] = {}
    try:
        tiles = _placed(world, task, kept, draw)
    except (ArithmeticError, ValueError):  # such as a film deformation that is too steep
        drawable = [trial for trial in kept if _can_be_drawn(world, draw, trial)]
        undrawn = {trial: "undrawn" for trial in kept if trial not in drawable}
        tiles = _placed(world, task, drawable, draw)
    return tiles, _given(world, kept, task), undrawn


def _placed(world: World, task: BlockTask, trials: Sequence[int], draw: Draw) -> Floats:
    """Trials in their places of a block, the world without noise in all others."""
    if len(trials) == len(task):
        return draw(world, trials)
    tiles = repeated(world.distorted, len(task))
    if trials:
        drawn = draw(world, trials)
        for number, trial in enumerate(trials):
            put(tiles, [trial - task.first], drawn[number // WIDTH, :, :, number % WIDTH][None])
    return tiles


def _can_be_drawn(world: World, draw: Draw, trial: int) -> bool:
    try:
        draw(world, [trial])
    except (ArithmeticError, ValueError):
        return False
    return True


def _given(world: World, trials: Sequence[int], task: BlockTask) -> Floats | None:
    """(t, n, 3) coordinates that the surveyor gave in every trial, those of lost trials true, m; None where the survey
    is without errors.
    """
    if world.scenario.noise.geodetic_mm == 0.0:
        return None
    given = np.repeat(world.field.coordinates[world.place][None], len(task), axis=0)
    for trial in trials:
        given[trial - task.first] = world.given_coordinates(trial)
    return given


def _adjusted(prepared: PreparedMethod, tiles: Floats, given: Floats | None, count: int, arena: Arena) -> Columns:
    """The columns of a method's trials."""
    part = prepared.part
    own = None if given is None else given.take(part.points, axis=1, mode="clip")
    drawn = DrawnTrials(tiles, count, part.rays)
    adjusted = replicates.adjust_prepared(prepared.chord, drawn, coordinates=own, arena=arena)
    of_all = part.block.points.coordinates[None].copy() if own is None else own  # the compiled loop takes no frozen one
    return dict(trial_columns(adjusted, part, prepared.tracked, of_all))


def _nothing(task: BlockTask) -> Columns:
    return {"status": np.full(len(task), NO_NOMINAL, dtype=np.int8)}


def _blot_out(columns: Columns, task: BlockTask, lost: Mapping[int, str]) -> None:
    """What was computed in the place of lost trials is no result."""
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
