"""Factors of a study: a name, where it acts in the scenario, and how a level is put there."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from simfield.block import nearest
from simfield.scenario import ScenarioError, put
from studies.design.study import Factor, Study, StudyError

NAMED: Mapping[str, Factor] = {
    name: Factor((path,), times)
    for name, path, times in (
        ("noise_um", "noise.image_um", False),
        ("noise_times", "noise.image_um", True),
        ("assumed_um", "noise.assumed_um", False),
        ("geodetic_mm", "noise.geodetic_mm", False),
        ("scale", "flights[*].scale", False),
        ("scale_times", "flights[*].scale", True),
        ("forward_overlap", "flights[*].forward_overlap", False),
        ("sidelap", "flights[*].sidelap", False),
        ("strips", "flights[*].strips", False),
        ("images_per_strip", "flights[*].images_per_strip", False),
        ("headings_gon", "flights[*].headings_gon", False),
        ("spacing_m", "field.spacing_m", False),
        ("points_per_side", "field.per_side", False),
        ("group_size", "field.group_size", False),
        ("relief_m", "field.relief.sigma_m", False),
        ("control", "control.layout", False),
        ("control_sigma_xy_mm", "control.sigma_xy_mm", False),
        ("control_sigma_z_mm", "control.sigma_z_mm", False),
        ("chain", "chain", False),
        ("chain_without", "chain.without", False),
        ("film_field_um", "chain.film_field.sigma_um", False),
        ("inner_orientation", "reductions.inner", False),
    )
}
"""names that need no [factors] table"""


def factor_named(name: str, study: Study) -> Factor:
    """The factor of that name: declared in [factors], one of NAMED, or a dotted path itself. Raises StudyError."""
    if name in study.factors:
        declared = study.factors[name]
        return Factor((declared,)) if isinstance(declared, str) else declared
    if name in NAMED:
        return NAMED[name]
    if "." in name or "[" in name:
        return Factor((name,))
    raise StudyError(f"unknown factor{nearest(name, [*study.factors, *NAMED])}, or a dotted path of the scenario")


def level_value(level: Any) -> Any:
    """What a level puts into the scenario: {label = "all round", value = [...]} is its value under a name."""
    return level["value"] if _is_labelled(level) else level


def level_label(level: Any) -> str | float | bool:
    """A level as it stands in a table's column."""
    if _is_labelled(level):
        return str(level["label"])
    if isinstance(level, str | bool | int | float):
        return level
    return json.dumps(level, ensure_ascii=False)


def canonical(value: Any) -> Any:
    """A level with 3 and 3.0 made the same, for hashes and comparisons."""
    if isinstance(value, bool) or value is None or isinstance(value, str):
        return value
    if isinstance(value, int | float):
        return float(value)
    if isinstance(value, Mapping):
        return {str(k): canonical(v) for k, v in sorted(value.items())}
    return [canonical(v) for v in value]


def canonical_text(value: Any) -> str:
    return json.dumps(canonical(value), sort_keys=True, separators=(",", ":"))


def put_level(table: dict[str, Any], factor: Factor, level: Any) -> None:
    """Put a level into the table of a scenario, in place. Raises ScenarioError where it does not fit."""
    value = json.loads(json.dumps(level_value(level)))
    for path in factor.paths:
        if factor.times:
            _multiply(table, path, value)
        else:
            put(table, path, value)


def _multiply(table: dict[str, Any], path: str, by: Any) -> None:
    if isinstance(by, bool) or not isinstance(by, int | float):
        raise ScenarioError(f"{path}: found {by!r}, allowed: a number to multiply with")
    for place, old in _found(table, path):
        numbers = list(old.values()) if isinstance(old, Mapping) else [old]
        if any(isinstance(number, bool) or not isinstance(number, int | float) for number in numbers):
            raise ScenarioError(f"{place}: there is no number to multiply")
        put(table, place, {k: v * by for k, v in old.items()} if isinstance(old, Mapping) else old * by)


def _found(table: Any, path: str) -> list[tuple[str, Any]]:
    """(path without *, value) of everything that a path leads to; a missing name is refused."""
    if "[*]" in path:
        head, _, tail = path.partition("[*]")
        holder = _found(table, head)[0][1]
        if not isinstance(holder, list):
            raise ScenarioError(f"{path}: {head} is no list")
        return [pair for i in range(len(holder)) for pair in _found(table, f"{head}[{i}]{tail}")]
    probe = json.loads(json.dumps(table))
    put(probe, path, None)  # refuses a path that leads nowhere
    node = table
    for step in path.replace("]", "").replace("[", ".").split("."):
        try:
            node = node[int(step)] if isinstance(node, list) else node[step]
        except (KeyError, IndexError, ValueError, TypeError):
            raise ScenarioError(f"{path}: there is nothing to multiply") from None
    return [(path, node)]


def _is_labelled(level: Any) -> bool:
    return isinstance(level, Mapping) and set(level) == {"label", "value"}
