"""No text of others becomes a formula in a spreadsheet, and no number becomes a text."""

import csv
from dataclasses import replace

import pandas as pd
import pytest

from adjust import adjust_block, ap_models
from simfield import presets, simulate
from studies.protocol.files import write
from studies.texts.spreadsheet import as_text
from studies.texts.tables import write_csv

CALL = '=HYPERLINK("http://x")'


@pytest.mark.parametrize("text", [CALL, "+1+cmd", "-2+3", "@SUM(A1)", "\t=1", "--x"])
def test_what_could_run_is_quoted(text):
    assert as_text(text) == f"'{text}"


@pytest.mark.parametrize("text", ["-0.92", "+1e-5", "-", "", "a=1", "0.80 to 0.85", "<script>"])
def test_numbers_and_words_stay(text):
    assert as_text(text) == text


def test_tables_quote_names_and_cells(tmp_path):
    write_csv(pd.DataFrame({CALL: [CALL], "b": [-0.5]}), tmp_path / "t.csv", {"b": ".1f"})
    with (tmp_path / "t.csv").open(newline="") as stream:
        assert list(csv.reader(stream)) == [[f"'{CALL}", "b"], [f"'{CALL}", "-0.5"]]


def test_the_protocol_quotes_the_names_of_a_block(tmp_path):
    block, _ = simulate(presets["grid-small"], 7)
    images = replace(block.images, ids=(CALL, *block.images.ids[1:]))
    points = replace(block.points, ids=(f"{CALL}2", *block.points.ids[1:]))
    write(adjust_block(replace(block, images=images, points=points), ap_models.get("optical")), tmp_path)
    for name in ("observations.csv", "correlations.csv"):
        with (tmp_path / name).open(newline="") as stream:
            cells = [cell for row in csv.reader(stream) for cell in row]
        assert any(cell.startswith(f"'{CALL}") for cell in cells)
        assert not any(cell.startswith("=") for cell in cells)
