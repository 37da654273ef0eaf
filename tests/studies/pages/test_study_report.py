"""The figure of a study: its legend stays on the page, however long the names of factors and levels are."""

from __future__ import annotations

import pytest

from studies.figures.canvas import MILLIMETRE, house_style, new_figure
from studies.pages.study_report import side_by_side

TEXT = 3 * "inner_orientation helmert, control corners-and-centre, "


@pytest.mark.parametrize("letters", [4, 20, 40, 52, 90])
@pytest.mark.parametrize("width_mm", [90.0, 180.0])
def test_the_legend_stays_on_the_page(letters: int, width_mm: float) -> None:
    labels = [(f"{k} " + TEXT)[:letters] for k in range(7)]
    with house_style():
        figure = new_figure(width_mm, 88.0)
        axes = figure.subplots()
        handles = [axes.plot([0, 1], marker="o", label=label)[0] for label in labels]
        side = side_by_side(labels, width_mm)
        legend = figure.legend(handles, labels, loc="outside lower center", ncols=side, fontsize=6.5)
        figure.draw_without_rendering()
        box = legend.get_window_extent()
    assert side == 1 or box.width <= width_mm * MILLIMETRE * figure.dpi
    assert 1 <= side <= 3
    assert side == 3 or letters > 12
