"""A simulated photogrammetric world with known truth: scenario + seed -> (block, truth).

The story is told by simulate.py.
"""

from simfield.block import Block
from simfield.files import read_block, write_block
from simfield.scenario import Scenario, changed, presets, read_scenario
from simfield.simulate import World, build_world, main_points, simulate
from simfield.truth import Truth, read_truth, write_truth

__all__ = [
    "Block",
    "Scenario",
    "Truth",
    "World",
    "build_world",
    "changed",
    "main_points",
    "presets",
    "read_block",
    "read_scenario",
    "read_truth",
    "simulate",
    "write_block",
    "write_truth",
]
