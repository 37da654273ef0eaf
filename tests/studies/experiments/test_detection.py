"""Size and power of data snooping against theory, on a small block."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from adjust import adjust_block, ap_models
from simfield.block import Block
from studies.commands.program import main
from studies.experiments import detection_page
from studies.experiments.detection import Share, detection, error_free, many_at_once, search_of_blocks
from tests import synthetic

MODEL = ap_models.get("optical")


def test_power_and_false_alarms_are_those_of_theory(ww_world: synthetic.World) -> None:
    found = detection(ww_world.with_noise(np.random.default_rng(1)).block, MODEL, 300, 7, sizes=(0.0, 5.0, 12.0))
    np.testing.assert_allclose(found["found"] + found["missed"] + found["wrongly_accused"], 1.0, rtol=1e-12)
    assert (np.abs(found["power"] - found["power_theory"]) <= 3.0 * found["power_mcse"]).all()
    nothing_wrong = found.iloc[0]
    assert abs(nothing_wrong["false_alarms"] - 0.001) <= 3.0 * nothing_wrong["false_alarms_mcse"]
    assert found["found"].iloc[2] >= 0.99
    assert found["found"].is_monotonic_increasing


def test_it_repeats_itself(ww_world: synthetic.World) -> None:
    block = ww_world.with_noise(np.random.default_rng(1)).block
    whole = detection(block, MODEL, 40, 7, sizes=(5.0, 8.0))
    alone = detection(block, MODEL, 40, 7, sizes=(8.0,))
    assert whole.iloc[1].to_dict() == alone.iloc[0].to_dict()


def test_an_error_free_block(ww_world: synthetic.World) -> None:
    block = error_free(ww_world.with_noise(np.random.default_rng(1)).block, MODEL)
    assert np.abs(adjust_block(block, MODEL).residuals).max() < 1e-12


def test_a_block_that_cannot_be_adjusted(ww_world: synthetic.World) -> None:
    nothing = np.full_like(ww_world.coordinates, np.nan)
    loose = ww_world.with_points(role=["tie"] * len(nothing), coordinates=nothing, sigma=nothing)
    with pytest.raises(ValueError, match="cannot be adjusted"):
        error_free(loose.block, MODEL)


def test_a_share_of_nothing_has_an_error() -> None:
    assert Share(0, 100).mcse > 0.0
    assert Share(50, 100).mcse == pytest.approx(0.05, rel=0.05)


def test_the_search_of_the_protocol_in_blocks_of_other_noise(ww_world: synthetic.World) -> None:
    """Noise of half of what is stated: nobody would be accused by the stated one, and no error of its bias found."""
    random = np.random.default_rng(3)
    o = ww_world.block.observations

    def drawn() -> Iterator[Block]:
        for _ in range(30):
            yield ww_world.with_image_points(o.xy + 0.5 * o.sigma * random.standard_normal(o.xy.shape)).block

    found = search_of_blocks(drawn(), MODEL, 7).set_index("outcome")
    promised = found.dropna()
    assert list(promised["stated"]) == [0.05, 0.8]
    assert list(found["n"]) == [30, 30, 30]
    assert (np.abs(promised["share"] - promised["stated"]) <= 3.5 * promised["share_mcse"]).all()
    assert found["share"].iloc[2] <= found["share"].iloc[1]


def test_many_at_once(ww_world: synthetic.World) -> None:
    block = ww_world.with_noise(np.random.default_rng(1)).block
    found = many_at_once(block, MODEL, 0.02, 3, 5).set_index("method")
    assert list(found.index) == ["none", "data snooping", "Huber", "Danish", "Cauchy"]
    assert found.loc["none", "found"] == 0.0
    assert (found["found"].iloc[1:] > 0.9).all()
    assert (found["accused_wrongly"] < 0.02).all()
    assert found.loc["data snooping", "point_rms_m"] < found.loc["none", "point_rms_m"]


class TestCommand:
    def test_it_writes_tables_figure_and_report(
        self, ww_world: synthetic.World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(detection_page, "SIZES", (0.0, 12.0))
        monkeypatch.setattr(detection_page, "SHARES", (0.02,))
        block = ww_world.with_noise(np.random.default_rng(1)).block
        of = detection_page.DetectionTrials(trials=60, contests=2, blocks=2, seed=7)
        files = detection_page.write(tmp_path / "out", block, lambda number: block, MODEL, of, "a block")
        assert sorted(f.name for f in files) == sorted(f.name for f in (tmp_path / "out").iterdir())
        table = pd.read_csv(tmp_path / "out" / "detection.csv")
        assert table["size_sigma"].tolist() == [0.0, 12.0] * 2
        assert table["level"].nunique() == 2
        expected = detection(block, MODEL, 60, 7, (12.0,))
        assert table["found"][1] == pytest.approx(expected["found"][0], abs=5e-5)
        assert table["false_alarms"][3] < table["false_alarms"][1]
        report = (tmp_path / "out" / "report.md").read_text(encoding="utf-8")
        assert "Largest deviation from theory" in report
        assert "nan" not in report

    def test_a_deviation_is_said(self) -> None:
        row = {"size_sigma": 0.0, "level": 0.001, "power": 0.5, "power_theory": 0.4, "power_mcse": 0.02}
        one = pd.DataFrame([{**row, "false_alarms": 0.0012, "false_alarms_mcse": 0.0001}])
        np.testing.assert_allclose(detection_page.worst_deviation(one), (5.0, 2.0))

    @pytest.mark.parametrize("arguments", [["no-such-preset"], ["rheidt-1980", "--ap", "no-such-set"]])
    def test_wrong_calls(self, arguments: list[str]) -> None:
        done = CliRunner().invoke(main, ["detection", *arguments])
        assert done.exit_code == 2
        assert "no-such" in done.stderr
