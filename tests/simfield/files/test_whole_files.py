"""A set of files replaces an older one whole or not at all, wherever its writing is cut; nothing older survives."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from simfield import Block, build_world, presets, read_block, read_truth, simulate, write_block, write_truth
from simfield.block.further import Further, Lines, Priors, Stations, Strips
from simfield.chain.measure import prepare
from simfield.chain.presets import chains, without
from simfield.files.columns import ALL_FILES, FURTHER
from simfield.files.raw_folder import read_raw, write_raw
from simfield.files.whole_files import NEW, settle, whole_folder, write_set
from studies.commands.program import main

OLD = {"a.csv": b"old a", "b.csv": b"old b", "c.csv": b"old c"}
FRESH = {"a.csv": b"new a", "b.csv": b"new b", "d.csv": b"new d"}
OWN = ("a.csv", "b.csv", "c.csv", "d.csv")
OPERATIONS = ("write", "fsync", "replace", "mkdir", "unlink", "rmdir")


class Killed(BaseException):
    """Stands for a process that is gone: nothing that it would have done afterwards happens."""


class Cut:
    """The n-th operation on the disk fails with an error number, or the process is killed before it (number None)."""

    def __init__(self, patch: pytest.MonkeyPatch, at: int, number: int | None) -> None:
        self.calls, self.at, self.number, self.dead = 0, at, number, False
        for name in OPERATIONS:
            patch.setattr(os, name, self._counted(getattr(os, name)))

    def _counted(self, real: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **named: Any) -> Any:
            self.calls += 1
            if self.dead or self.calls == self.at:
                if self.number is None:
                    self.dead = True
                    raise Killed
                raise OSError(self.number, os.strerror(self.number))
            return real(*arguments, **named)

        return call


def contents(folder: Path) -> dict[str, bytes]:
    """The files that are in sight, after a set on its way has been brought to its places."""
    settle(folder)
    return {path.name: path.read_bytes() for path in folder.iterdir() if not path.name.startswith(".")}


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EIO, errno.EACCES, None])
def test_cut_at_the_nth_operation_the_old_set_is_whole_or_the_new_one(tmp_path: Path, number: int | None) -> None:
    at, seen = 1, set()
    while True:
        folder = tmp_path / str(at)
        write_set(folder, {**OLD, "stranger.txt": b"mine"}, OWN)
        with pytest.MonkeyPatch.context() as patch:
            cut = Cut(patch, at, number)
            with contextlib.suppress(OSError, Killed):
                write_set(folder, FRESH, OWN)
            whole = cut.calls < at
        found = contents(folder)
        assert found.pop("stranger.txt") == b"mine"
        assert found in (OLD, FRESH), f"operation {at}"
        seen.add(found == FRESH)
        write_set(folder, FRESH, OWN)
        assert contents(folder) == {**FRESH, "stranger.txt": b"mine"}
        assert [path.name for path in folder.iterdir() if path.name.startswith(".")] == []
        if whole:
            break
        at += 1
    assert at > 15
    assert seen == {True, False}


def test_an_exception_inside_leaves_the_old_set(tmp_path: Path) -> None:
    write_set(tmp_path, OLD, OWN)
    new = whole_folder(tmp_path, OWN)
    (new.__enter__() / "a.csv").write_bytes(b"half")
    failure = ZeroDivisionError()
    assert not new.__exit__(ZeroDivisionError, failure, None)
    assert contents(tmp_path) == OLD


def test_a_folder_in_the_place_of_a_file_is_refused_before_anything_is_moved(tmp_path: Path) -> None:
    write_set(tmp_path, OLD, OWN)
    (tmp_path / "d.csv").mkdir()
    with pytest.raises(IsADirectoryError):
        write_set(tmp_path, FRESH, OWN)
    assert {n: (tmp_path / n).read_bytes() for n in OLD} == OLD


@pytest.fixture(scope="module")
def flown() -> Any:
    world = build_world(presets["grid-small"], 7)
    return world.observe(0)


@pytest.fixture(scope="module")
def measured() -> Any:
    chain = chains["psk-1969"]
    world = build_world(presets["rheidt-1980"], 7)
    return [prepare(world, each).measure(0) for each in (chain, without(chain, "lens"))]


def everything(block: Block) -> Block:
    """The block with a file of every kind of further observation."""
    line = Lines(np.array([0]), np.array([1]), np.array([100.0]), np.array([0.01]))
    nan = np.full((1, 3), np.nan)
    stations = Stations(np.array([0]), np.array([0]), np.array([0.0]), np.ones((1, 3)), np.ones((1, 3)), nan, nan)
    priors = Priors(np.array([0]), ("a1",), np.array([0.0]), np.array([1.0]))
    return replace(block, further=Further(Strips(("s",), ("offset",), ("none",)), stations, line, line, priors))


def test_what_a_measured_file_does_not_have_does_not_survive(measured: Any, tmp_path: Path) -> None:
    with_lens, without_lens = measured
    write_raw(with_lens, tmp_path)
    assert read_raw(tmp_path).certificates
    write_raw(without_lens, tmp_path)
    assert not (tmp_path / "certificates.csv").exists()
    assert read_raw(tmp_path).certificates == {}


@pytest.mark.parametrize("name", list(FURTHER))
def test_no_further_observations_survive_in_a_block_without(name: str, flown: Any, tmp_path: Path) -> None:
    block, _ = flown
    write_block(everything(block), tmp_path)
    assert (tmp_path / f"{name}.csv").exists()
    write_block(block, tmp_path)
    assert not (tmp_path / f"{name}.csv").exists()
    assert not len(getattr(read_block(tmp_path).further, name))


def test_no_truth_of_another_flight_survives(flown: Any, tmp_path: Path) -> None:
    block, truth = flown
    write_block(block, tmp_path)
    write_truth(truth, tmp_path)
    assert read_truth(tmp_path).seed == 7
    write_block(simulate(presets["grid-small"], 8)[0], tmp_path)
    assert not (tmp_path / "truth.json").exists()


def test_block_and_measured_file_over_each_other(flown: Any, measured: Any, tmp_path: Path) -> None:
    """They share file names: what remained of one would be read with the other."""
    block, _ = flown
    write_raw(measured[0], tmp_path)
    write_block(everything(block), tmp_path)
    assert {p.name for p in tmp_path.iterdir()} == {
        f"{n}.csv" for n in ("cameras", "images", "points", "observations")
    } | {f"{n}.csv" for n in FURTHER}
    write_raw(measured[1], tmp_path)
    assert not (tmp_path / "observations.csv").exists()
    assert {p.name for p in tmp_path.iterdir()} <= set(ALL_FILES)


@pytest.mark.parametrize("number", [errno.ENOSPC, None])
def test_a_block_cut_in_its_writing_is_the_old_one_or_the_new_one(
    flown: Any, tmp_path: Path, number: int | None
) -> None:
    old, new = everything(flown[0]), simulate(presets["grid-small"], 8)[0]
    seen = set()
    for at in (*range(1, 12), *range(12, 60, 3)):
        folder = tmp_path / str(at)
        write_block(old, folder)
        with pytest.MonkeyPatch.context() as patch:
            Cut(patch, at, number)
            with contextlib.suppress(ValueError, Killed):
                write_block(new, folder)
        read = read_block(folder)
        is_new = np.array_equal(read.observations.xy, new.observations.xy)
        assert is_new or np.array_equal(read.observations.xy, old.observations.xy)
        assert bool(len(read.further.distances)) != is_new
        seen.add(is_new)
    assert seen == {True, False}


def test_the_command_replaces_one_flight_by_another(tmp_path: Path) -> None:
    for seed in ("1", "2"):
        done = CliRunner().invoke(main, ["simulate", "grid-small", "--seed", seed, "-o", str(tmp_path / "b")])
        assert done.exit_code == 0, done.output
        assert read_truth(tmp_path / "b").seed == int(seed)
        assert read_truth(tmp_path / "b").point_ids == read_block(tmp_path / "b").points.ids
    assert not (tmp_path / "b" / NEW).exists()


def test_a_protocol_is_not_written_into_its_block(flown: Any, tmp_path: Path) -> None:
    write_block(flown[0], tmp_path)
    before = contents(tmp_path)
    done = CliRunner().invoke(main, ["adjust", str(tmp_path), "--ap", "none", "-o", str(tmp_path)])
    assert done.exit_code == 2
    assert "holds a block" in done.output
    assert contents(tmp_path) == before
