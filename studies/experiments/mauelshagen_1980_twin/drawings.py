"""The figures of the twin: published figures beside their simulated distributions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from studies import figures
from studies.experiments.mauelshagen_1980 import SECTIONS
from studies.experiments.mauelshagen_1980_twin.findings import Twin
from studies.figures import new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PLAN = {
    "2-D": ("mu_xy_mm", "mu_xy, 2-D, mm"),
    "coordinate": ("mu_xy_coordinate_mm", "mu_xy, one coordinate, mm"),
}


LOCATED_SAYS = (
    "Published figures in the simulated distributions",
    "m0, mu_xy and mu_z of the 18 adjustments: published values as diamonds, mean and 95 % range of the random and of "
    "the fixed world as dots and bars.",
)
"""title and description of the figure, for those who cannot see it"""


def located(twin: Twin) -> Figure:
    """The 54 published figures beside mean and 95 % range of the random and of the fixed world."""
    worlds = {"random world": twin.table, "fixed world": twin.table_fixed}
    plan, plan_title = PLAN[twin.reading]
    panels = (("m0_um", "m0_um", "m0, µm"), ("mu_xy_mm", plan, plan_title), ("mu_z_mm", "mu_z_mm", "mu_z, mm"))
    figure = new_figure(210, 125)
    for axes, (published, simulated, title) in zip(figure.subplots(1, 3, sharey=True), panels, strict=True):
        found = {
            name: tuple(t[f"sim_{simulated}{part}"].to_numpy(float) for part in ("", "_lo", "_hi"))
            for name, t in worlds.items()
        }
        figures.ranges(axes, _labels(twin.table), twin.table[published].to_numpy(float), found)
        for edge in (5.5, 11.5):
            axes.axhline(edge, color="#d8d8d8", linewidth=0.7)
        axes.set_title(title)
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _labels(table: pd.DataFrame) -> list[str]:
    return [
        f"{SECTIONS[m]} {m}, {b.replace('+', ' + ').upper()}, {'with' if aux else 'without'}"
        for m, b, aux in table[["model", "block", "aux_points"]].to_numpy().tolist()
    ]
