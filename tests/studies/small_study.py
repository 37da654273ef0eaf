"""A study that runs in a second: 12 images over 25 points, two levels of noise, two methods, blocks of 32 trials."""

from __future__ import annotations

from pathlib import Path

from studies.design.study import Study
from studies.design.study_file import study_from_text
from studies.run.story import How, Outcome, run

TEXT = """
[study]
name = "small"
question = "Does it run?"
seed = 7

[trials]
max = 96
block = 32

[scenario]
preset = "grid-small"
field = { nx = 5, ny = 5, spacing_m = 500.0 }
flights = [{ flight_id = "ring", camera_id = "ww", scale = 11000.0, headings_gon = [0.0, 100.0, 200.0, 300.0] }]
control = { rest = "check" }

[grid]
noise_um = [3.0, 6.0]

[methods]
ap = ["none", "optical"]

[report]
x = "noise_um"
"""


def study(text: str = TEXT, *replaced: tuple[str, str]) -> Study:
    """The small study with some of its text replaced."""
    for old, new in replaced:
        assert old in text
        text = text.replace(old, new)
    return study_from_text(text)


def run_here(folder: Path, asked: Study | None = None, **how: object) -> tuple[Outcome, list[str]]:
    """Run a study in this process; the outcome and what was said."""
    said: list[str] = []
    outcome = run(asked or study(), folder, How(**{"backend": "here", **how}), said.append)  # type: ignore[arg-type]
    return outcome, said


def contents(folder: Path) -> dict[str, bytes]:
    """All files of a store but the manifest and the lock, which may say where it was computed."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != "manifest.json" and not path.name.startswith("lock")
    }
