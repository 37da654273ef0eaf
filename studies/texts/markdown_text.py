"""Text of others in Markdown, and text that keeps numbers and units together."""

from __future__ import annotations

import re

MARKDOWN = str.maketrans({c: f"\\{c}" for c in "\\`*_[]<>|$#~"})
UNIT = re.compile(r"(?<=\d) (?=(?:%|[uµm]m)(?!\w))")


def escaped(text: str) -> str:
    """Text that Markdown and HTML show as it stands, in one line."""
    return " ".join(text.split()).translate(MARKDOWN)


def fenced(text: str) -> str:
    """Text as a block of code, whatever is in it."""
    longest = max((len(run) for run in re.findall("`+", text)), default=0)
    fence = "`" * max(3, longest + 1)
    return f"{fence}\n{text.strip()}\n{fence}\n"


def unbroken(text: str) -> str:
    """The text with spaces between numbers and units at which no line ends."""
    return UNIT.sub("\u00a0", text)
