"""All findings of a block, before and after it is adjusted."""

from __future__ import annotations

from adjust.adjustment import Adjustment
from adjust.plausibility import axes, control, counts, image_plane, result
from adjust.plausibility.finding import Finding
from simfield.block import Block

ORDER = ("worthless", "doubtful", "note")
NO_ADVICE = "undo what else is found; if nothing is, adjust a part of the block, or without some of its control"


def before(block: Block) -> tuple[Finding, ...]:
    """What the tables of a block say, held against each other, the worst first; nothing is adjusted."""
    return _sorted([*counts.findings(block), *image_plane.findings(block), *axes.findings(block)])


def checked(a: Adjustment) -> tuple[Finding, ...]:
    """What its block and the adjustment say together, the worst first. May adjust again, with other tables left out."""
    found = list(before(a.block))
    if a.status.ok:
        found += result.findings(a)
    else:
        found.append(Finding("adjustment", "worthless", "the whole block", a.message, NO_ADVICE))
    if not any(each.kind in ("names exchanged", "coordinates", "axes", "units") for each in found):
        found += control.findings(a)
    return _sorted(found)


def _sorted(found: list[Finding]) -> tuple[Finding, ...]:
    return tuple(sorted(found, key=lambda each: ORDER.index(each.severity)))
