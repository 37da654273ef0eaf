"""The protocol of the real block against the published report, wherever both have a figure."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from studies.commands.program import main
from tests.published.test_sxb import FOLDER, POINT_TOLERANCE_M, STD_TOLERANCE, expected as expected

PIXEL_UM = 6.0
RMS_TOLERANCE_PX = 0.5e-3

pytestmark = pytest.mark.skipif(
    not (FOLDER / "expected.json").exists(),
    reason=f"the data set sxb is not at {FOLDER}; set SIMFIELD_SXB to its folder",
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("sxb")
    done = CliRunner().invoke(main, ["adjust", str(FOLDER), "--ap", "none", "-o", str(out)])
    assert done.exit_code == 0, done.stderr
    return out


@pytest.fixture(scope="module")
def protocol(folder):
    return json.loads((folder / "protocol.json").read_text(encoding="utf-8"))


def test_counts_and_unit_weight(protocol, expected):
    assert protocol["observations"] == expected["n_obs"]
    assert protocol["unknowns"] == expected["n_params"]
    assert protocol["redundancy"] == expected["redundancy"]
    assert protocol["data"]["image_points"] == expected["n_image_points"]
    assert protocol["m0_um"] / PIXEL_UM == pytest.approx(expected["sigma0_px"], abs=0.5e-4)
    assert np.sqrt(protocol["global_test"]["vpv"]) == pytest.approx(expected["last_error_sqrt_vPv"], abs=0.5e-3)
    assert sum(group["redundancy"] for group in protocol["groups"]) == pytest.approx(expected["redundancy"], abs=1e-6)


def test_residuals_by_image(protocol, expected):
    """Of both coordinates together, in pixels."""
    rms = [np.hypot(e["rms_x_um"], e["rms_y_um"]) / PIXEL_UM for e in protocol["residuals_by_image"]]
    published = expected["photo_rms_px"]
    assert min(rms) == pytest.approx(published["min"], abs=RMS_TOLERANCE_PX)
    assert max(rms) == pytest.approx(published["max"], abs=RMS_TOLERANCE_PX)
    assert (np.argmin(rms) + 1, np.argmax(rms) + 1) == (published["min_photo"], published["max_photo"])
    n = np.array([e["n"] for e in protocol["residuals_by_image"]])
    whole = np.sqrt(np.sum(n * np.square(rms)) / n.sum())
    assert whole == pytest.approx(expected["point_marking_rms_px"], abs=RMS_TOLERANCE_PX)


def test_the_largest_residual(folder, expected):
    rows = np.genfromtxt(folder / "observations.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    largest = 1000.0 * np.hypot(rows["vx_mm"], rows["vy_mm"]).max() / PIXEL_UM
    assert largest == pytest.approx(expected["max_residual_px"], abs=RMS_TOLERANCE_PX)


def test_control(protocol, expected):
    published = expected["control"]["points"]
    assert len(protocol["control"]) == 3 * len(published)
    for each in protocol["control"]:
        point, axis = published[each["point"]], "XYZ".index(each["coordinate"])
        assert each["v_m"] == pytest.approx(point["posterior"][axis] - point["prior"][axis], abs=POINT_TOLERANCE_M)
        std = protocol["points"][each["point"]][f"{each['coordinate']}_m"]["std"]
        assert std == pytest.approx(point["posterior_std"][axis], rel=STD_TOLERANCE, abs=0.5e-4)
    squares = sum(each["v_m"] ** 2 for each in protocol["control"])
    assert np.sqrt(squares / len(published)) == pytest.approx(expected["control"]["rms"], abs=0.5e-3)


def test_the_weakest_points(protocol, expected):
    for axis in "XYZ":
        std, name = expected[f"max_{axis}_std"]
        found = {point: each[f"{axis}_m"]["std"] for point, each in protocol["points"].items()}
        weakest = max(found, key=found.get)
        assert weakest == name.removeprefix("OP ")
        assert found[weakest] == pytest.approx(std, rel=0.03)
