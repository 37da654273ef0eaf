"""Table 2 of the paper: correlations of b1 .. b14 in the simultaneous adjustment, and what they tell about the
misprint.

The paper says neither which camera's parameters Table 2 shows nor which of the two figures in a cell belongs to the
adjustment with auxiliary points. All combinations are computed.
"""

from __future__ import annotations

import contextlib
from collections.abc import Collection, Iterable

import numpy as np
import pandas as pd

from adjust import ap_models
from simfield import Truth, World, build_world
from simfield.block import Block, Floats
from simfield.scenario import Scenario
from simfield.world import CountError
from studies.comparison import root_mean_square
from studies.experiments import published
from studies.experiments.mauelshagen_1980.experiment import BOTH, CAMERAS, adjusted, sub_block

VARIANTS: dict[str, dict[str, bool]] = {
    "corrected": {},
    "as_printed": {"as_printed": True},
    "b4_only": {"sign_printed": True},
    "sign_only": {"b4_printed": True},
}
"""what of the misprint is corrected: both, nothing, b4 alone, the decentering sign alone"""
RMS_FORMATS = {"as_labelled": ".4f", "swapped": ".4f"}
FORMATS = {"published": ".2f", "simulated": ".4f"}


def table2(block: Block, truth: Truth, variants: Collection[str] = tuple(VARIANTS)) -> pd.DataFrame:
    """One line for each pair of parameters, camera, variant, without and with auxiliary points."""
    lines = []
    for aux_points in (False, True):
        part = sub_block(block, truth, BOTH, aux_points)
        paper = published.mauelshagen_table2(aux_points=aux_points)
        for variant in variants:
            a = adjusted(part, ap_models.get("brown14", **VARIANTS[variant]))
            for camera in CAMERAS:
                names, simulated = a.ap[camera].names, a.ap_correlation(camera)
                lines += [
                    (aux_points, camera, variant, names[i], names[j], paper[i, j], simulated[i, j])
                    for i, j in zip(*np.triu_indices(len(names), 1), strict=True)
                ]
    columns = ["aux_points", "camera", "variant", "row", "column", "published", "simulated"]
    order = pd.DataFrame(lines, columns=columns)
    return order.sort_values(["aux_points", "camera"], kind="stable", ignore_index=True)


def rms_of_differences(table: pd.DataFrame) -> pd.DataFrame:
    """The rms over the 91 pairs for every variant and camera against both printed figures of a cell.

    `as_labelled` compares with the printed row that the paper's Table 1 suggests (upper: without auxiliary points),
    `swapped` with the other.
    """
    keys = ["aux_points", "camera", "variant"]
    lines = []
    for (aux_points, camera, variant), pairs in table.groupby(keys, sort=False):
        other = matrix(table, not bool(aux_points), str(camera), str(variant), "published")
        simulated = matrix(table, bool(aux_points), str(camera), str(variant), "simulated")
        upper = np.triu_indices(len(other), 1)
        lines.append(
            {
                "variant": variant,
                "aux_points": aux_points,
                "camera": camera,
                "as_labelled": root_mean_square(pairs["simulated"] - pairs["published"]),
                "swapped": root_mean_square((simulated - other)[upper]),
            }
        )
    return pd.DataFrame(lines).sort_values(["variant", "aux_points", "camera"], key=_in_order, ignore_index=True)


def other_worlds(scenario: Scenario, seeds: Iterable[int]) -> list[World]:
    """The same flights with other deviations and other omitted points: a world a seed.

    A seed whose flights cannot have given the published counts is left out.
    """
    worlds = []
    for seed in seeds:
        with contextlib.suppress(CountError):
            worlds.append(build_world(scenario, seed))
    return worlds


def other_geometries(worlds: Iterable[World]) -> pd.DataFrame:
    """The same rms of the corrected terms in other worlds."""
    tables = [rms_of_differences(table2(*w.observe(0), ["corrected"])).assign(seed=w.seed) for w in worlds]
    return pd.concat(tables, ignore_index=True)


def best_fit(rms: pd.DataFrame, aux_points: bool) -> tuple[str, float]:
    """The camera that fits best with the corrected terms, and its rms, with the printed row as labelled."""
    chosen = rms[(rms["variant"] == "corrected") & (rms["aux_points"] == aux_points)]
    line = chosen.sort_values("as_labelled").iloc[0]
    return str(line["camera"]), float(line["as_labelled"])


def matrix(table: pd.DataFrame, aux_points: bool, camera: str, variant: str, column: str) -> Floats:
    """(14, 14) the published or simulated correlations of one adjustment, symmetric."""
    chosen = table[(table["aux_points"] == aux_points) & (table["camera"] == camera) & (table["variant"] == variant)]
    size = int((1 + (1 + 8 * len(chosen)) ** 0.5) / 2)
    full = np.zeros((size, size))
    full[np.triu_indices(size, 1)] = chosen[column].to_numpy(float)
    return np.asarray(full + full.T + np.eye(size))


def matrix_markdown(table: pd.DataFrame, aux_points: bool, camera: str) -> str:
    """Simulated / published, in hundredths, of the corrected terms."""
    simulated, paper = (100 * matrix(table, aux_points, camera, "corrected", c) for c in ("simulated", "published"))
    names = [f"b{i + 1}" for i in range(len(paper))]
    lines = ["| | " + " | ".join(names) + " |", "|---|" + "---:|" * len(names)]
    for i, name in enumerate(names):
        cells = ["" if j <= i else f"{simulated[i, j]:.0f} / {paper[i, j]:.0f}" for j in range(len(names))]
        lines.append(f"| {name} | " + " | ".join(cells).replace("-0 /", "0 /") + " |")
    return "\n".join(lines) + "\n"


def _in_order(column: pd.Series) -> pd.Series:
    return column.map(list(VARIANTS).index) if column.name == "variant" else column
