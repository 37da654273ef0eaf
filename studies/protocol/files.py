"""The protocol as files: protocol.txt, protocol.json, observations.csv and correlations.csv in one folder."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from adjust import Adjustment, correlations
from adjust.quality import Reliability
from simfield.block import Floats
from simfield.files import write_set
from simfield.numerics import one_thread
from studies.protocol import record as protocol, text as protocol_text
from studies.protocol.adjustment_page import orientation_names
from studies.texts import as_text

OBSERVATIONS = (
    "image_id",
    "point_id",
    "vx_mm",
    "vy_mm",
    "redundancy_x",
    "redundancy_y",
    "w_x",
    "w_y",
    "mdb_x_mm",
    "mdb_y_mm",
)
FULL_MOST = 1500
"""orientation unknowns up to which the matrix of correlations is written in full; beyond, that of the parameters
alone
"""


def write(a: Adjustment, folder: Path) -> list[Path]:
    """Write the protocol of a successful adjustment, as one; returns the files. Raises OSError."""
    findings = protocol.ProtocolFindings(a)
    # many small products: further threads only wait for each other
    with one_thread():
        record = protocol.record(a, findings)
        contents = {
            "protocol.txt": protocol_text.page(record),
            "protocol.json": json.dumps(record, indent=1, allow_nan=False, ensure_ascii=False) + "\n",
            "observations.csv": observations_csv(a, findings.reliability, findings.inspection.reliability.mdb),
            "correlations.csv": correlations_csv(a),
        }
    write_set(folder, {name: text.encode() for name, text in contents.items()})
    return [folder / name for name in contents]


def observations_csv(a: Adjustment, found: Reliability, mdb: Floats) -> str:
    """One line an image point, in the order of the block; w and mdb are empty where nothing checks an observation."""
    rows = found.image_points
    columns = [a.residuals, *(each[rows].reshape(-1, 2) for each in (found.redundancy, found.w, mdb))]
    o, b = a.block.observations, a.block
    ids = ((b.images.ids[i], b.points.ids[p]) for i, p in zip(o.image.tolist(), o.point.tolist(), strict=True))
    digits = (6, 6, 5, 5, 4, 4, 6, 6)
    values = np.hstack(columns).tolist()
    lines = (
        [*two, *(_cell(v, d) for v, d in zip(row, digits, strict=True))] for two, row in zip(ids, values, strict=True)
    )
    return _csv(OBSERVATIONS, lines)


def correlations_csv(a: Adjustment) -> str:
    """The correlations of all orientation unknowns as a square table; of a large block those of the parameters
    alone.
    """
    names = [f"{each['owner']} {each['name']}" for each in orientation_names(a)]
    start = 0 if len(names) <= FULL_MOST else 6 * len(a.block.images)
    at = np.arange(start, len(names))
    r = correlations(a.cofactors.block(at, at)).tolist()
    return _csv(
        ["", *names[start:]], ([name, *(_cell(v, 6) for v in row)] for name, row in zip(names[start:], r, strict=True))
    )


def _cell(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else ""


def _csv(header: Iterable[str], lines: Iterable[Iterable[str]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(as_text, header))
    writer.writerows(map(as_text, line) for line in lines)
    return text.getvalue()
