"""The pages on the AP sets: complete texts and readable, reproducible drawings."""

from __future__ import annotations

import sys
from pathlib import Path
from subprocess import run

import numpy as np
import pytest

from adjust import ap_models
from adjust.ap_models.lookup import MODELS
from studies.pages import models_page

every_set = pytest.mark.parametrize("model", [pytest.param(kind(), id=kind.id) for kind in MODELS])


def test_the_table_has_a_line_for_every_set():
    head, *lines = models_page.table().splitlines()
    assert head.split() == ["id", "parameters", "certainty", "settings", "title"]
    assert tuple(line.split()[0] for line in lines) == ap_models.names()
    for line in lines:
        model = ap_models.get(line.split()[0])
        assert line.split()[1:3] == [str(len(model.parameters)), str(model.certainty)]
        assert line.endswith(model.title)


@every_set
def test_the_description_says_everything(model):
    text = models_page.describe(model)
    said = " ".join(text.split())
    for part in (model.id, model.title, model.author, model.source, str(model.certainty), *model.parameters):
        assert part in said
    for part in model.formula.splitlines():
        assert " ".join(part.split()) in said
    for name in (*model.settings, *model.why_not_estimable.values()):
        assert name in said
    assert max(map(len, text.splitlines())) <= models_page.LINE


def test_a_changed_setting_is_shown_beside_its_default():
    text = models_page.describe(ap_models.get("ebner12", b_mm=60.0))
    assert "60 (default 90)  image base, mm" in text
    assert "{-60, 0, 60}^2" in text


def test_published_properties_are_on_the_page():
    assert "57.0 %" in models_page.describe(ap_models.get("gruen12"))
    assert "a21  a change of scale" in models_page.describe(ap_models.get("brown1976"))


@every_set
def test_every_field_has_arrows_of_at_most_ten_micrometres(model):
    fields = models_page.vector_fields(model)
    assert [f.name for f in fields] == list(model.parameters)
    for f in fields:
        assert np.max(np.hypot(f.dx_um, f.dy_um)) == pytest.approx(10.0)
        assert f.value > 0


@pytest.mark.parametrize("set_id", ["optical", "ebner12", "brown14"])
def test_the_drawing_has_a_panel_for_every_parameter_and_nothing_overlaps(set_id: str):
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    model = ap_models.get(set_id)
    figure = models_page.fields_figure(model)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    panels = [axes for axes in figure.axes if axes.axison]
    assert [axes.get_title().split(" = ")[0] for axes in panels] == list(model.parameters)
    assert all(axes.get_aspect() == 1.0 for axes in panels)
    boxes = [axes.get_tightbbox(canvas.get_renderer()) for axes in panels]
    for k, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[k + 1 :])


@pytest.mark.parametrize("ending", ["svg", "png"])
def test_drawn_twice_is_the_same_file(tmp_path: Path, ending: str):
    model = ap_models.get("optical")
    for name in ("one", "two"):
        models_page.draw_fields(model, tmp_path / f"{name}.{ending}")
    assert (tmp_path / f"one.{ending}").read_bytes() == (tmp_path / f"two.{ending}").read_bytes()


def test_a_set_without_parameters_has_nothing_to_draw(tmp_path: Path):
    with pytest.raises(ValueError, match="none has no parameters to draw"):
        models_page.draw_fields(ap_models.get("none"), tmp_path / "none.svg")


def test_texts_do_not_load_matplotlib():
    code = "import sys; from studies.pages import models_page as m; m.table(); sys.exit('matplotlib' in sys.modules)"
    assert run([sys.executable, "-c", code], check=False).returncode == 0
