"""How far a long computation has come, on stderr."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, NoReturn, TextIO

if TYPE_CHECKING:
    from tqdm import tqdm

SELDOM_S = 60.0
"""between two lines where stderr is no terminal"""


class _Lines:
    """A stream that gets every state of a bar as a line of its own, for logs."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream

    def write(self, text: str) -> None:
        if text.strip():
            self.stream.write(text.strip() + "\n")

    def flush(self) -> None:
        self.stream.flush()


def progress_bar(total: int, unit: str) -> tqdm[NoReturn]:
    """A bar that is redrawn on a terminal, and a line a minute elsewhere."""
    from tqdm import tqdm

    if sys.stderr.isatty():
        return tqdm(total=total, unit=unit, file=sys.stderr, mininterval=0.1, leave=False)
    lines: TextIO = _Lines(sys.stderr)  # type: ignore[assignment]
    return tqdm(total=total, unit=unit, file=lines, mininterval=SELDOM_S, maxinterval=2 * SELDOM_S,
                leave=False, ascii=True, ncols=78)  # fmt: skip
