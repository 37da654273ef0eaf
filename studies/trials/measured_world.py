"""A world whose images are measured through a chain and reduced: to the trials it is like any other."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from adjust.reductions import ReductionPlan, reduce
from simfield import World, build_world
from simfield.block import Floats
from simfield.chain import Chain, Errors, PreparedChain, prepare
from simfield.disturbances import Noise
from studies.design import Condition, Measuring
from studies.trials.measured_trials import MeasuredTrials

LAST_TRIAL = 2**32 - 1


@dataclass(frozen=True, eq=False)
class MeasuredWorld(World):
    """Image coordinates come from a prepared chain and its reductions; `distorted` is what they give without chance."""

    prepared: PreparedChain
    reductions: ReductionPlan

    def image_points(self, trial: int = 0) -> Floats:
        """(k, 2) reduced image coordinates of a trial, mm."""
        return np.array(reduce(self.prepared.measure(trial), self.reductions).block.observations.xy)

    def undisturbed_image_points(self, trial: int = 0) -> Floats:
        """(k, 2) mm: what is measured but for chance."""
        return self.distorted

    def draws(self, start: int, stop: int) -> MeasuredTrials:  # type: ignore[override]
        """The image coordinates of the trials start .. stop - 1, measured and reduced when they are asked for."""
        return self._trials.between(start, stop)

    @cached_property
    def _trials(self) -> MeasuredTrials:
        return MeasuredTrials(self.prepared, self.reductions, 0, LAST_TRIAL)


def world_of(condition: Condition) -> World:
    """The world of a condition. Raises as `build_world`, and ValueError where the marks do not suffice."""
    world = build_world(condition.scenario, condition.seed)
    return world if condition.measuring is None else _measured(world, condition.measuring)


def _measured(world: World, measuring: Measuring) -> MeasuredWorld:
    flown = {f.name: getattr(world, f.name) for f in fields(World)}
    quiet = replace(world, scenario=replace(world.scenario, film=(), noise=Noise(0.0, assumed_um=1.0)))
    still = prepare(quiet, _without_chance(measuring.chain))
    flown["distorted"] = reduce(still.measure(0), measuring.plan).block.observations.xy
    return MeasuredWorld(**flown, prepared=prepare(world, measuring.chain), reductions=measuring.plan)


def _without_chance(chain: Chain) -> Chain:
    """The chain without what changes from trial to trial."""
    steady = replace(chain.comparator, setting_um=0.0, placement_sigma_deg=0.0, placement_sigma_mm=0.0)
    return replace(chain, film_field=None, errors=Errors(), comparator=steady)
