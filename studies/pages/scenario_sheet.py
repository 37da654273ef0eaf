"""A scenario in Markdown, read off the scenario itself: what a reader has to know about a simulated world."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
import pandas as pd

from simfield.scenario import Scenario
from studies.comparison import format_grid, root_mean_square
from studies.design import Measuring
from studies.texts import markdown


def scenario_page(scenario: Scenario) -> str:
    """Field, cameras, flights, effects, film, noise, measurement and start values of a scenario."""
    return "\n".join(
        [
            f"**Field and control.** {_said(scenario.field)}; control {_said(scenario.control)}.\n",
            "**Cameras**\n",
            _table(scenario.cameras),
            "**Flights**\n",
            _table(scenario.flights),
            "**Systematic effects**, the same in every trial; rms of the vectors over the format\n",
            _effects(scenario),
            *_film(scenario),
            f"**Random errors.** {_said(scenario.noise)}.\n",
            f"**Measurement.** {_said(scenario.measurement)}.\n",
            f"**Start values of the adjustment.** {_said(scenario.start)}.\n",
        ]
    )


def measuring_page(measuring: Measuring) -> str:
    """The chain that the images of a condition go through, and the reductions of what it measures."""
    chain = measuring.chain
    lenses = [] if not chain.lenses else ["**Lenses**\n", _table(chain.lenses)]
    field = "none" if chain.film_field is None else _said(chain.film_field)
    return "\n".join(
        [
            f"**Measurement chain** {chain.name}. Air: {_said(chain.air)}; smooth field of the film: {field}; marks: "
            f"{_said(chain.marks)}; comparator: {_said(chain.comparator)}; errors: {_said(chain.errors)}.\n",
            *lenses,
            f"**Reductions.** {_said(measuring.plan)}.\n",
        ]
    )


def _effects(scenario: Scenario) -> str:
    xy = format_grid()
    lines = []
    for on in scenario.effects:
        where = ", ".join(f"{kind} {name}" for kind in ("camera", "flight", "image") if (name := getattr(on, kind)))
        rms = 1000.0 * root_mean_square(np.hypot(*on.effect.displacement(xy).T))
        lines.append({"on": where or "all images", "effect": _said(on.effect), "rms um": rms})
    return markdown(pd.DataFrame(lines), {"rms um": ".1f"}) if lines else "None.\n"


def _film(scenario: Scenario) -> Iterator[str]:
    if scenario.film:
        yield "**Film**, drawn anew for every image of every trial\n"
        yield _table(scenario.film)


def _table(rows: Sequence[Any]) -> str:
    """A row for each dataclass; columns that are the same default for all are left out."""
    names = [f.name for f in fields(rows[0]) if any(getattr(r, f.name) != f.default for r in rows)]
    return markdown(pd.DataFrame({name: [_value(getattr(r, name)) for r in rows] for name in names}))


def _said(thing: Any) -> str:
    """The fields of a dataclass that say something, as name = value."""
    parts = [(f.name, getattr(thing, f.name)) for f in fields(thing)]
    kind = getattr(thing, "kind", "")
    said = ", ".join(
        f"{name} {_value(value)}" for name, value in parts if name != "kind" and value not in (0.0, (), {}, None)
    )
    return f"{kind}: {said}" if kind else said


def _value(value: Any) -> str:
    if isinstance(value, bool | str):
        return str(value).lower() if isinstance(value, bool) else value
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_value(v)}" for key, v in value.items())
    if isinstance(value, Sequence):
        return ", ".join(_value(v) for v in value)
    if hasattr(value, "__dataclass_fields__"):
        return f"({_said(value)})"
    return f"{value:g}" if isinstance(value, float) else str(value)
