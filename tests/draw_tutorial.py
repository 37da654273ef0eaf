"""The figures of the tutorial, made by following it: `make docs-figures`."""

from __future__ import annotations

import os
import re
import shutil
import sys
import tempfile
from pathlib import Path

from tests.document_session import Session, pieces
from tests.test_documents import NOT_RUN, SHORTENED

PAGE = Path(__file__).parents[1] / "docs/tutorial.md"
FIGURES = {"curve.svg": "tutorial-curve.svg", "noise/figure.svg": "tutorial-noise.svg"}


def draw(folder: Path) -> None:
    """Follow the tutorial in a directory of its own and copy its figures into the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as empty:
        os.chdir(empty)
        try:
            Session(Path(empty), pieces(PAGE), [re.compile(line) for line in NOT_RUN], SHORTENED).run()
        finally:
            os.chdir(before)
        for made, kept in FIGURES.items():
            shutil.copy(Path(empty) / made, folder / kept)


if __name__ == "__main__":
    draw(Path(sys.argv[1]).absolute())
