"""The figure of a study: its legend stays on the page, however long the names of factors and levels are."""

from __future__ import annotations

import numpy as np
import pytest

from studies.figures.canvas import MILLIMETRE, house_style, new_figure
from studies.pages import study_report
from studies.pages.study_report import side_by_side
from studies.summary import ranking

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


def test_the_largest_of_many_differences_by_chance() -> None:
    """Of 17 that are none, one in twenty studies shows one beyond the bound; each study has twenty thousand trials."""
    assert ranking.largest_by_chance(1) == pytest.approx(1.96, abs=1e-3)
    bound = ranking.largest_by_chance(17)
    z = np.random.default_rng(1).standard_normal((20_000, 17))
    share = np.mean(np.abs(z).max(axis=1) > bound)
    assert abs(share - 0.05) < 3.0 * np.sqrt(0.05 * 0.95 / 20_000)


def test_a_star_stands_at_what_is_beyond() -> None:
    values = {"a": 3.1, "b": -2.9, "c": float("nan"), "d": -9.0}
    rows = [{"method": k, "estimate": v, "mcse": 1.0, "n": 9, "failures": 0} for k, v in values.items()]
    lines = list(study_report.table(rows, ["method"], bound=3.0))[2:]
    assert ["\\*" in line for line in lines] == [True, False, False, True]
    assert not any("\\*" in line for line in study_report.table(rows, ["method"]))
    rows[0]["geometry_se"] = 2.0
    assert "\\*" not in list(study_report.table(rows, ["method"], bound=3.0))[2]
