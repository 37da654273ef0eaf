"""Further observations in the protocol: each with its correction and its test, and the biases of the stations."""

from __future__ import annotations

import math
from typing import Any

from adjust import Adjustment
from adjust.model import EXTERIOR_NAMES
from adjust.quality import Reliability
from simfield.block import Floats

Record = dict[str, Any]
DEGREES_PER_RADIAN = 180.0 / math.pi
UNITS = {"positions": "m", "attitudes": "deg", "distances": "m", "height differences": "m"}
"""by the name of the group; priors have the unit of their parameter"""


def unit(a: Adjustment, row: int) -> str:
    """The unit in which the protocol states an observation of an adjustment, by its row in Influence."""
    groups = a.regular.groups
    start = 2 * len(a.block.observations)
    if row < start:
        return "mm"
    start += len(groups.control.columns)
    if row < start:
        return "m"
    for group in groups.further:
        start += len(group.weight)
        if row < start:
            return UNITS.get(group.name, "")
    raise IndexError(row)


def factor(of_unit: str) -> float:
    """From the unit of the engine to that of the protocol."""
    return DEGREES_PER_RADIAN if of_unit == "deg" else 1.0


def observations(a: Adjustment, found: Reliability, mdbs: Floats) -> list[Record]:
    """Every further observation: correction, redundancy number, w and minimal detectable bias, of all rows in mdbs."""
    groups = a.regular.groups
    row = 2 * len(a.block.observations) + len(groups.control.columns)
    records = []
    for group in groups.further:
        of_unit = UNITS.get(group.name, "")
        for label in group.labels:
            w, mdb = float(found.w[row]), factor(of_unit) * float(mdbs[row])
            records.append(
                {
                    "observation": label,
                    "group": group.name,
                    "unit": of_unit,
                    "v": factor(of_unit) * float(found.influence.rows.v[row]),
                    "redundancy": float(found.redundancy[row]),
                    "w": w if math.isfinite(w) else None,
                    "mdb": mdb if math.isfinite(mdb) else None,
                }
            )
            row += 1
    return records


def biases(a: Adjustment) -> list[Record]:
    """Offsets and drifts of the strips; a drift from the middle of a strip to its end."""
    records = []
    for owner, name in a.layout.further:
        at = a.layout.index(owner, name)
        of_unit = "m" if name.split()[-1] in EXTERIOR_NAMES[:3] else "deg"
        value, std = (factor(of_unit) * float(x[at]) for x in (a.x, a.std))
        records.append({"owner": owner, "name": name, "unit": of_unit, "value": value, "std": std})
    return records
