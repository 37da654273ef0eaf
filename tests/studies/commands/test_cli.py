"""The command line: exit codes, streams, and what `adjust --json` holds."""

import json
import re
import shutil
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pytest
from click.testing import CliRunner

from studies.commands.program import main
from studies.session.installation import LIBRARIES

HELP_SECONDS = 1.0
"""a bound for a loaded machine; 0.1 s is usual"""


def call(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("cli") / "block"
    done = call("simulate", "grid-small", "--seed", 7, "-o", path)
    assert done.exit_code == 0, done.output
    return path


@pytest.fixture
def datumless(folder, tmp_path):
    """The same block with all control coordinates unknown: without their standard deviations they are start values."""
    copy = tmp_path / "datumless"
    shutil.copytree(folder, copy)
    points = copy / "points.csv"
    rows = [line.split(",") for line in points.read_text().splitlines()]
    points.write_text("".join(",".join([*r[:5], "", "", ""] if r[1] == "control" else r) + "\n" for r in rows))
    return copy


def no_nan(value):
    if isinstance(value, dict):
        return all(no_nan(v) for v in value.values())
    if isinstance(value, list):
        return all(no_nan(v) for v in value)
    return value == value


def test_simulate_writes_block_and_truth(folder):
    names = {p.name for p in folder.iterdir()}
    assert {"cameras.csv", "images.csv", "points.csv", "observations.csv", "truth.json"} <= names


def test_adjust_json_has_the_contract_s_keys(folder):
    done = call("adjust", folder, "--ap", "optical", "--set", "r0_mm=90", "--json", "-")
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert no_nan(found)
    assert found["observations"] - found["unknowns"] == found["redundancy"]
    assert found["status"] == "converged"
    assert list(found["ap"]["ww"]) == ["a3", "a4", "a5", "a6"]
    assert found["ap"]["ww"]["a3"]["std"] > 0.0
    image = next(iter(found["images"].values()))
    assert list(image) == ["X0_m", "Y0_m", "Z0_m", "omega_deg", "phi_deg", "kappa_deg"]
    assert list(next(iter(found["points"].values()))) == ["X_m", "Y_m", "Z_m"]
    assert found["check"] == {"n": 0, "rms_x_m": None, "rms_y_m": None, "rms_xy_m": None, "rms_z_m": None}
    strong = found["correlations"]
    assert all(0.95 < abs(pair["r"]) <= 1.0 for pair in strong)
    assert {"owner", "name"} == set(strong[0]["a"])


def test_a_setting_reaches_the_model(folder):
    one, other = (
        json.loads(call("adjust", folder, "--ap", "optical", "--set", f"r0_mm={r0}", "--json", "-").stdout)["images"]
        for r0 in (0, 100)
    )
    heights = [next(iter(images.values()))["Z0_m"]["std"] for images in (one, other)]
    assert heights[0] != pytest.approx(heights[1], rel=0.05)


def test_adjust_page_and_json_file(folder, tmp_path):
    page = call("adjust", folder, "--ap", "optical")
    assert page.exit_code == 0
    assert "redundancy" in page.stdout
    assert "a3" in page.stdout
    path = tmp_path / "a.json"
    quiet = call("adjust", folder, "--ap", "none", "--json", path)
    assert quiet.exit_code == 0
    assert quiet.stdout == ""
    assert json.loads(path.read_text())["ap"] == {"ww": {}}


def test_singular_block_exits_1_with_one_line_and_json(datumless):
    done = call("adjust", datumless, "--ap", "none", "--json", "-")
    assert done.exit_code == 1
    assert len(done.stderr.strip().splitlines()) == 1
    assert "singular" in done.stderr
    found = json.loads(done.stdout)
    assert found["status"] == "singular"
    assert found["sigma0"] is None
    assert next(iter(found["images"].values()))["Z0_m"] == {"value": None, "std": None}


def test_defective_block_exits_1_and_names_the_file(folder, tmp_path):
    copy = tmp_path / "defective"
    shutil.copytree(folder, copy)
    (copy / "cameras.csv").write_text("camera_id,c_mm\nww,153\n")
    done = call("adjust", copy, "--ap", "none")
    assert done.exit_code == 1
    assert "cameras.csv" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["--ap", "brown13"], "brown14"),
        (["--ap", "optical", "--set", "r9=1"], "r0_mm"),
        (["--ap", "optical", "--set", "r0_mm"], "NAME=VALUE"),
        (["--ap", "optical", "--set", "r0_mm=wide"], "float"),
        (["--ap", "optical", "--set", "r0_mm=nan"], "finite"),
        (["--ap", "brown14", "--set", "as_printed=perhaps"], "true or false"),
        ([], "--ap"),
    ],
)
def test_wrong_calls_exit_2(folder, arguments, word):
    done = call("adjust", folder, *arguments)
    assert done.exit_code == 2
    assert word in done.stderr


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["adjust", "no-such-folder", "--ap", "none"], "no-such-folder"),
        (["simulate", "rheid-1980", "--seed", "1", "-o", "x"], "rheidt-1980"),
        (["simulate", "absent.toml", "--seed", "1", "-o", "x"], "absent.toml"),
        (["reproduce", "mauelshagen-1981"], "mauelshagen-1980"),
        (["reproduce", "mauelshagen-1980", "--trials", "1"], "trials"),
        (["models", "--draw", "x.svg"], "ID"),
        (["nonsense"], "nonsense"),
    ],
)
def test_wrong_names_exit_2(arguments, word):
    done = call(*arguments)
    assert done.exit_code == 2
    assert word in done.stderr


def test_models_lists_and_describes(tmp_path):
    assert "brown14" in call("models").stdout
    path = tmp_path / "m.svg"
    described = call("models", "optical", "--draw", path)
    assert described.exit_code == 0
    assert "a3" in described.stdout
    assert path.exists()


def test_doctor_is_content():
    done = call("doctor")
    assert done.exit_code == 0, done.output
    assert "numpy" in done.stdout


def test_doctor_asks_for_every_dependency():
    declared = tomllib.loads((Path(__file__).parents[3] / "pyproject.toml").read_text(encoding="utf-8"))
    assert [re.split("[<>=]", each)[0] for each in declared["project"]["dependencies"]] == list(LIBRARIES)


def test_interrupt_exits_130(folder, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("simfield.files.read_block", interrupted)
    assert call("adjust", folder, "--ap", "none").exit_code == 130


def test_termination_exits_143(tmp_path):
    """Long after the command has begun, and hours before it would end."""
    call_it = [
        sys.executable,
        "-c",
        "from studies.commands.program import main; main()",
        "reproduce",
        "mauelshagen-1980",
    ]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    arguments = ["--jobs", "1", "--trials", "10000000", "--out", str(tmp_path)]
    with subprocess.Popen([*call_it, *arguments], **pipes) as process:
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(timeout=6.0)
        process.terminate()
        assert process.wait(timeout=30) == 143


def test_help_is_quick_and_imports_nothing_heavy():
    code = (
        "import sys\nfrom studies.commands.program import main\nmain(['--help'], standalone_mode=False)\n"
        "names = {'numpy', 'pandas', 'scipy', 'matplotlib', 'pydantic', 'joblib', 'numba', 'pyarrow', 'marimo'}\n"
        "heavy = names & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    started = time.monotonic()
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, timeout=30)
    assert time.monotonic() - started < HELP_SECONDS


def test_another_adjust_in_the_way_is_named_by_its_path(tmp_path):
    (tmp_path / "adjust").mkdir()
    (tmp_path / "adjust" / "__init__.py").write_text("")
    code = "from studies.commands.program import main; main(['doctor'])"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=30, cwd=tmp_path, check=False
    )
    assert done.returncode == 1
    assert str(tmp_path / "adjust") in done.stdout
