"""Faults of a scenario file in words: one line each with the place, what was found and what is allowed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any

from simfield.block import nearest, shown
from simfield.disturbances import EFFECTS, EffectOn, FilmVariation, Noise, by_kind
from simfield.scenario.scenario import Scenario, StartValues
from simfield.world import FIELDS, CameraModel, Control, Flight, Measurement, PointCount, Relief

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

UNKNOWN = "unexpected_keyword_argument"
"""what pydantic calls a key that is not known"""
KINDS = by_kind((*FIELDS, *EFFECTS))

TABLES: Mapping[str, type[Any]] = {
    "cameras": CameraModel,
    "flights": Flight,
    "control": Control,
    "relief": Relief,
    "effects": EffectOn,
    "film": FilmVariation,
    "noise": Noise,
    "measurement": Measurement,
    "counts": PointCount,
    "start": StartValues,
}
"""What stands under these keys, in a list, under free names or by itself."""


def fault_lines(
    details: list[ErrorDetails],
    table: Mapping[str, Any],
    tables: Mapping[str, type[Any]] = TABLES,
    whole: type[Any] = Scenario,
) -> list[str]:
    """One line for each fault; where several types are allowed at one place, pydantic reports each of them.

    tables: what stands under which key; whole: what the table itself says.
    """
    lines: dict[str, str] = {}
    for detail in details:
        steps = _real_steps(detail, table)
        place = _place(steps) or "scenario"
        known = _known_keys(steps[:-1], table, tables, whole) if detail["type"] == UNKNOWN else []
        line = _line(detail, steps, place, known)
        before, allowed = lines.get(place), line.partition(", allowed: ")[2]
        lines[place] = line if not before else f"{before} or {allowed}" if allowed else f"{before}; {line}"
    # Of several allowed types, the one whose inside was looked at is meant.
    return [line for place, line in lines.items() if not any(p.startswith((f"{place}.", f"{place}[")) for p in lines)]


def _line(detail: ErrorDetails, steps: tuple[int | str, ...], place: str, known: list[str]) -> str:
    """One fault in one line: place, what was found, what is allowed."""
    context = detail.get("ctx", {})
    if detail["type"] == UNKNOWN:
        return f"{place}: unknown key{nearest(str(steps[-1]), known)}"
    if detail["type"] == "missing":
        return f"{place}: is missing"
    if detail["type"] == "value_error":
        return str(context["error"]) if place == "scenario" else f"{place}: {context['error']}"
    if detail["type"] == "union_tag_not_found":
        return f"{place}.kind: is missing"
    if detail["type"] == "union_tag_invalid":
        return f"{place}.kind: found {shown(context['tag'])}, allowed: {context['expected_tags']}"
    allowed = detail["msg"].removeprefix("Input should be ").replace("an object", "a table").replace("a valid", "a")
    return f"{place}: found {shown(detail['input'])}, allowed: {allowed}"


def _real_steps(detail: ErrorDetails, table: Any) -> tuple[int | str, ...]:
    """The place without the names of union members that pydantic puts between."""
    steps: list[int | str] = []
    node = table
    names_key = detail["type"] in ("missing", UNKNOWN)
    for number, step in enumerate(detail["loc"], start=1):
        inside = step in node if isinstance(node, Mapping) else isinstance(node, list) and step in range(len(node))
        if inside:
            node = node[step]
        elif number < len(detail["loc"]) or not names_key:
            continue
        steps.append(step)
    return tuple(steps)


def _known_keys(
    steps: tuple[int | str, ...], table: Any, tables: Mapping[str, type[Any]], whole: type[Any]
) -> list[str]:
    """The keys that the table at a place can have."""
    for step in steps:
        table = table[step]
    if isinstance(table, Mapping) and table.get("kind") in KINDS:
        return [f.name for f in fields(KINDS[table["kind"]])]
    named = [tables[step] for step in steps if isinstance(step, str) and step in tables]
    return [f.name for f in fields(named[-1] if named else whole)]


def _place(steps: tuple[int | str, ...]) -> str:
    return "".join(f"[{s}]" if isinstance(s, int) else f".{s}" for s in steps).removeprefix(".")
