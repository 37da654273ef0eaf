"""The study file: a question, its factors, methods and trials, read from TOML with every fault named at once.

[study]      name, question, seed
[trials]     geometries, max, min, block (trials a shard, a multiple of 32), target_mcse = {measure = standard error}
[scenario]   preset and changes to it, as in a scenario file
[factors]    own names for dotted paths of the scenario: lens = {paths = ["effects[0].effect.k1"], times = true}
[grid]       crossed factors with their levels        [[zip]]      factors that move together
[[exclude]]  levels that are left out                 [[include]]  conditions that are added
[methods]    crossed: ap, cameras, aux_points, image_um, control_mm
[paired]     factors that share their random numbers; against = the levels that methods are compared with
[report]     x (a factor), measures to draw, least_correlation
"""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import ConfigDict, TypeAdapter, ValidationError, with_config
from pydantic_core import ErrorDetails

from simfield.block import nearest, shown
from studies.design.study import Factor, Heading, Paired, Report, Study, StudyError, Trials
from studies.design.study_faults import faults_of

LARGEST_FILE = 256 * 1024
LARGEST_NUMBER = 2**63 - 1


def read_study(path: Path | str) -> Study:
    """Read a study file. Raises StudyError with one line for each fault, and OSError if there is no such file."""
    with Path(path).open("rb") as stream:
        raw = stream.read(LARGEST_FILE + 1)
    try:
        return study_from_text(_decoded(raw))
    except StudyError as error:
        raise StudyError("\n".join(f"{path}: {line}" for line in str(error).splitlines())) from None


def study_from_text(text: str) -> Study:
    """The study that a TOML text says. Raises StudyError."""
    try:
        table = tomllib.loads(text)
    except RecursionError:
        raise StudyError("no TOML: brackets or tables are nested too deeply") from None
    except ValueError as error:  # tomllib's own, and numbers of thousands of digits
        raise StudyError(f"no TOML: {str(error).splitlines()[0]}") from None
    faults = list(_impossible(table, ""))
    if faults:
        raise StudyError("\n".join(faults))
    return _checked(table, text)


def _decoded(raw: bytes) -> str:
    if len(raw) > LARGEST_FILE:
        raise StudyError(f"the file has more than {LARGEST_FILE // 1024} KB, a study file has a few")
    if raw.startswith(b"\xef\xbb\xbf"):
        raise StudyError("line 1: the file begins with a byte-order mark; save it as UTF-8 without one")
    if b"\0" in raw:
        line = raw[: raw.index(0)].count(b"\n") + 1
        raise StudyError(f"line {line}: there is a NUL byte; this is no text file")
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError as error:
        line = raw[: error.start].count(b"\n") + 1
        raise StudyError(f"line {line}: byte {raw[error.start]:#04x} is no UTF-8") from None


def _impossible(node: Any, place: str) -> Iterator[str]:
    """A line for each number that is none, for each that is too long and for each date."""
    if isinstance(node, dict):
        for key, value in node.items():
            yield from _impossible(value, f"{place}.{key}".removeprefix("."))
    elif isinstance(node, list):
        for number, value in enumerate(node):
            yield from _impossible(value, f"{place}[{number}]")
    elif isinstance(node, float) and not math.isfinite(node):
        yield f"{place}: found {node}, allowed: finite numbers"
    elif isinstance(node, int) and abs(node) > LARGEST_NUMBER:
        yield f"{place}: found a whole number beyond 2^63, allowed: smaller ones"
    elif not isinstance(node, str | int | float | bool):
        yield f"{place}: found {shown(node)}, allowed: no dates or times"


def _checked(table: Mapping[str, Any], text: str) -> Study:
    if "text" in table:
        raise StudyError(f"text: unknown key{nearest('text', known_keys())}")
    try:
        study = _adapter().validate_json(json.dumps(table), strict=True)
    except ValidationError as error:
        details = error.errors(include_url=False)
        lines = [_fault_line(d, table) for d in details]
        raise StudyError("\n".join(dict.fromkeys(lines + _further_faults(table, details)))) from None
    except RecursionError:
        raise StudyError("tables are nested too deeply") from None
    faults = faults_of(study)
    if faults:
        raise StudyError("\n".join(dict.fromkeys(faults)))
    return replace(study, text=text)


HANGS_ON = ("grid", "zip", "factors", "methods", "scenario")
"""tables whose entries others speak of; with one of the wrong form, only [study] and [trials] can be judged"""


def _further_faults(table: Mapping[str, Any], details: Sequence[ErrorDetails]) -> list[str]:
    """What else is wrong in a table of the wrong form, seen after its entries of the wrong form are taken out."""
    repaired = json.loads(json.dumps(table))
    for detail in details:
        _take_out(repaired, detail["loc"])
    for name in ("study", "scenario", "methods"):
        repaired.setdefault(name, {})
    heading = repaired["study"]
    for name, value in (("name", "x"), ("question", "x"), ("seed", 0)):
        heading.setdefault(name, value)
    try:
        found = faults_of(_adapter().validate_json(json.dumps(repaired), strict=True))
    except (ValidationError, RecursionError):
        return []
    wrong = {str(detail["loc"][0]) for detail in details if detail["loc"]}
    if wrong & set(HANGS_ON):
        return [line for line in found if line.startswith(("study.", "trials."))]
    return found


def _take_out(table: Any, place: Sequence[int | str]) -> None:
    """Remove the innermost entry of a place that is there."""
    holder, last = None, place[0] if place else ""
    node = table
    for step in place:
        inside = isinstance(node, dict) and step in node
        if not inside:
            break
        holder, last, node = node, step, node[step]
    if holder is not None:
        holder.pop(last, None)


@cache
def _adapter() -> TypeAdapter[Study]:
    tables: tuple[type[Any], ...] = (Study, *TABLES.values())
    for table in tables:
        with_config(ConfigDict(extra="forbid", allow_inf_nan=False))(table)
    return TypeAdapter(Study)


TABLES: Mapping[str, type[Any]] = {
    "study": Heading,
    "trials": Trials,
    "factors": Factor,
    "paired": Paired,
    "report": Report,
}


def known_keys(place: tuple[int | str, ...] = ()) -> list[str]:
    """The keys that the table at a place can have."""
    table = TABLES.get(str(place[0]), Study) if place else Study
    return [f.name for f in fields(table) if f.name != "text"]


def _fault_line(detail: ErrorDetails, table: Any) -> str:
    steps = tuple(s for s in detail["loc"] if s not in ("str", "Factor"))
    place = "".join(f"[{s}]" if isinstance(s, int) else f".{s}" for s in steps).removeprefix(".") or "study"
    if detail["type"] == "unexpected_keyword_argument":
        return f"{place}: unknown key{nearest(str(steps[-1]), known_keys(steps[:-1]))}"
    if detail["type"] == "missing":
        return f"{place}: is missing"
    if steps[0] == "factors":
        return f"{place}: found {shown(detail['input'])}, allowed: a dotted path, or {{paths = [...], times = true}}"
    allowed = detail["msg"].removeprefix("Input should be ").replace("an object", "a table").replace("a valid", "a")
    return f"{place}: found {shown(detail['input'])}, allowed: {allowed.replace('array', 'list')}"
