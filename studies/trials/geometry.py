"""What all trials of a condition share: its world, and for every method its part of the block, adjusted without noise.

A process keeps that of its last condition, so that the blocks of one condition find it ready.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass, field
from functools import cached_property

from adjust.trials import Chord, prepared
from simfield import World
from simfield.block import Block, BlockError
from simfield.numerics import Arena
from studies.design import Condition, Method
from studies.trials.measured_world import world_of
from studies.trials.parts import MethodBlock, noise_free_block
from studies.trials.trial_columns import Tracked


@dataclass(frozen=True, eq=False)
class PreparedMethod:
    """A method made ready for the trials of a condition."""

    part: MethodBlock
    chord: Chord
    tracked: Tracked


@dataclass(frozen=True, eq=False)
class Geometry:
    """The world of a condition, and the methods that were made ready in it; a text says why one cannot be."""

    world: World
    methods: dict[str, PreparedMethod | str] = field(default_factory=dict)
    arena: Arena = field(default_factory=Arena)
    """the memory in which one method after the other adjusts its trials"""

    @cached_property
    def noise_free(self) -> Block:
        """The block without any random error: what all trials are disturbances of."""
        return noise_free_block(self.world)

    def prepared(self, method: Method) -> PreparedMethod:
        """Raises ValueError where the method cannot adjust this block."""
        if method.key not in self.methods:
            try:
                part = MethodBlock.of(self.world, self.noise_free, method)
                chord = prepared(part.block, method.ap_model())
                self.methods[method.key] = PreparedMethod(part, chord, Tracked.of(chord.nominal, part))
            except (BlockError, ValueError) as error:
                self.methods[method.key] = str(error)
        found = self.methods[method.key]
        if isinstance(found, str):
            raise ValueError(found)
        return found


_last: dict[str, Geometry] = {}
_one = threading.Lock()


def geometry_of(condition: Condition) -> Geometry:
    """The geometry of a condition, ready from before if it was the last one asked for. Raises as `build_world`."""
    with _one:
        if condition.id not in _last:
            _last.clear()
            _last[condition.id] = Geometry(world_of(condition))
        return _last[condition.id]


def forget() -> None:
    """Let go of the geometry that is kept."""
    with _one:
        _last.clear()
