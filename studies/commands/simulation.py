"""Simulated blocks for the command line: a preset or a scenario file, flown once and written."""

from __future__ import annotations

from pathlib import Path

from simfield import Scenario, presets, read_scenario, simulate
from simfield.block import nearest
from simfield.files import ALL_FILES, TRUTH_FILE, BlockFolderError, block_files, raw_files, write_set
from simfield.scenario import ScenarioError


class WrongScenarioError(ValueError):
    """There is no such preset or scenario file, or the file says something impossible."""


class SimulationError(RuntimeError):
    """The scenario cannot be flown, or the block cannot be written."""


def scenario(source: str) -> Scenario:
    """The preset of that name, or the scenario in that TOML file. Raises WrongScenarioError."""
    if source in presets:
        return presets[source]
    path = Path(source)
    if path.suffix != ".toml" and not path.exists():
        raise WrongScenarioError(f"no preset {source!r}{nearest(source, presets, 'presets are')}")
    try:
        return read_scenario(path)
    except ScenarioError as error:
        raise WrongScenarioError(str(error)) from error
    except OSError as error:
        raise WrongScenarioError(f"{path} cannot be read: {error.strerror}") from error


def write(source: str, seed: int, trial: int, folder: Path) -> str:
    """Fly a scenario and write block folder and truth.json; a sentence. Raises WrongScenarioError, SimulationError."""
    flown = scenario(source)
    try:
        block, truth = simulate(flown, seed, trial)
        contents = {**block_files(block, folder), TRUTH_FILE: truth.to_json().encode()}
        write_set(folder, contents, ALL_FILES)
    except (ArithmeticError, ValueError, BlockFolderError) as error:
        raise SimulationError(str(error)) from error
    except OSError as error:
        raise SimulationError(f"{error.filename or folder} cannot be written: {error.strerror}") from error
    return (
        f"{folder}: {len(block.images)} images, {len(block.points)} points, {len(block.observations)} image points "
        f"({flown.name}, seed {seed}, trial {trial})"
    )


def write_measured(source: str, chain: str, seed: int, trial: int, folder: Path, left_out: tuple[str, ...] = ()) -> str:
    """Fly a scenario and measure it on a comparator, without the stages left out; write measured file and truth.json.

    Raises as `write`.
    """
    from simfield import build_world
    from simfield.chain import chains, prepare, without

    flown = scenario(source)
    if chain not in chains:
        raise WrongScenarioError(f"no chain {chain!r}, chains are {', '.join(chains)}")
    try:
        world = build_world(flown, seed)
        raw = prepare(world, without(chains[chain], *left_out)).measure(trial)
        contents = {**raw_files(raw), TRUTH_FILE: world.observe(trial)[1].to_json().encode()}
        write_set(folder, contents, ALL_FILES)
    except (ArithmeticError, ValueError, BlockFolderError) as error:
        raise SimulationError(str(error)) from error
    except OSError as error:
        raise SimulationError(f"{error.filename or folder} cannot be written: {error.strerror}") from error
    return (
        f"{folder}: comparator coordinates of {len(raw.block.observations)} image points and "
        f"{len(raw.mark_image)} settings of marks ({flown.name}, {chain}, seed {seed}, trial {trial})"
    )
