"""The figures of the reproduction, put together from its tables; nothing is computed and nothing written here."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from studies.experiments.ziemann_1982.experiment import SETS, Case, cases
from studies.experiments.ziemann_1982.reseau import LEVELS
from studies.figures import BLACK, BLUE, VERMILION, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ENDS = {min(LEVELS): VERMILION, max(LEVELS): BLUE}


SETS_SAY = (
    "Sets of additional parameters, published and simulated",
    "Rms of the residual vectors of eight sets at the lowest and the highest level of reseau correction, for two "
    "cameras over two fields: published as diamonds, simulated as dots with two Monte-Carlo standard errors.",
)
LEVELS_SAY = (
    "What the reseau brings",
    "Rms of the residual vectors over five levels of reseau correction, without additional parameters and with set n, "
    "for two cameras over two fields: published as diamonds, simulated as lines.",
)
"""title and description of each figure, for those who cannot see it"""


def sets_figure(found: pd.DataFrame) -> Figure:
    """Every set at the lowest and the highest level, published and simulated, a panel for each case."""
    figure = new_figure(210, 150)
    panels = figure.subplots(2, 2, sharex=True)
    for axes, case in zip(panels.ravel(), cases(), strict=True):
        own = _of(found, case)
        for (level, colour), offset in zip(ENDS.items(), (-0.12, 0.12), strict=True):
            rows = own[own["level"] == level].set_index("set").loc[list(SETS)]
            places = np.arange(len(SETS)) + offset
            axes.errorbar(
                places, rows["sim_um"], 2.0 * rows["sim_mcse_um"],
                linestyle="none", marker="o", markersize=4, color=colour, label=f"simulated, level {level}",
            )  # fmt: skip
            axes.plot(places, rows["published_um"], label=f"published 1982, level {level}", **_diamond(colour))
        axes.set_title(str(case))
        axes.set_xticks(np.arange(len(SETS)), list(SETS))
        axes.grid(True, axis="y")
    _label(figure, panels, "set of additional parameters")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def levels_figure(found: pd.DataFrame) -> Figure:
    """What the reseau brings: none and n over the levels, published and simulated."""
    figure = new_figure(210, 150)
    panels = figure.subplots(2, 2, sharex=True)
    for axes, case in zip(panels.ravel(), cases(), strict=True):
        own = _of(found, case)
        for letter, colour in (("none", BLACK), ("n", BLUE)):
            rows = own[own["set"] == letter].set_index("level")
            axes.plot(rows.index, rows["sim_um"], color=colour, marker="o", markersize=4, label=f"{letter}, simulated")
            axes.plot(rows.index, rows["published_um"], label=f"{letter}, published 1982", **_diamond(colour))
        axes.set_title(str(case))
        axes.set_xticks(list(LEVELS), [name.replace(" ", "\n") for name in LEVELS.values()])
        axes.grid(True, axis="y")
    _label(figure, panels, "correction of image deformation by the reseau")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def _of(found: pd.DataFrame, case: Case) -> pd.DataFrame:
    return found[(found["camera"] == case.camera) & (found["field"] == case.field)]


def _diamond(colour: str) -> dict[str, Any]:
    return {"linestyle": "none", "marker": "D", "markersize": 5, "fillstyle": "none", "color": colour}


def _label(figure: Figure, panels: Any, below: str) -> None:
    axes: Axes
    for axes in panels[-1]:
        axes.set_xlabel(below)
    figure.supylabel("rms of residual vectors, µm in the image", fontsize=8.5)
