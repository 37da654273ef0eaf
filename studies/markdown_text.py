"""Text of others in Markdown."""

from __future__ import annotations

import re

MARKDOWN = str.maketrans({c: f"\\{c}" for c in "\\`*_[]<>|$#~"})


def escaped(text: str) -> str:
    """Text that Markdown and HTML show as it stands, in one line."""
    return " ".join(text.split()).translate(MARKDOWN)


def fenced(text: str) -> str:
    """Text as a block of code, whatever is in it."""
    longest = max((len(run) for run in re.findall("`+", text)), default=0)
    fence = "`" * max(3, longest + 1)
    return f"{fence}\n{text.strip()}\n{fence}\n"
