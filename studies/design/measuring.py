"""How the images of a condition are measured: the chain from light to number, and the reductions that follow.

    [scenario]
    preset = "rheidt-1980-film"
    chain = {preset = "psk-1969", without = ["lens"]}
    reductions = {inner = "helmert", refraction = false}

Without `chain` image coordinates are the world's own. Both are tables beside those of the scenario, so that any value
in them can be a factor: chain.film_field.sigma_um, chain.without, reductions.inner.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from functools import cache
from typing import TYPE_CHECKING, Any

from adjust.reductions import ReductionPlan
from simfield.block import nearest, shown
from simfield.chain import Chain, chain_as_table, chain_from_table
from simfield.scenario import ScenarioError

if TYPE_CHECKING:
    from pydantic import TypeAdapter
    from pydantic_core import ErrorDetails

KEYS = ("chain", "reductions")


@dataclass(frozen=True)
class Measuring:
    """A chain, and the reductions that are applied to what it measures: those that are wished and that it calls for."""

    chain: Chain
    plan: ReductionPlan


def apart(table: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """What a table says of the scenario itself, and what of chain and reductions."""
    own = {key: value for key, value in table.items() if key not in KEYS}
    return own, {key: table[key] for key in KEYS if key in table}


def whole(said: Mapping[str, Any]) -> dict[str, Any]:
    """Chain and reductions with every value written out; nothing where nothing is said. Raises ScenarioError."""
    if not said:
        return {}
    if "chain" not in said:
        raise ScenarioError('reductions: there is no chain to reduce; allowed: beside a chain, as chain = "psk-1969"')
    wished = said.get("reductions", {})
    if not isinstance(wished, Mapping):
        raise ScenarioError(f"reductions: found {shown(wished)}, allowed: a table")
    return {"chain": chain_as_table(said["chain"]), "reductions": {**asdict(ReductionPlan()), **wished}}


def measuring_of(said: Mapping[str, Any]) -> Measuring | None:
    """Chain and reductions of a table; None where nothing is said. Raises ScenarioError, a line for each fault."""
    from pydantic import ValidationError

    if not said:
        return None
    tables = whole(said)
    known = [f.name for f in fields(ReductionPlan)]
    for name in tables["reductions"]:
        if name not in known:
            raise ScenarioError(f"reductions.{name}: unknown key{nearest(name, known)}")
    try:
        plan = _adapter().validate_json(json.dumps(tables["reductions"]), strict=True)
    except ValidationError as error:
        raise ScenarioError("\n".join(_said(detail) for detail in error.errors(include_url=False))) from None
    chain = chain_from_table(tables["chain"])
    if chain.errors.missed_rate > 0.0:
        raise ScenarioError(
            f"chain.errors.missed_rate: found {chain.errors.missed_rate:g}, allowed: 0; missed points make every trial"
            " a geometry of its own"
        )
    return Measuring(chain, fitting(plan, chain))


def _said(detail: ErrorDetails) -> str:
    allowed = detail["msg"].removeprefix("Input should be ").replace("a valid", "a")
    return f"reductions.{detail['loc'][0]}: found {shown(detail['input'])}, allowed: {allowed}"


def fitting(plan: ReductionPlan, chain: Chain) -> ReductionPlan:
    """The plan without the reductions of what the chain does not have: they would put in what was never there."""
    return replace(
        plan,
        refraction=plan.refraction and chain.air.refraction,
        curvature=plan.curvature and chain.air.curvature,
        lens=plan.lens and any(lens.radial is not None for lens in chain.lenses),
        comparator=plan.comparator and any((*chain.comparator.scale_ppm, chain.comparator.non_orthogonality_ppm)),
    )


@cache
def _adapter() -> TypeAdapter[ReductionPlan]:
    from pydantic import TypeAdapter

    return TypeAdapter(ReductionPlan)
