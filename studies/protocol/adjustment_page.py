"""An adjustment as a record for machines and as a page for people. What is missing or not finite is null, or a dash."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from adjust import Adjustment, correlations
from adjust.model import EXTERIOR_NAMES, POINT_NAMES
from adjust.quality import finer_sets
from simfield.block import COORDINATES, EXTERIOR, Floats
from studies.comparison import geodetic_deviations

STRONG = 0.95
"""correlations above this, in absolute value, are listed"""
PAIRS_MOST = 1000
"""of more pairs the strongest are listed, and the number of the others is said"""

FINER_LEVEL = 0.05
"""probability below which more sets of additional parameters are called significant"""

DEGREES = np.array([1.0, 1.0, 1.0, *([180.0 / np.pi] * 3)])
"""the units of an exterior orientation in a page: metres and degrees"""

Record = dict[str, Any]


def record(a: Adjustment) -> Record:
    """Everything an adjustment says, in plain types without NaN; the keys of `simfield adjust --json`.

    Of a failed adjustment only the counts, the status and its sentence are numbers; all estimates are null.
    """
    check = geodetic_deviations(a)
    pairs, left_off = strong_correlations(a)
    return {
        "observations": a.observations,
        "unknowns": a.unknowns,
        "redundancy": a.redundancy,
        "sigma0": _number(a.sigma0),
        "m0_um": _number(a.m0_um),
        "status": a.status.name.lower(),
        "message": a.message,
        "iterations": a.iterations,
        "ap": {camera: _values(a, e.names, e.values, e.std) for camera, e in a.ap.items()},
        "images": _table(a, a.images.ids, EXTERIOR, a.images.values * DEGREES, a.images.std * DEGREES),
        "points": _table(a, a.points.ids, COORDINATES, a.points.values, a.points.std),
        "check": {
            "n": check.n,
            "rms_x_m": _estimate(a, check.rms_x_m),
            "rms_y_m": _estimate(a, check.rms_y_m),
            "rms_xy_m": _estimate(a, check.rms_xy_m),
            "rms_z_m": _estimate(a, check.rms_z_m),
        },
        "correlations": pairs,
        "correlations_left_off": left_off,
    }


def strong_correlations(a: Adjustment) -> tuple[list[Record], int]:
    """Pairs of orientation unknowns and additional parameters correlated above STRONG, strongest first, and how many
    more there are than PAIRS_MOST."""
    if not a.status.ok:
        return [], 0
    r = np.triu(correlations(a.cofactors.orientation), 1)
    rows, columns = np.nonzero(np.abs(r) > STRONG)
    order = np.argsort(-np.abs(r[rows, columns]), kind="stable")
    names = orientation_names(a)
    listed = [
        {"a": names[i], "b": names[j], "r": float(r[i, j])}
        for i, j in zip(rows[order[:PAIRS_MOST]].tolist(), columns[order[:PAIRS_MOST]].tolist(), strict=True)
    ]
    return listed, max(len(order) - PAIRS_MOST, 0)


def page(a: Adjustment) -> str:
    """A page of text: what was adjusted, how well, the orientations, the additional parameters and the check points."""
    return "\n".join([*_head(a), "", *_orientation_lines(a), *_ap_lines(a), *_check_lines(a), *_pair_lines(a)])


def _head(a: Adjustment) -> Iterator[str]:
    yield f"{len(a.block.images)} images, {len(a.block.points)} points, {len(a.block.observations)} image points"
    yield f"{a.observations} observations, {a.unknowns} unknowns, redundancy {a.redundancy}"
    yield f"sigma0 {a.sigma0:.4f}   m0 {a.m0_um:.2f} um   {a.message} after {a.iterations} iterations"


def _orientation_lines(a: Adjustment) -> Iterator[str]:
    width = max(len("image"), *(len(name) for name in a.images.ids))
    columns = [14, 14, 12, 12, 12, 12]
    yield "Exterior orientation, below each its standard deviation (m, degrees)"
    header = (name.rsplit("_", 1)[0] for name in EXTERIOR)
    yield f"{'image':<{width}}" + "".join(f"{name:>{w}}" for name, w in zip(header, columns, strict=True))
    digits = [3, 3, 3, 6, 6, 6]
    for name, values, std in zip(a.images.ids, a.images.values * DEGREES, a.images.std * DEGREES, strict=True):
        for label, row in ((name, values), ("", std)):
            cells = (f"{v:>{w}.{d}f}" for v, w, d in zip(row, columns, digits, strict=True))
            yield f"{label:<{width}}" + "".join(cells)
    yield ""


def _ap_lines(a: Adjustment) -> Iterator[str]:
    for ap, e in zip(a.layout.sets, a.ap.values(), strict=True):
        if not e.names:
            continue
        yield f"Additional parameters of {a.layout.owner_of(ap)} (mm, per power of mm)"
        for name, value, std in zip(e.names, e.values, e.std, strict=True):
            yield f"{name:>6}{value:>16.6e}  +- {std:.2e}   {abs(value) / std:8.1f} times its standard deviation"
        yield ""


def _check_lines(a: Adjustment) -> Iterator[str]:
    found = geodetic_deviations(a)
    if found.n == 0:
        yield "No check points"
        return
    yield f"{found.n} check points against their given coordinates, rms in m"
    yield (f"X {found.rms_x_m:.4f}   Y {found.rms_y_m:.4f}   plan (2-D) {found.rms_xy_m:.4f}   Z {found.rms_z_m:.4f}")


def _pair_lines(a: Adjustment, most: int = 8) -> Iterator[str]:
    pairs, left_off = strong_correlations(a)
    if not pairs:
        return
    yield ""
    yield f"{len(pairs) + left_off} pairs are correlated above {STRONG}; the strongest"
    for pair in pairs[:most]:
        names = (f"{end['name']} of {end['owner']}" for end in (pair["a"], pair["b"]))
        yield f"{pair['r']:8.4f}   " + ", ".join(names)


def orientation_names(a: Adjustment) -> list[dict[str, str]]:
    """Owner and name of every orientation unknown, in the layout of x."""
    images = [{"owner": image, "name": name} for image in a.block.images.ids for name in EXTERIOR_NAMES]
    sets = [{"owner": s.id, "name": name} for s in a.layout.sets for name in s.model.parameters]
    further = [{"owner": owner, "name": name} for owner, name in a.layout.further]
    ids = a.block.points.ids
    tied = [{"owner": ids[at // 3], "name": POINT_NAMES[at % 3]} for at in a.layout.coupled.tolist()]
    return images + sets + further + tied


def _table(a: Adjustment, ids: Sequence[str], names: Sequence[str], values: Floats, std: Floats) -> Record:
    return {owner: _values(a, names, *both) for owner, *both in zip(ids, values, std, strict=True)}


def _values(a: Adjustment, names: Iterable[str], values: Floats, std: Floats) -> Record:
    return {
        name: {"value": _estimate(a, value), "std": _number(s)}
        for name, value, s in zip(names, values.tolist(), std.tolist(), strict=True)
    }


def _estimate(a: Adjustment, value: float) -> float | None:
    """A value of a failed adjustment is only where it stopped, so it is null."""
    return _number(value) if a.status.ok else None


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def sets_line(coarse: Adjustment, fine: Adjustment, by: str) -> str:
    """One sentence on whether sets of additional parameters by flight, strip or image are worth it."""
    try:
        test = finer_sets(coarse, fine)
    except ValueError as error:
        return f"one AP set a {by} against one a camera: {error}"
    verdict = "significant" if test.p < FINER_LEVEL else "not significant"
    return (
        f"one AP set a {by} against one a camera: F = {test.statistic:.2f} with {test.k} and {test.f} degrees of "
        f"freedom, p = {test.p:.3g}: {verdict} at {100 * FINER_LEVEL:.0f} %"
    )
