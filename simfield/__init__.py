"""A simulated photogrammetric world with known truth: scenario + seed -> (block, truth)."""

from simfield.block.block import Block
from simfield.files.block_folder import read_block, write_block
from simfield.scenario.presets import presets
from simfield.scenario.scenario import Scenario
from simfield.scenario.scenario_file import changed, read_scenario
from simfield.simulate import World, build_world, simulate
from simfield.truth import Truth, read_truth, write_truth

__all__ = [
    "Block",
    "Scenario",
    "Truth",
    "World",
    "build_world",
    "changed",
    "presets",
    "read_block",
    "read_scenario",
    "read_truth",
    "simulate",
    "write_block",
    "write_truth",
]
