"""Tables as CSV and Markdown, with digits fixed by column, so that the same figures give the same bytes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from studies.texts.spreadsheet import as_text

DASH = "–"


def write_csv(frame: pd.DataFrame, path: Path, formats: Mapping[str, str]) -> None:
    """Write a table; formats gives a specification such as ".3f" for columns; truth values are true and false."""
    text = pd.DataFrame(
        {as_text(name): [as_text(_cell(v, formats.get(name, ""))) for v in frame[name]] for name in frame.columns}
    )
    text.to_csv(path, index=False, lineterminator="\n", encoding="utf-8")


def markdown(frame: pd.DataFrame, formats: Mapping[str, str] | None = None) -> str:
    """The table in Markdown, numbers to the right, missing values as a dash."""
    given = formats or {}
    cells = {name: [_cell(v, given.get(name, "")) or DASH for v in frame[name]] for name in frame.columns}
    rule = ["---:" if pd.api.types.is_numeric_dtype(frame[name]) else "---" for name in frame.columns]
    lines = [_line(list(cells)), _line(rule), *(_line(row) for row in zip(*cells.values(), strict=True))]
    return "\n".join(lines) + "\n"


def _line(cells: Any) -> str:
    return "| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |"


def _cell(value: Any, form: str) -> str:
    if value is True or value is False:
        return str(value).lower()
    if isinstance(value, float) and value != value:
        return ""
    return format(value, form)
