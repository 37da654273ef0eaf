"""Scenarios as TOML, and changes to a scenario by dotted path.

A file either says a whole scenario, in the words of the dataclasses, or starts from a preset:

    preset = "rheidt-1980"
    name = "rheidt, no deviations of scale"

    [noise]                       a table changes what it names and leaves the rest
    geodetic_mm = 0.0

    [changes]                     a dotted path changes one value; [*] is every entry of a list
    "flights[0].scale" = 9000.0
    "flights[*].position_sigma_m" = 10.0

A list that a file gives replaces the preset's; so does a table that [changes] gives. Faults are reported all at once,
one line each: place, what was found, what is allowed.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simfield.block import nearest
from simfield.disturbances import EFFECTS
from simfield.scenario.dotted_path import put
from simfield.scenario.preset_scenarios import presets
from simfield.scenario.scenario import Scenario, ScenarioError
from simfield.scenario.scenario_faults import KINDS, TABLES, fault_lines

if TYPE_CHECKING:
    from pydantic import TypeAdapter


def read_scenario(path: Path | str) -> Scenario:
    """Read a scenario file. Raises ScenarioError with one line for each fault, and OSError if there is no such file."""
    try:
        table = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ScenarioError(f"{path}: no TOML: {error}") from error
    try:
        return scenario_from_table(table)
    except ScenarioError as error:
        raise ScenarioError("\n".join(f"{path}: {line}" for line in str(error).splitlines())) from None


def scenario_from_table(table: Mapping[str, Any]) -> Scenario:
    """The scenario that a table says, whole or as a preset with changes. Raises ScenarioError."""
    given = dict(table)
    changes = given.pop("changes", {})
    if not isinstance(changes, dict):
        raise ScenarioError(f"changes: found {changes!r}, allowed is a table of dotted paths and values")
    whole = given
    if "preset" in given:
        name = given.pop("preset")
        if not isinstance(name, str) or name not in presets:
            raise ScenarioError(f"preset: no preset named {name!r}{nearest(name, presets)}")
        whole = merged(scenario_as_table(presets[name]), given)
    return _checked(_with_changes(whole, changes))


def changed(scenario: Scenario, changes: Mapping[str, Any]) -> Scenario:
    """The scenario with some of its values changed: changed(s, {"flights[0].scale": 9000.0, "noise.image_um": 4.0}).

    Raises ScenarioError for a path that the scenario does not have or a value that is not allowed there.
    """
    return _checked(_with_changes(scenario_as_table(scenario), changes))


def scenario_as_table(scenario: Scenario) -> dict[str, Any]:
    """The scenario as nested tables, lists and plain values, as a file would give it.

    Raises ScenarioError for an effect that is none of simfield.disturbances.effects.
    """
    for on in scenario.effects:
        if not isinstance(on.effect, EFFECTS):
            raise ScenarioError(
                f"{type(on.effect).__name__} is none of simfield.disturbances.effects, a file cannot hold it"
            )
    table: dict[str, Any] = json.loads(_json(asdict(scenario)))
    return table


def merged(base: dict[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """A table in which what is given takes the place of what was there, table by table."""
    both = dict(base)
    for key, value in given.items():
        old = both.get(key)
        # Another kind of field or effect shares no keys with the old one.
        if isinstance(old, dict) and isinstance(value, dict) and value.get("kind", old.get("kind")) == old.get("kind"):
            value = merged(old, value)
        both[key] = value
    return both


def _with_changes(table: dict[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    copy: dict[str, Any] = json.loads(_json(table))
    for path, value in changes.items():
        put(copy, path, value)
    return copy


@cache
def _adapter() -> TypeAdapter[Scenario]:
    from pydantic import ConfigDict, TypeAdapter, with_config

    tables: tuple[type[Any], ...] = (Scenario, *TABLES.values(), *KINDS.values())
    for table in tables:
        with_config(ConfigDict(extra="forbid", allow_inf_nan=False))(table)
    return TypeAdapter(Scenario)


def _checked(table: Mapping[str, Any]) -> Scenario:
    from pydantic import ValidationError

    try:
        # Strict mode of JSON takes a list for a tuple and 3 for 3.0, but neither "3" nor true for a number.
        return _adapter().validate_json(_json(table), strict=True)
    except ValidationError as error:
        raise ScenarioError("\n".join(fault_lines(error.errors(include_url=False), table))) from None


def _json(table: Mapping[str, Any]) -> str:
    """A table as JSON; numpy's numbers as numbers, a date of TOML as a text, which the check refuses at its place."""
    return json.dumps(table, default=lambda value: value.item() if hasattr(value, "item") else str(value))
