"""A block folder is written whole, touches nothing else, and refuses what it could not read again."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from simfield.block.block import Block, Points
from simfield.files.block_folder import BlockFolderError, read_block, write_block
from tests.simfield.files.test_block_folder import FILES, contents, folder as folder


def test_writing_touches_only_the_four_files_and_leaves_nothing_behind(folder: Path) -> None:
    (folder / "notes.txt").write_text("mine")
    block = read_block(folder)
    for name in FILES:
        (folder / name).write_text("old")
    write_block(block, folder)
    assert contents(folder) == FILES | {"notes.txt": "mine"}


def test_a_link_is_replaced_not_followed(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    outside = tmp_path_factory.mktemp("outside") / "victim.csv"
    outside.write_text("precious")
    block = read_block(folder)
    (folder / "points.csv").unlink()
    (folder / "points.csv").symlink_to(outside)
    write_block(block, folder)
    assert outside.read_text() == "precious"
    assert not (folder / "points.csv").is_symlink()


@pytest.mark.parametrize("at", [1, 2, 3, 4])
def test_a_full_disk_leaves_the_old_block_whole(folder: Path, monkeypatch: pytest.MonkeyPatch, at: int) -> None:
    block = read_block(folder)
    calls = 0

    def full(_: int) -> None:
        nonlocal calls
        calls += 1
        if calls == at:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(BlockFolderError, match=f"{folder}: cannot be written: No space left on device"):
        write_block(block.replace_image_points(block.observations.xy + 1.0), folder)
    assert contents(folder) == FILES
    monkeypatch.undo()
    write_block(block, folder)
    assert contents(folder) == FILES


def test_a_file_in_place_of_the_folder_is_refused(folder: Path) -> None:
    block = read_block(folder)
    with pytest.raises(BlockFolderError, match=r"cameras\.csv: cannot be written: File exists"):
        write_block(block, folder / "cameras.csv")
    with pytest.raises(BlockFolderError, match=r"deeper: cannot be written: (Not a directory|File exists)"):
        write_block(block, folder / "cameras.csv" / "deeper")


@pytest.mark.parametrize("name", ["nul\0", "old\rmac", "half\ud800", "x" * 200_000])
def test_a_name_that_no_text_file_can_hold_is_refused_before_writing(folder: Path, name: str) -> None:
    block = read_block(folder)
    points = Points(("1", name, "3"), block.points.role, block.points.coordinates, block.points.sigma)
    named = Block(block.cameras, block.images, points, block.observations)
    with pytest.raises(BlockFolderError) as caught:
        write_block(named, folder / "new")
    assert (caught.value.row, caught.value.column) == (3, "point_id")
    assert len(str(caught.value)) < 500
    str(caught.value).encode()
    assert not (folder / "new").exists()
