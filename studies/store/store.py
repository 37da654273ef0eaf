"""The store of a study: a folder in which a shard exists if and only if it is whole.

    study.toml        the file that was run, verbatim          manifest.json    what it means, and on what it ran
    trials/<condition>/<block>.parquet, nominal.parquet        failures/<condition>/<trial>.json
    lock              held while the study runs                summary, report: derived, can always be made anew

The folder is the truth, not the manifest: what is not there is computed, what is damaged is computed again.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy.typing as npt

from simfield.files import make_folder, remove_unfinished, write_whole
from studies.design import SCHEMA
from studies.store.shards import MOST_BYTES, Columns, DamageError, decode, encode

NOMINAL = "nominal"
MOST_MANIFEST_BYTES = 64 << 20


class StoreError(RuntimeError):
    """The store is damaged or belongs to another study; one line for each difference."""


class LockedError(RuntimeError):
    """Another run holds the store."""


@dataclass(frozen=True)
class Store:
    """A folder with the shards of one study; identity is the hash of what must not change between runs."""

    folder: Path
    identity: str

    def shard_path(self, condition_id: str, block: int | str) -> Path:
        return self.folder / "trials" / condition_id / f"{block}.parquet"

    def write_shard(self, condition_id: str, block: int | str, columns: Mapping[str, npt.NDArray[Any]]) -> None:
        """Write a whole shard or none. Raises OSError."""
        path = self.shard_path(condition_id, block)
        make_folder(path.parent)
        rows = len(next(iter(columns.values()))) if columns else 0
        write_whole(path, encode(columns, {**self._label(condition_id, block), "rows": rows}))

    def read_shard(self, condition_id: str, block: int | str, most_rows: int) -> Columns:
        """The columns of a shard. Raises FileNotFoundError if there is none, DamageError if it is not whole."""
        path = self.shard_path(condition_id, block)
        if path.is_symlink() or path.stat().st_size > MOST_BYTES:
            raise DamageError("this is no shard but a link or something huge")
        return decode(path.read_bytes(), self._label(condition_id, block), most_rows)

    def begin(self) -> None:
        """Make the folder of the trials. Raises OSError."""
        make_folder(self.folder / "trials")

    @property
    def begun(self) -> bool:
        """Whether trials were begun here; a folder that came without its trials, as from a repository, is new."""
        return (self.folder / "trials").is_dir()

    def _label(self, condition_id: str, block: int | str) -> dict[str, Any]:
        return {"study": self.identity, "condition": condition_id, "block": block, "schema": SCHEMA}

    def mark_failed(self, condition_id: str, trial: int, record: Mapping[str, Any]) -> None:
        """Note that a trial brought its worker down or never ended; it is not tried again. Raises OSError."""
        path = self.folder / "failures" / condition_id / f"{trial}.json"
        make_folder(path.parent)
        write_whole(path, _json(record))

    def mark_reasons(self, condition_id: str, reasons: Mapping[str, str]) -> None:
        """Note why methods of a condition have no results at all. Raises OSError."""
        path = self.folder / "failures" / condition_id / "nominal.json"
        make_folder(path.parent)
        write_whole(path, _json(reasons))

    def failed(self, condition_id: str) -> dict[int, str]:
        """The marked trials of a condition and what became of them. Raises StoreError for a mark that is unreadable."""
        found = {}
        for path in sorted((self.folder / "failures" / condition_id).glob("[0-9]*.json")):
            record = read_json(path)
            if not path.stem.isdecimal() or record.get("status") not in ("crashed", "timeout"):
                raise StoreError(f"{path}: no mark of a failed trial; remove it and run again")
            found[int(path.stem)] = str(record["status"])
        return found

    def write_manifest(self, manifest: Mapping[str, Any]) -> None:
        write_whole(self.folder / "manifest.json", _json(manifest))

    def read_manifest(self) -> dict[str, Any] | None:
        """The manifest, or None in a new store. Raises StoreError if it cannot be read."""
        path = self.folder / "manifest.json"
        return read_json(path) if path.exists() else None


def read_json(path: Path) -> dict[str, Any]:
    """A table from a JSON file of the store. Raises StoreError."""
    try:
        if path.stat().st_size > MOST_MANIFEST_BYTES:
            raise StoreError(f"{path}: too large to be ours")
        table = json.loads(path.read_bytes())
    except (ValueError, RecursionError) as error:
        raise StoreError(f"{path}: damaged: {error}") from None
    if not isinstance(table, dict):
        raise StoreError(f"{path}: damaged: no table")
    return table


def _json(table: Mapping[str, Any]) -> bytes:
    return (json.dumps(table, indent=1, ensure_ascii=False) + "\n").encode()


@contextlib.contextmanager
def locked(folder: Path, part: str = "") -> Iterator[int]:
    """Hold a store: alone, or, for one part of an array job, beside the other parts.

    Gives the number of unfinished files that were swept away. Raises LockedError, StoreError where a link leads out of
    the folder, OSError.
    """
    make_folder(folder)
    for name in ("trials", "failures", "lock", "manifest.json", "study.toml"):
        if (folder / name).is_symlink():
            raise StoreError(f"{folder / name}: is a symbolic link; a store keeps everything inside its own folder")
    with contextlib.ExitStack() as held:
        _hold(held, folder / "lock", fcntl.LOCK_SH if part else fcntl.LOCK_EX)
        if part:
            _hold(held, folder / f"lock.{part}", fcntl.LOCK_EX)
        yield 0 if part else remove_unfinished(folder)


def _hold(held: contextlib.ExitStack, path: Path, mode: int) -> None:
    handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o666)
    held.callback(os.close, handle)
    try:
        fcntl.flock(handle, mode | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
            raise LockedError(f"{path.parent} is in use by another run") from None
        raise
