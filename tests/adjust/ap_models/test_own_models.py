"""A set in the user's own file: the one of docs/own-models.md, by the names under which the user has it."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from adjust import ApModel, adjust_block, ap_models
from adjust.trials.replicates import adjust_replicates
from simfield import build_world, presets, write_block
from studies.commands.program import main

DOCUMENT = Path(__file__).parents[3] / "docs" / "own-models.md"
CODE = re.findall(
    r"^```python\n(# spiral.py\n.*?)^```", DOCUMENT.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
)[0]
AMOUNT = np.array([2e-5, -1e-5, 3e-5])


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "spiral.py").write_text(CODE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def model(folder: Path) -> ApModel:
    return ap_models.get("spiral.py:Spiral", scale_mm=90.0)


def distorted(model: ApModel):
    """A block with this distortion and without noise, made from the simulator's ideal image points."""
    world = build_world(presets["grid-small"], seed=4)
    block, _ = world.observe()
    measured = world.ideal
    for _ in range(30):
        measured = world.ideal + model.basis(*measured.T) @ AMOUNT
    return block.replace_image_points(measured)


def test_it_is_a_set_like_any_other(model: ApModel) -> None:
    assert model.parameters == ("a1", "a2", "a3")
    assert model.settings == {"scale_mm": 90.0}
    assert ap_models.get("spiral.py:Spiral", scale_mm=90.0) == model
    assert ap_models.get("spiral.py:Spiral") != model


def test_it_works_in_adjust_block(model: ApModel) -> None:
    a = adjust_block(distorted(model), model)
    assert a.status.ok, a.message
    np.testing.assert_allclose(a.ap["ww"].values, AMOUNT, rtol=1e-7)


def test_it_is_compiled_for_replicates(model: ApModel) -> None:
    block = distorted(model)
    o = block.observations
    trials = o.xy + o.sigma * np.random.default_rng(1).standard_normal((40, *o.xy.shape))
    found = adjust_replicates(block, model, trials)
    assert found.finished_by_gauss_newton == 0
    alone = adjust_block(block.replace_image_points(trials[7]), model)
    assert (np.abs(found.ap("ww")[7] - alone.ap["ww"].values) <= 1e-7 * alone.ap["ww"].std).all()


@pytest.mark.slow
def test_it_travels_to_other_processes(model: ApModel) -> None:
    block = distorted(model)
    o = block.observations
    trials = o.xy + o.sigma * np.random.default_rng(1).standard_normal((600, *o.xy.shape))
    here, there = (adjust_replicates(block, model, trials, jobs=jobs).trials.x for jobs in (1, 2))
    np.testing.assert_array_equal(here, there)


STUDY = """
[study]
name = "spiral"
question = "Does a set of the user's own work?"
seed = 1
[scenario]
preset = "grid-small"
[methods]
ap = ["none", {id = "spiral.py:Spiral", scale_mm = 90}]
"""


@pytest.mark.parametrize("jobs", ["1", pytest.param("2", marks=pytest.mark.slow)])
def test_it_works_in_a_study(folder: Path, jobs: str) -> None:
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    command = ["run", "study.toml", "--trials", "64", "--jobs", jobs, "--out", "results"]
    program = [sys.executable, "-c", "from studies.commands.program import main; main()"]
    run = subprocess.run([*program, *command], cwd=folder, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    table = (folder / "results" / "summary.csv").read_text(encoding="utf-8").splitlines()
    assert any(
        line.startswith("spiral.py:Spiral scale_mm=90") or ",spiral.py:Spiral scale_mm=90," in line for line in table
    )
    assert any("bias ww.a3" in line for line in table)


def test_it_works_on_the_command_line(folder: Path) -> None:
    write_block(build_world(presets["grid-small"], seed=4).observe()[0], folder / "block")
    run = CliRunner().invoke(main, ["adjust", "block", "--ap", "spiral.py:Spiral", "--set", "scale_mm=90"])
    assert run.exit_code == 0, run.output
    assert "a3" in run.output
    run = CliRunner().invoke(main, ["models", "spiral.py:Spiral"])
    assert run.exit_code == 0, run.output


@pytest.mark.parametrize(
    ("reference", "said"),
    [
        ("nothing.py:Spiral", "nothing.py: No such file"),
        ("spiral.py:Circle", "spiral.py has no class 'Circle'"),
        ("spiral.py:np", "is no subclass of adjust.ApModel"),
        ("no_such_module:Spiral", "cannot be imported: ModuleNotFoundError"),
        ("broken.py:Spiral", "cannot be run: ZeroDivisionError"),
    ],
)
def test_what_cannot_be_loaded_is_refused_in_one_line(folder: Path, reference: str, said: str) -> None:
    (folder / "broken.py").write_text("1 / 0\n", encoding="utf-8")
    with pytest.raises(KeyError, match=said):
        ap_models.get(reference)
    run = CliRunner().invoke(main, ["models", reference])
    assert run.exit_code == 2
    assert said in run.output


def test_a_wrong_setting_is_refused_by_name(folder: Path) -> None:
    with pytest.raises(TypeError, match="has no setting 'radius_mm', it has: scale_mm"):
        ap_models.get("spiral.py:Spiral", radius_mm=1.0)
