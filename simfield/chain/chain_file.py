"""Chains as tables, as a study file says them: a preset by name, changes to it, and stages that are left out.

chain = "psk-1969"
chain = {preset = "psk-1969", without = ["lens"], film_field = {sigma_um = 3.0}}
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from functools import cache
from typing import TYPE_CHECKING, Any

from simfield.block import shown
from simfield.chain.air import Air
from simfield.chain.comparator import Comparator, Errors, Marks
from simfield.chain.lens import Lens, RadialCertificate
from simfield.chain.measure import Chain
from simfield.chain.presets import STAGES, chains, without
from simfield.chain.random_field import RandomField
from simfield.disturbances import Decentering, RadialTable
from simfield.scenario import ScenarioError, fault_lines, merged

if TYPE_CHECKING:
    from pydantic import TypeAdapter

TABLES: Mapping[str, type[Any]] = {
    "air": Air,
    "lenses": Lens,
    "film_field": RandomField,
    "marks": Marks,
    "comparator": Comparator,
    "errors": Errors,
}
"""what stands under these keys of a chain"""


def chain_as_table(said: object) -> dict[str, Any]:
    """A whole chain as a table, with the stages that are left out of it under `without`.

    said: the name of a preset, or a table. Raises ScenarioError for a preset that there is not.
    """
    if isinstance(said, str):
        said = {"preset": said}
    if not isinstance(said, Mapping):
        raise ScenarioError(f"chain: found {shown(said)}, allowed: the name of a chain, or a table")
    given = dict(said)
    name = given.pop("preset", None)
    if name is None and "marks" in given:  # whole already
        return given
    if name is None:
        name = "undisturbed"
    if not isinstance(name, str) or name not in chains:
        raise ScenarioError(f"chain: found {shown(name)}, allowed: {', '.join(chains)}")
    left_out = given.pop("without", [])
    return {**merged(json.loads(json.dumps(asdict(chains[name]))), given), "without": left_out}


def chain_from_table(table: Mapping[str, Any]) -> Chain:
    """The chain that a whole table says. Raises ScenarioError with one line for each fault."""
    from pydantic import ValidationError

    given = dict(table)
    left_out = given.pop("without", [])
    stages = [left_out] if isinstance(left_out, str) and left_out else left_out or []
    if not isinstance(stages, list) or not all(isinstance(stage, str) for stage in stages):
        raise ScenarioError(f"chain.without: found {shown(left_out)}, allowed: stages, of {', '.join(STAGES)}")
    for stage in stages:
        if stage not in STAGES:
            raise ScenarioError(f"chain.without: found {shown(stage)}, allowed: {', '.join(STAGES)}")
    try:
        chain = _adapter().validate_json(json.dumps(given), strict=True)
    except ValidationError as error:
        details = error.errors(include_url=False)
        lines = fault_lines(details, given, TABLES, Chain)
        raise ScenarioError("\n".join(f"chain.{line}".replace("chain.scenario", "chain") for line in lines)) from None
    return without(chain, *stages)


@cache
def _adapter() -> TypeAdapter[Chain]:
    from pydantic import ConfigDict, TypeAdapter, with_config

    for table in (Chain, RadialCertificate, RadialTable, Decentering, *TABLES.values()):
        with_config(ConfigDict(extra="forbid", allow_inf_nan=False))(table)
    return TypeAdapter(Chain)
