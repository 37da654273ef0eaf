"""The protocol: its figures are those of the adjustment, its files can be read, its advice fits the case."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from adjust import Adjustment, adjust_block, ap_models
from adjust.quality.inspection import inspected
from adjust.quality.model_choice import aic, bic, leave_one_image_out
from adjust.quality.reliability import Reliability
from simfield.block.block import Block
from simfield.files.block_folder import write_block
from studies.commands.program import main
from studies.protocol import files as protocol_files, record as protocol, text as protocol_text
from tests import synthetic


@pytest.fixture(scope="module")
def a(two_camera_world: synthetic.World) -> Adjustment:
    w = two_camera_world.controlled(synthetic.CONTROL, (0.02, 0.02, 0.03)).with_noise(np.random.default_rng(3))
    xy = w.block.observations.xy.copy()
    xy[40, 1] += 20.0 * synthetic.SIGMA_MM
    return adjust_block(w.with_image_points(xy).block, ap_models.get("torlegard"))


@pytest.fixture(scope="module")
def found(a: Adjustment) -> protocol.Record:
    return protocol.record(a)


def read(path: Path) -> list[list[str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file))


def test_the_figures_are_those_of_the_adjustment(a: Adjustment, found: protocol.Record) -> None:
    assert found["sigma0"] == a.sigma0
    assert found["global_test"]["vpv"] == a.vpv
    assert sum(group["redundancy"] for group in found["groups"]) == pytest.approx(a.redundancy, abs=1e-7)
    assert sum(group["vpv"] for group in found["groups"]) == pytest.approx(a.vpv, rel=1e-9)
    assert [group["group"] for group in found["groups"]] == ["images of ww", "images of sww", "control"]
    assert found["datum"]["weighted"] == {"X": 5, "Y": 5, "Z": 5}
    assert sum(ring["n"] for ring in found["residuals_by_radius"]) == len(a.block.observations)
    assert sum(image["n"] for image in found["residuals_by_image"]) == len(a.block.observations)
    assert [each["name"] for each in found["ap_significance"]["sww"]] == list(a.ap["sww"].names)
    assert len(found["control"]) == 15
    assert found["model_choice"] == {
        "aic": aic(a),
        "bic": bic(a),
        "leave_one_image_out_um": leave_one_image_out(a).rms_um,
    }


def test_the_planted_error_is_suspected(a: Adjustment, found: protocol.Record) -> None:
    o, b = a.block.observations, a.block
    name = f"y of point {b.points.ids[o.point[40]]} in image {b.images.ids[o.image[40]]}"
    assert [each["observation"] for each in found["suspected"]] == [name]
    assert found["suspected"][0]["error"] == pytest.approx(20.0 * synthetic.SIGMA_MM, abs=0.02)
    assert name in found["advice"][0]


def test_files(a: Adjustment, tmp_path: Path) -> None:
    files = protocol_files.write(a, tmp_path / "new" / "folder")
    assert [f.name for f in files] == ["protocol.txt", "protocol.json", "observations.csv", "correlations.csv"]
    header, *rows = read(files[2])
    assert tuple(header) == protocol_files.OBSERVATIONS
    assert len(rows) == len(a.block.observations)
    values = np.array([[float(cell) for cell in row[2:]] for row in rows])
    np.testing.assert_allclose(values[:, :2], a.residuals, rtol=0.0, atol=0.6e-6)
    quality = Reliability.of(a)
    np.testing.assert_allclose(values[:, 2:4].ravel(), quality.redundancy[quality.image_points], rtol=0.0, atol=1e-5)
    np.testing.assert_allclose(values[:, 4:6].ravel(), quality.w[quality.image_points], rtol=0.0, atol=1e-4)
    tested = inspected(a, most=protocol.ACCUSED_MOST).reliability
    np.testing.assert_allclose(values[:, 6:].ravel(), tested.mdb[tested.image_points], rtol=0.0, atol=1e-6)
    header, *rows = read(files[3])
    size = a.layout.orientation
    assert len(header) == size + 1
    r = np.array([[float(cell) for cell in row[1:]] for row in rows])
    np.testing.assert_array_equal(np.diag(r), 1.0)
    i, j = header.index("ww a3") - 1, header.index("ww a4") - 1
    assert r[i, j] == pytest.approx(a.correlation(("ww", "a3"), ("ww", "a4"))[0, 1], abs=1e-6)
    assert json.loads(files[1].read_text(encoding="utf-8"))["redundancy"] == a.redundancy


def test_the_text_has_every_chapter(found: protocol.Record) -> None:
    text = protocol_text.page(found)
    for title in (
        "Advice",
        "Datum",
        "Adjustment",
        "Reliability of the image coordinates",
        "Residuals by radius",
        "Points",
    ):
        assert f"\n{title}\n{'-' * len(title)}\n" in text
    assert "nan" not in text
    assert max(len(line) for line in text.splitlines()) <= 150


def test_nothing_to_be_done(ww_world: synthetic.World) -> None:
    w = ww_world.with_noise(np.random.default_rng(1))
    role = np.where(np.arange(len(w.block.points)) == 7, "check", w.block.points.role)
    coordinates = np.where((role == "check")[:, None], w.coordinates, w.block.points.coordinates)
    found = protocol.record(adjust_block(w.with_points(role=role.tolist(), coordinates=coordinates).block))
    assert found["advice"] == []
    assert "Nothing to be done." in protocol_text.page(found)
    assert protocol_text.page(found).count("\nnone\n") >= 3


@pytest.mark.parametrize(("factor", "said"), [(0.5, "is larger than 1"), (2.0, "is smaller than 1")])
def test_wrong_standard_deviations(ww_world: synthetic.World, factor: float, said: str) -> None:
    b = ww_world.with_noise(np.random.default_rng(1)).block
    o = b.observations
    wrong = Block(b.cameras, b.images, b.points, type(o)(o.image, o.point, o.xy, factor * o.sigma))
    advice = protocol.record(adjust_block(wrong))["advice"]
    assert any(said in sentence and "ultiply" in sentence for sentence in advice), advice


def test_systematic_residuals_and_idle_parameters(ww_world: synthetic.World) -> None:
    model = ap_models.get("torlegard")
    flight = [(synthetic.WW, synthetic.fly(synthetic.WW, 10500.0))]
    ap = {"ww": np.array([0.0, 0.0, -5e-8, 2e-12, 0.0, 0.0])}
    w = synthetic.world(flight, synthetic.quincunx(per_group=3), {"ww": model}, ap).with_noise(np.random.default_rng(4))
    without = protocol.record(adjust_block(w.block))["advice"]
    assert any("Radial residuals of camera ww are systematic" in sentence for sentence in without)
    many = protocol.record(adjust_block(w.block, ap_models.get("ebner12")))["advice"]
    assert any("are not significant" in sentence for sentence in many)


def test_the_command(ww_world: synthetic.World, tmp_path: Path) -> None:
    write_block(ww_world.with_noise(np.random.default_rng(1)).block, tmp_path / "block")
    out = tmp_path / "protocol"
    done = CliRunner().invoke(main, ["adjust", str(tmp_path / "block"), "--ap", "optical", "-o", str(out)])
    assert done.exit_code == 0, done.output
    assert [Path(line).name for line in done.stdout.splitlines()] == [
        "protocol.txt",
        "protocol.json",
        "observations.csv",
        "correlations.csv",
    ]
    assert sorted(f.name for f in out.iterdir()) == [
        "correlations.csv",
        "observations.csv",
        "protocol.json",
        "protocol.txt",
    ]
    (tmp_path / "file").write_text("", encoding="utf-8")
    done = CliRunner().invoke(
        main, ["adjust", str(tmp_path / "block"), "--ap", "none", "-o", str(tmp_path / "file" / "x")]
    )
    assert done.exit_code == 1
    assert "cannot be written" in done.stderr


@pytest.mark.parametrize("datum", ["minimum", "inner"])
def test_other_datums(ww_world: synthetic.World, tmp_path: Path, datum: str) -> None:
    write_block(ww_world.with_noise(np.random.default_rng(1)).block, tmp_path / "block")
    call = ["adjust", str(tmp_path / "block"), "--ap", "optical", "--datum", datum, "-o", str(tmp_path / "out")]
    done = CliRunner().invoke(main, call)
    assert done.exit_code == 0, done.output
    found = json.loads((tmp_path / "out" / "protocol.json").read_text(encoding="utf-8"))
    assert found["datum"]["rank_defect"] == (7 if datum == "inner" else 0)
    assert len(found["datum"]["points"]) == (5 if datum == "inner" else 3)
    assert sum(group["redundancy"] for group in found["groups"]) == pytest.approx(found["redundancy"], abs=1e-6)
