"""How far a long computation has come, on stderr."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, NoReturn

if TYPE_CHECKING:
    from tqdm import tqdm

SELDOM_S = 60.0
"""between two lines where stderr is no terminal"""


def progress_bar(total: int, unit: str) -> tqdm[NoReturn]:
    """A bar that is redrawn on a terminal, and a line a minute elsewhere."""
    from tqdm import tqdm

    seldom = 0.1 if sys.stderr.isatty() else SELDOM_S
    return tqdm(total=total, unit=unit, file=sys.stderr, mininterval=seldom, maxinterval=2 * SELDOM_S, leave=False)
