"""The studies that ship: files in the folder catalogue/."""

from __future__ import annotations

from pathlib import Path

from simfield.block import nearest
from studies.design.study import Study, StudyError
from studies.design.study_file import read_study

FOLDER = Path(__file__).parent / "catalogue"


def names() -> tuple[str, ...]:
    """The names of the studies that ship."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))


def study(source: str) -> Study:
    """The shipped study of that name, or the study in that file. Raises StudyError."""
    if source in names():
        return read_study(FOLDER / f"{source}.toml")
    path = Path(source)
    if path.suffix != ".toml" and not path.exists():
        raise StudyError(f"no study {source!r}{nearest(source, names())}, or a file that ends in .toml")
    try:
        return read_study(path)
    except OSError as error:
        raise StudyError(f"{path} cannot be read: {error.strerror}") from error
