"""Refusals in words: a value as it is shown, and the known name that an unknown one resembles."""

from __future__ import annotations

import difflib
import json
from collections.abc import Iterable

LONGEST = 60
"""characters of a name or a value that are looked at"""


def resembling(name: object, known: Iterable[str]) -> str:
    """The known name that this one resembles, whatever its case; empty if there is none."""
    lowered = {each.lower(): each for each in sorted(known)}
    near = difflib.get_close_matches(str(name)[:LONGEST].strip().lower(), lowered, n=1)
    return lowered[near[0]] if near else ""


def nearest(name: object, known: Iterable[str], are: str = "known are") -> str:
    """The end of a line about an unknown name: the known name that it resembles, or all of them."""
    known = list(known)
    near = resembling(name, known)
    return f", did you mean {near!r}?" if near else f"; {are} {', '.join(sorted(known))}"


def shown(value: object) -> str:
    """A value as a file would show it, shortened."""
    text = json.dumps(value, default=str)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
