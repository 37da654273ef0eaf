"""Files that exist if and only if they are whole: a temporary name, fsync, rename, fsync of the folder.

A set of files that belong together goes into its folder as one: all are written into a folder inside it, which is then
renamed to `.new`. Before that instant the old set stands, from it on the new one: whoever finds `.new` brings it to its
places first (`settle`), so that no reader ever sees files of two writings.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

TEMPORARY = ".unfinished"
NEW, GONE = ".new", ".gone"
"""a whole set on its way to its places, and the list in it of names that the set does not have"""


def write_whole(path: Path, content: bytes | bytearray) -> None:
    """Write a file; after a crash at any instant there is the old one, the new one or none. Raises OSError."""
    temporary = path.with_name(f"{path.name}.{os.getpid()}{TEMPORARY}")
    try:
        handle = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW, 0o666)
        try:
            _write_all(handle, content)
            os.fsync(handle)
        finally:
            os.close(handle)
        os.replace(temporary, path)
        sync_folder(path.parent)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise


@contextmanager
def whole_folder(folder: Path, own: Collection[str] = ()) -> Iterator[Path]:
    """An empty folder to write a set of files into; without an exception they replace those of `folder`, as one.

    own: the names that a folder of this kind may have. Those that were not written do not survive from an older set;
    other files stay untouched. Raises OSError, with the old set in its place or the new one.
    """
    make_folder(folder)
    settle(folder)
    for left in folder.glob(f".*{TEMPORARY}"):  # of a writer that died; two at a time are not meant to be
        shutil.rmtree(left, ignore_errors=True)
    staging = folder / f".{os.getpid()}{TEMPORARY}"
    os.mkdir(staging)
    try:
        yield staging
        written = sorted(path.name for path in staging.iterdir())
        _refuse_folders(folder, [*written, *own])
        gone = "".join(f"{name}\n" for name in sorted(set(own) - set(written)))
        (staging / GONE).write_bytes(gone.encode())
        for name in (*written, GONE):
            sync_file(staging / name)
        sync_folder(staging)
        os.replace(staging, folder / NEW)
        sync_folder(folder)
    finally:
        shutil.rmtree(staging, ignore_errors=True)
    settle(folder)


def write_set(folder: Path, contents: Mapping[str, bytes], own: Collection[str] = ()) -> None:
    """Write a set of files by their names, as `whole_folder` does. Raises OSError."""
    with whole_folder(folder, own) as staging:
        for name, content in contents.items():
            write_whole(staging / name, content)


def settle(folder: Path) -> None:
    """Bring a set that was written whole to its places, if its writer was ended in between. Raises OSError."""
    new = folder / NEW
    if not (new / GONE).is_file():
        return
    gone = (new / GONE).read_text(encoding="utf-8").split("\n")[:-1]
    for name in gone:
        (folder / name).unlink(missing_ok=True)
    for path in sorted(new.iterdir()):
        if path.name != GONE:
            os.replace(path, folder / path.name)
    sync_folder(folder)
    (new / GONE).unlink()
    new.rmdir()
    sync_folder(folder)


def _refuse_folders(folder: Path, names: Collection[str]) -> None:
    """Raise IsADirectoryError where a folder stands in the place of a file, before anything is moved."""
    for name in names:
        if (folder / name).is_dir() and not (folder / name).is_symlink():
            raise IsADirectoryError(21, os.strerror(21), str(folder / name))


def make_folder(path: Path) -> None:
    """Make a folder, if there is none, and see to it that it outlasts a crash. Raises OSError."""
    if path.is_dir():
        return
    make_folder(path.parent)
    path.mkdir(exist_ok=True)
    sync_folder(path.parent)


def sync_folder(path: Path) -> None:
    """Bring the names in a folder to the disk."""
    handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def sync_file(path: Path) -> None:
    """Bring the content of a file to the disk."""
    handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def remove_unfinished(folder: Path) -> int:
    """Remove what writers that died have left; the number of files. Only where nobody else writes."""
    left = [path for path in folder.rglob(f"*{TEMPORARY}") if path.is_file()]
    for path in left:
        path.unlink(missing_ok=True)
    return len(left)


def _write_all(handle: int, content: bytes | bytearray) -> None:
    rest = memoryview(content)
    while rest:
        rest = rest[os.write(handle, rest) :]
