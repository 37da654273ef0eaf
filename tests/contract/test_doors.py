"""Doors are light, and what is said once stays so."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

import adjust
from adjust.reductions.reduction import REDUCTIONS
from simfield.block.wording import nearest, resembling
from simfield.chain.presets import STAGES
from studies.commands.program import main

TOP = Path(__file__).parents[2]
HEAVY = ("scipy", "numba", "pandas", "pyarrow", "matplotlib", "joblib")
PACKAGES = ("simfield", "adjust", "studies")
MODULES = {
    ".".join(path.relative_to(TOP).with_suffix("").parts).removesuffix(".__init__"): path
    for package in PACKAGES
    for path in (TOP / package).rglob("*.py")
}
HELP = (
    "from studies.commands.program import main; from click.testing import CliRunner; "
    "assert CliRunner().invoke(main, ['--help']).exit_code == 0"
)


@pytest.mark.parametrize(
    ("code", "kept_out"),
    [
        ("import adjust", (*HEAVY, "numpy")),
        ("from adjust import ap_models; ap_models.get('brown14')", HEAVY),
        ("import simfield.simulate", HEAVY),
        ("import studies.design.plan, studies.design.study_file", HEAVY),
        (HELP, (*HEAVY, "numpy", "simfield", "adjust", "pydantic")),
    ],
)
def test_a_door_opens_without_what_is_heavy(code: str, kept_out: tuple[str, ...]) -> None:
    code += f"; import sys; print([m for m in {kept_out} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], cwd=TOP, capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == "[]"


def test_all_that_adjust_says_is_there() -> None:
    assert set(adjust.__all__) <= set(dir(adjust))
    things = {name: getattr(adjust, name) for name in adjust.__all__ if name != "MOTIONS"}
    assert {thing.__name__.rpartition(".")[2] for thing in things.values()} == set(things)
    with pytest.raises(AttributeError, match="adjust_blocks"):
        _ = adjust.adjust_blocks  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("said", "where"),
    [
        ("get_close_matches(", ["simfield/block/wording.py"]),
        ("\nFORMULA = ", ["studies/texts/spreadsheet.py"]),
        ("\nTOGETHER = ", ["simfield/numerics/lanes.py"]),
        ("\nSTAGES: ", ["simfield/chain/presets.py"]),
        ("\nREDUCTIONS = ", ["adjust/reductions/reduction.py"]),
    ],
)
def test_what_is_said_once_is_said_once(said: str, where: list[str]) -> None:
    paths = sorted(path for path in MODULES.values() if said in path.read_text(encoding="utf-8"))
    assert [path.relative_to(TOP).as_posix() for path in paths] == where


def test_a_name_is_compared_without_capitals_and_outer_spaces_and_not_for_ever() -> None:
    assert resembling(" Image_ID", ["image_id", "x"]) == "image_id"
    assert nearest("zzz", ["b", "a"]) == "; known are a, b"
    assert resembling("x" * 5_000_000, ["xx", "x" * 60]) == "x" * 60


@pytest.mark.parametrize(("command", "names"), [("simulate", tuple(STAGES)), ("reduce", REDUCTIONS)])
def test_choices_that_are_asked_for_late_are_shown_and_kept_to(
    command: str, names: tuple[str, ...], tmp_path: Path
) -> None:
    shown = CliRunner().invoke(main, [command, "--help"], terminal_width=300)
    assert f"[{'|'.join(names)}]" in shown.output
    more = ["rheidt-1980", "--seed", "1", "--raw"] if command == "simulate" else [str(tmp_path)]
    refused = CliRunner().invoke(main, [command, *more, "-o", str(tmp_path / "out"), "--without", "lenses"])
    assert refused.exit_code == 2
    assert "'lenses' is not one of 'refraction'" in refused.output or "'lenses' is not one of 'drift'" in refused.output
    assert not (tmp_path / "out").exists()
