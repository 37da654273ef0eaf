"""A study that names a measure which does not exist is refused before it runs, and says what there is."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from studies.commands.program import main
from studies.design import Plan, StudyError, shipped
from studies.run.story import refuse_wrong_settings
from studies.store import Store
from studies.summary import summarise
from studies.summary.measure_names import measure_faults
from tests.studies.small_study import TEXT, run_here, study

WRONG = {
    "a typo": ("m0_mm", "did you mean 'm0_um'"),
    "a typo in capitals": ("M0_um", "did you mean 'm0_um'"),
    "an unknown of no camera": ("bias sww.a3", "there is no measure"),
    "a parameter of no set": ("emp_se ww.b14", "there is no measure"),
    "a form that is none": ("biass ww.a3", "did you mean 'bias'"),
    "a form alone": ("bias", "there is no measure"),
    "a pair of nobody": ("correlation ww.a3~ww.a9", "there is no measure"),
    "nothing": ("", "there is no measure"),
}


def plan_with(line: str) -> Plan:
    return Plan.of(study(TEXT, ("[report]\n", f"[report]\n{line}\n")))


@pytest.mark.parametrize(("measure", "said"), WRONG.values(), ids=WRONG)
def test_a_measure_that_does_not_exist_is_refused(measure: str, said: str) -> None:
    with pytest.raises(StudyError, match=r"report\.measures\[1\]: ") as error:
        refuse_wrong_settings(plan_with(f'measures = ["m0_um", "{measure}"]'))
    assert said in str(error.value)


def test_every_name_at_once_and_its_place() -> None:
    text = TEXT.replace("block = 32", 'block = 32\ntarget_mcse = { mu_x_mm = 0.1, "bias *" = 0.1, "foo *" = 1.0 }')
    plan = Plan.of(study(text, ("[report]\n", '[report]\nrank_by = "true_z"\nmeasures = ["mu_z_m"]\n')))
    assert [line.partition(": ")[0] for line in measure_faults(plan)] == [
        "report.measures[0]", "report.rank_by", "trials.target_mcse.mu_x_mm", "trials.target_mcse.foo *",
    ]  # fmt: skip


def test_all_measures_of_a_summary_are_known(tmp_path: Path) -> None:
    """Every row of a real summary has a name that a study may ask for."""
    run_here(tmp_path)
    plan = Plan.of(study())
    rows = summarise(plan, Store(tmp_path, plan.identity_hash)).rows
    names = sorted({str(row["measure"]) for row in rows})
    assert len(names) > 60
    listed = ", ".join(f'"{name}"' for name in names)
    assert list(measure_faults(plan_with(f"measures = [{listed}]"))) == []


@pytest.mark.parametrize("name", shipped.names())
def test_the_studies_that_ship_name_measures_that_exist(name: str) -> None:
    assert list(measure_faults(Plan.of(shipped.study(name)))) == []


@pytest.mark.parametrize("options", [[], ["--dry-run"]])
def test_the_command_says_it_before_anything_is_written(tmp_path: Path, options: list[str]) -> None:
    (tmp_path / "s.toml").write_text(TEXT.replace("[report]\n", '[report]\nmeasures = ["coverage"]\n'))
    done = CliRunner().invoke(main, ["run", str(tmp_path / "s.toml"), "--out", str(tmp_path / "out"), *options])
    assert done.exit_code != 0
    assert "report.measures[0]" in done.output
    assert not (tmp_path / "out").exists()


LEVELS = {
    "a label like a number": '[1.0, "1"]',
    "a label like a whole number": '[{ label = "3", value = 4.0 }, 3]',
}


@pytest.mark.parametrize("levels", LEVELS.values(), ids=LEVELS)
def test_levels_that_look_alike_are_refused(levels: str) -> None:
    with pytest.raises(StudyError, match=r"grid\.noise_um\[1\]: .* looks like .* before it"):
        study(TEXT, ("noise_um = [3.0, 6.0]", f"noise_um = {levels}"))


def test_a_study_without_conditions_is_refused() -> None:
    with pytest.raises(StudyError, match="exclude: leaves no condition"):
        study(TEXT + "\n[[exclude]]\nnoise_um = 3.0\n[[exclude]]\nnoise_um = 6.0\n")


def test_a_rule_that_excludes_nothing_is_refused() -> None:
    with pytest.raises(StudyError, match=r"exclude\[0\]: fits no condition"):
        study(TEXT + "\n[[exclude]]\nnoise_um = 4.0\n")
