"""Docstrings as they are: plain text with names in single backticks; a bar or star in a formula is no markup."""

from __future__ import annotations

import re

from sphinx.application import Sphinx

ALIAS = re.compile(r"TypeAliasForwardRef\('(\w+)'\)")
ENUMERATED = re.compile(r"\(?\w{1,3}[.)](?=\s)")
"""what would begin a numbered list, such as the shape (n)"""
MARKUP = re.compile(r"(`[^`]+`)|([|*\\]|_(?=\W|$))")


def escaped(line: str) -> str:
    """The line with every sign escaped that reStructuredText would take for markup, outside of backticks."""
    plain = MARKUP.sub(lambda found: found[1] or "\\" + found[2], line)
    return "\\" + plain if ENUMERATED.match(plain) else plain


def escape(
    app: Sphinx, what: str, name: str, of: object, options: object, lines: list[str]
) -> None:
    """Escape a docstring in place; indented listings, which are literal, get the `::` that they need."""
    plain: list[str] = []
    for number, line in enumerate(lines):
        indented = line.startswith("    ") and line.strip()
        after_text = (
            number > 0
            and not lines[number - 1].strip()
            and plain
            and _is_text(plain)
        )
        if indented and after_text:
            plain += ["::", ""]
        plain.append(line if indented else escaped(line))
    lines[:] = plain


def named(
    app: Sphinx,
    what: str,
    name: str,
    of: object,
    options: object,
    signature: str | None,
    returned: str | None,
) -> tuple[str | None, str | None]:
    """A signature with an alias such as Floats by its name, also where it stands inside a tuple."""
    plain = (
        ALIAS.sub(r"\1", text) if text else text for text in (signature, returned)
    )
    return next(plain), next(plain)


def _is_text(plain: list[str]) -> bool:
    """Whether the last line that is not empty is running text."""
    last = next((line for line in reversed(plain) if line.strip()), "")
    return bool(last) and not last.startswith("    ")


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("autodoc-process-docstring", escape)
    app.connect("autodoc-process-signature", named)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
