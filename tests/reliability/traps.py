"""Draws that go wrong on purpose at certain trials, in whatever process computes them."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Sequence

from simfield.block.block import Floats
from simfield.simulate import World
from studies.trials.drawn_trials import image_points

KILLER = 41
SLEEPER = 70


def killing(world: World, trials: Sequence[int]) -> Floats:
    """Trial KILLER takes its process down, every time."""
    if KILLER in trials:
        os.kill(os.getpid(), signal.SIGKILL)
    return image_points(world, trials)


def killing_and_sleeping(world: World, trials: Sequence[int]) -> Floats:
    """The same, and trial SLEEPER never ends."""
    if SLEEPER in trials:
        time.sleep(3600.0)
    return killing(world, trials)


def refusing(world: World, trials: Sequence[int]) -> Floats:
    """Trial KILLER cannot be simulated."""
    if KILLER in trials:
        raise ArithmeticError("too steep")
    return image_points(world, trials)


def slow(world: World, trials: Sequence[int]) -> Floats:
    """Every block takes a while."""
    time.sleep(0.3)
    return image_points(world, trials)
