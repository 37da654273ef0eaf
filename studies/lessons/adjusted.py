"""Adjustments of the lessons: what fails is a sentence, and standard errors can be had before the flight."""

from __future__ import annotations

import numpy as np

from adjust import Adjustment, ApModel, adjust_block
from simfield import Block, Scenario, World, build_world
from simfield.block import Floats
from simfield.numerics import one_thread
from studies.lessons.lesson import SEED, LessonError


def world_of(scenario: Scenario) -> World:
    """The scenario flown with the seed of the lessons. Raises LessonError where it cannot be."""
    try:
        return build_world(scenario, SEED)
    except (ArithmeticError, ValueError) as error:
        raise LessonError(f"this cannot be flown: {error}") from error


def observed(world: World) -> Block:
    """The block of the world's first trial. Raises LessonError where nothing of use was seen."""
    try:
        return world.observe()[0]
    except ValueError as error:
        raise LessonError(f"these images do not make a block: {error}") from error


def adjusted(block: Block, model: ApModel) -> Adjustment:
    """The adjustment. Raises LessonError where it fails."""
    a = adjust_block(block, model)
    if not a.status.ok:
        raise LessonError(f"this block cannot be adjusted: {a.message}")
    return a


def expected_std(a: Adjustment) -> Floats:
    """Standard deviations in the layout of `a.x` as they are expected before anything is measured, without the
    estimated sigma0: roots of the cofactors, which contain the a priori standard deviations.
    """
    with one_thread():
        return np.asarray(np.sqrt(a.cofactors.diagonal))
