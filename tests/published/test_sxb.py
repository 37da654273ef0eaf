"""The real block: five aerial photographs of Strasbourg with the adjustment that the Damped Bundle Adjustment Toolbox
published. Nobody here made these figures; the tolerances are those of their printed digits.
"""

import json
import os
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from studies.commands.program import main

FOLDER = Path(os.environ.get("SIMFIELD_SXB", Path(__file__).resolve().parents[2].parent / "shared" / "data" / "sxb"))
POSITION_TOLERANCE_M = 1e-3
ANGLE_TOLERANCE_DEG = 2e-6
STD_TOLERANCE = 0.005
POINT_TOLERANCE_M = 1e-3
SIGMA0_TOLERANCE = 0.5e-4
POSITIONS, ANGLES = ("X0", "Y0", "Z0"), ("omega_deg", "phi_deg", "kappa_deg")

pytestmark = pytest.mark.skipif(
    not (FOLDER / "expected.json").exists(),
    reason=f"the data set sxb is not at {FOLDER}; set SIMFIELD_SXB to its folder",
)


@pytest.fixture(scope="module")
def expected():
    return json.loads((FOLDER / "expected.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def found():
    done = CliRunner().invoke(main, ["adjust", str(FOLDER), "--ap", "none", "--json", "-"])
    assert done.exit_code == 0, done.stderr
    return json.loads(done.stdout)


def test_counts_and_sigma0(found, expected):
    counts = (found["observations"], found["unknowns"], found["redundancy"])
    assert counts == (expected["n_obs"], expected["n_params"], expected["redundancy"])
    assert found["sigma0"] == pytest.approx(expected["sigma0"], abs=SIGMA0_TOLERANCE)
    assert found["status"] == "converged"


def test_orientations_and_their_standard_deviations(found, expected):
    images = list(found["images"].values())
    assert len(images) == len(expected["eo"]) == 5
    for image, published in zip(images, expected["eo"], strict=True):
        for name in POSITIONS:
            assert image[f"{name}_m"]["value"] == pytest.approx(published[name], abs=POSITION_TOLERANCE_M)
            assert image[f"{name}_m"]["std"] == pytest.approx(published[f"std_{name}"], rel=STD_TOLERANCE)
        for name in ANGLES:
            assert image[name]["value"] == pytest.approx(published[name], abs=ANGLE_TOLERANCE_DEG)
            assert image[name]["std"] == pytest.approx(published[f"std_{name}"], rel=STD_TOLERANCE)


@pytest.mark.parametrize(("kind", "count"), [("control", 14), ("check", 2)])
def test_control_and_check_points(found, expected, kind, count):
    published = expected[kind]["points"]
    assert len(published) == count
    for name, point in published.items():
        values = [found["points"][name][f"{axis}_m"]["value"] for axis in "XYZ"]
        np.testing.assert_allclose(values, point["posterior"], atol=POINT_TOLERANCE_M, rtol=0.0)


def test_check_points_are_compared_with_what_is_given(found, expected):
    points = expected["check"]["points"].values()
    differences = np.array([np.subtract(p["posterior"], p["prior"]) for p in points])
    rms = np.sqrt(np.mean(differences**2, axis=0))
    check = found["check"]
    assert check["n"] == 2
    np.testing.assert_allclose([check["rms_x_m"], check["rms_y_m"], check["rms_z_m"]], rms, atol=POINT_TOLERANCE_M)
    assert check["rms_xy_m"] == pytest.approx(np.hypot(*rms[:2]), abs=POINT_TOLERANCE_M)
