"""The columns that are kept of the trials of a method: name, unit, kind and type, as the manifest of a store says them.

A column METHOD|name of a block has a row a trial. Of the nominal adjustment METHOD|constants has a row a constant, and
METHOD|name of an unknown its estimand, the root of its cofactor, and its formal correlations with all unknowns.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from adjust.model import EXTERIOR_NAMES, POINT_NAMES
from simfield.scenario import Scenario
from studies.design import ALL, Method, Plan

VERSION = 1
"""of the columns below; one higher whenever one is added or changed. Constants are only ever added at the end."""
OWN_UNIT = "mm-powers"
"""additional parameters: the unit that the term's power of mm asks for"""
ANGLES = ("omega", "phi", "kappa")
METRES = tuple(name for name in (*EXTERIOR_NAMES, *POINT_NAMES) if name not in ANGLES)
POINT_LABELS = ("centre", "edge")
"""the points nearest to the centre of the field and farthest from it"""


@dataclass(frozen=True)
class Column:
    """kind: status, deviation, constant or unknown; a status is a code of studies.store.status_codes."""

    name: str
    unit: str
    kind: str
    dtype: str = "float64"


TRIAL = (
    Column("status", "", "status", "int8"),
    Column("m0_um", "um", "deviation"),
    Column("mu_xy_mm", "mm", "deviation"),
    Column("mu_z_mm", "mm", "deviation"),
    Column("true_xy_mm", "mm", "deviation"),
    Column("true_z_mm", "mm", "deviation"),
    Column("mean_z_mm", "mm", "deviation"),
    Column("coverage_xy", "1", "deviation"),
    Column("coverage_z", "1", "deviation"),
)
CONSTANT = (
    Column("redundancy", "1", "constant"),
    Column("unit_weight_um", "um", "constant"),
    Column("noise_free_m0_um", "um", "constant"),
    Column("observations", "1", "constant"),
    Column("condition_number", "1", "constant"),
    Column("largest_ap_exterior", "1", "constant"),
)
DEVIATIONS = tuple(column.name for column in TRIAL if column.kind == "deviation")
"""per trial: m0; 2-D and height rms at check points against their given coordinates; the same against the truth at all
points but control; the mean height error; the shares of true coordinates inside their 95 % intervals"""
CONSTANTS = tuple(column.name for column in CONSTANT)
"""of the nominal adjustment; the condition number is that of the reduced normal equations, scaled; largest_ap_exterior
the largest |correlation| of an additional parameter with an element of exterior orientation, NaN without parameters"""


def unit_of_unknown(name: str) -> str:
    """The unit of an unknown such as "ww.Z0" or "edge.Z"."""
    last = name.partition(".")[2]
    return "rad" if last in ANGLES else "m" if last in METRES else OWN_UNIT


def described(plan: Plan) -> dict[str, Any]:
    """What the manifest says of the columns of a study."""
    flown = tuple(dict.fromkeys(camera for condition in plan.conditions for camera in _flown(condition.scenario)))
    unknowns = {m.key: _unknowns(m, flown) for m in plan.methods}
    return {
        "version": VERSION,
        "trials": [asdict(column) for column in TRIAL],
        "constants": [asdict(column) for column in CONSTANT],
        "unknowns": {
            key: [asdict(Column(name, unit_of_unknown(name), "unknown")) for name in names]
            for key, names in unknowns.items()
        },
    }


def _flown(scenario: Scenario) -> list[str]:
    flown = {flight.camera_id for flight in scenario.flights}
    return [camera.camera_id for camera in scenario.cameras if camera.camera_id in flown]


def _unknowns(method: Method, flown: tuple[str, ...]) -> list[str]:
    """The unknowns that a method follows in any condition, in the order of studies.trials.trial_columns.Tracked."""
    cameras = [camera for camera in flown if method.cameras == ALL or camera in method.cameras.split("+")]
    parts = ((cameras, _parameters(method)), (cameras, EXTERIOR_NAMES), (POINT_LABELS, POINT_NAMES))
    return [f"{owner}.{name}" for owners, names in parts for owner in owners for name in names]


def _parameters(method: Method) -> tuple[str, ...]:
    try:
        return method.ap_model().parameters
    except Exception:  # a set of the user's own is any code; its trials say what is wrong
        return ()


def column_faults(found: Any) -> Iterator[str]:
    """A line for each thing in the manifest of a store that these columns cannot go on with.

    found: what the manifest says, None in a store of before columns were said, which has those of version 1 or fewer.
    """
    if found is None:
        return
    version = found.get("version") if isinstance(found, Mapping) else None
    if not isinstance(version, int) or isinstance(version, bool):
        yield "columns: damaged: the manifest names no version of them"
        return
    if version > VERSION:
        yield f"columns: the store has version {version}, this simfield knows {VERSION}; use the one that wrote it"
        return
    for part, own in (("trials", TRIAL), ("constants", CONSTANT)):
        stored = found.get(part)
        if not isinstance(stored, list) or not all(isinstance(each, Mapping) for each in stored):
            yield f"columns.{part}: damaged: no list of columns"
            continue
        by_name = {each.get("name"): each for each in stored}
        for column in own:
            other = by_name.get(column.name, asdict(column))
            for key, value in asdict(column).items():
                if other.get(key) != value:
                    yield f"columns.{part}: {key} of {column.name} is {other.get(key)!r} in the store, {value!r} here"
