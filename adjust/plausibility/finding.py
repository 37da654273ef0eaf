"""What is probably wrong with a block: one value for each finding."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Literal

Severity = Literal["worthless", "doubtful", "note"]
"""whether a result with it is worth nothing, is in doubt, or should be read with it in mind"""
NAMED_MOST = 6


@dataclass(frozen=True)
class Finding:
    """kind: what sort of mistake; place: the rows that it is found in; text: what was seen; advice: what to try."""

    kind: str
    severity: Severity
    place: str
    text: str
    advice: str

    def as_table(self) -> dict[str, str]:
        """Plain values, for JSON."""
        return asdict(self)


def listed(ids: Sequence[str] | Iterable[str]) -> str:
    """The first few ids, and how many more there are."""
    names = list(ids)
    more = len(names) - NAMED_MOST
    return ", ".join(names[:NAMED_MOST]) + (f" and {more} more" if more > 0 else "")
