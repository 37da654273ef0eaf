"""Running studies: what is written, that it is the same in any way of computing, extension, parts, summary, replay."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest

from adjust import adjust_block, ap_models
from simfield import build_world
from studies.comparison import measures
from studies.design.plan import Plan
from studies.design.study import Study, StudyError
from studies.run.one_trial import condition_named, replay
from studies.run.verification import verify
from studies.store.look import joined
from studies.store.shards import BEFORE
from studies.store.store import Store, StoreError
from studies.summary import stopping, summary
from studies.summary.cells import Cell, correlated, measured
from studies.trials.block_of_trials import compute
from tests.studies.small_study import TEXT, contents, run_here, study


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder: Path = tmp_path_factory.mktemp("store")
    run_here(folder)
    return folder


CERTAIN = ("formal", "parameters", "largest_ap_exterior", "condition_number")
"""measures of the noise-free adjustment, without a Monte-Carlo error"""


def rows_of(folder: Path, name: str = "summary.csv") -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO((folder / name).read_text(encoding="utf-8"))))


def test_a_run_leaves_summary_report_and_figures(store: Path) -> None:
    names = {"summary.csv", "summary.parquet", "differences.csv", "report.md", "figure.svg", "figure.png", "study.toml"}
    assert names <= {p.name for p in store.iterdir()}
    assert (store / "study.toml").read_text(encoding="utf-8") == TEXT
    header = (store / "summary.csv").read_text(encoding="utf-8").splitlines()[0]
    assert header == "condition,noise_um,ap,method,measure,unit,n,failures,estimate,mcse"
    assert not list(store.rglob("*.pkl"))


def test_the_parquet_summary_says_the_same(store: Path) -> None:
    import pyarrow.parquet as pq

    table = pq.read_table(store / "summary.parquet").to_pylist()
    rows = rows_of(store)
    assert len(table) == len(rows)
    for of_parquet, of_csv in zip(table, rows, strict=True):
        assert of_parquet["measure"] == of_csv["measure"]
        if of_csv["estimate"]:
            assert of_parquet["estimate"] == pytest.approx(float(of_csv["estimate"]), rel=1e-9)


def test_every_estimate_has_its_standard_error(store: Path) -> None:
    rows = rows_of(store)
    measures_of_a3 = ("bias", "emp_se", "model_se", "model_se_error", "rmse", "coverage")
    wanted = {"m0_um", "mu_xy_mm", "mu_z_mm", "coverage_z", "failure_share", *(f"{m} ww.a3" for m in measures_of_a3)}
    assert wanted <= {r["measure"] for r in rows}
    assert all(float(r["mcse"]) > 0.0 for r in rows if not r["measure"].startswith(CERTAIN))
    assert {(r["n"], r["failures"]) for r in rows} == {("96", "0")}


def test_the_columns_of_a_trial_are_those_of_its_single_adjustment() -> None:
    """Brute force: one trial simulated, adjusted and compared on its own, by other code."""
    plan = Plan.of(study())
    condition = plan.conditions[1]
    columns, nominal, reasons = compute(plan.task(condition, 0, {}))
    assert reasons == {}
    world = build_world(condition.scenario, condition.seed)
    for trial in (0, 5, 31):
        block, truth = world.observe(trial)
        a = adjust_block(block, ap_models.get("optical"))
        found = measures.check_points(a, truth)
        key = "optical, cameras all, with aux" + BEFORE
        own = {name.removeprefix(key): values[trial] for name, values in columns.items() if name.startswith(key)}
        assert own["status"] == 0
        # the trials use the cofactors of the nominal geometry, which are good to about 1e-3
        assert own["m0_um"] == pytest.approx(a.m0_um, rel=1e-9)
        assert own["mu_xy_mm"] == pytest.approx(1000 * found.rms_xy_m, rel=1e-6)
        assert own["mu_z_mm"] == pytest.approx(1000 * found.rms_z_m, rel=1e-6)
        assert own["true_z_mm"] == pytest.approx(1000 * found.true.rms_z_m, rel=1e-6)
        assert own["coverage_z"] == pytest.approx(found.coverage_z, abs=0.06)
        assert own["ww.a3"] == pytest.approx(a.ap["ww"]["a3"], rel=1e-6)
    cell = Cell.of("optical, cameras all, with aux", columns, nominal)
    assert cell.std[0, cell.names.index("ww.a3")] == pytest.approx(
        adjust_block(world.observe(0)[0], ap_models.get("optical")).ap["ww"].std[0], rel=5e-3
    )


def test_the_measures_of_a_cell_are_those_of_its_trials(store: Path) -> None:
    plan = Plan.of(study())
    columns, nominal = joined(Store(store, plan.identity_hash), plan, plan.conditions[0], 96)
    cell = Cell.of("optical, cameras all, with aux", columns, nominal)
    found = measured(cell)
    z = cell.names.index("centre.Z")
    assert found["bias centre.Z"].estimate[0] == pytest.approx(float(np.mean(cell.error[:, z])), rel=1e-12)
    assert found["coverage centre.Z"].estimate[0] == pytest.approx(
        float(np.mean(np.abs(cell.error[:, z]) <= 1.99 * cell.std[:, z])), abs=0.05
    )
    assert found["m0_um"].estimate[0] == pytest.approx(float(np.mean(cell.deviations["m0_um"])), rel=1e-12)
    pairs = correlated(cell, 0.0)
    formal, empirical = pairs["ww.a3~ww.a4"]
    assert abs(formal - empirical.estimate[0]) < 4 * empirical.mcse[0]
    i, j = cell.names.index("ww.a3"), cell.names.index("ww.a4")
    assert empirical.estimate[0] == pytest.approx(np.corrcoef(cell.error[:, i], cell.error[:, j])[0, 1], rel=1e-10)


def test_differences_are_paired(store: Path) -> None:
    rows = rows_of(store, "differences.csv")
    m0 = [r for r in rows if r["measure"] == "mu_z_mm"]
    assert {r["method"] for r in m0} == {"optical, cameras all, with aux"}
    assert {r["against"] for r in m0} == {"none, cameras all, with aux"}
    plan = Plan.of(study())
    columns, _ = joined(Store(store, plan.identity_hash), plan, plan.conditions[0], 96)
    d = columns["optical, cameras all, with aux|mu_z_mm"] - columns["none, cameras all, with aux|mu_z_mm"]
    assert float(m0[0]["estimate"]) == pytest.approx(d.mean(), rel=1e-8)
    assert float(m0[0]["mcse"]) == pytest.approx(d.std(ddof=1) / np.sqrt(96), rel=1e-3)


def test_a_second_run_computes_nothing_and_changes_no_byte(store: Path) -> None:
    before = contents(store)
    times = {p: p.stat().st_mtime_ns for p in store.rglob("*.parquet") if p.parent != store}
    _, said = run_here(store)
    assert said == ["6 of 6 blocks are there and whole"]
    assert contents(store) == before
    assert {p: p.stat().st_mtime_ns for p in times} == times


@pytest.mark.parametrize(("backend", "jobs"), [("joblib", 1), ("joblib", 2)])
def test_jobs_and_backends_change_no_bit(store: Path, tmp_path: Path, backend: str, jobs: int) -> None:
    run_here(tmp_path, backend=backend, jobs=jobs)
    assert contents(tmp_path) == contents(store)


def test_the_parts_of_an_array_job_make_the_whole(store: Path, tmp_path: Path) -> None:
    for number in (3, 1, 2):
        outcome, _ = run_here(tmp_path, part=(number, 3))
        assert outcome.files == ()
    assert not (tmp_path / "summary.csv").exists()
    _, said = run_here(tmp_path)
    assert said == ["6 of 6 blocks are there and whole"]
    assert contents(tmp_path) == contents(store)


def test_more_trials_levels_and_methods_extend_a_study_and_change_nothing_that_is(tmp_path: Path) -> None:
    run_here(tmp_path, study(TEXT, ("max = 96", "max = 50")))
    before = rows_of(tmp_path)
    plan = Plan.of(study(TEXT, ("max = 96", "max = 50")))
    old, _ = joined(Store(tmp_path, plan.identity_hash), plan, plan.conditions[0], 50)
    more = study(
        TEXT, ("max = 96", "max = 80"), ("[3.0, 6.0]", "[9.0, 3.0, 6.0]"), ('"optical"]', '"optical", "torlegard"]')
    )
    run_here(tmp_path, more)
    plan = Plan.of(more)
    condition = next(c for c in plan.conditions if c.columns["noise_um"] == 3.0)
    new, _ = joined(Store(tmp_path, plan.identity_hash), plan, condition, 80)
    for name, values in old.items():
        assert new[name][:50].tobytes() == values.tobytes(), name
    run_here(tmp_path, study(TEXT, ("max = 96", "max = 50"), ("[3.0, 6.0]", "[9.0, 3.0, 6.0]"),
                             ('"optical"]', '"optical", "torlegard"]')))  # fmt: skip
    kept = {(r["condition"], r["method"], r["measure"]): r for r in rows_of(tmp_path)}
    for row in before:
        assert kept[row["condition"], row["method"], row["measure"]] == row


def test_a_fresh_study_with_all_of_it_is_the_same_as_one_extended(tmp_path: Path) -> None:
    run_here(tmp_path / "extended", study(TEXT, ("max = 96", "max = 40"), ("[3.0, 6.0]", "[6.0]")))
    run_here(tmp_path / "extended")
    run_here(tmp_path / "fresh")
    assert contents(tmp_path / "extended") == contents(tmp_path / "fresh")


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("seed = 7", "seed = 8", "seed: the store has 7, the study 8"),
        ('name = "small"', 'name = "other"', 'name: the store has "small", the study "other"'),
        ("block = 32", "block = 64", "block: the store has 32, the study 64"),
        ("spacing_m = 500.0", "spacing_m = 450.0", "scenario.field.spacing_m: the store has 500.0, the study 450.0"),
        ("[3.0, 6.0]", "[3.0, 5.0]", "condition noise_um 6.0 is in the store and no longer in the study"),
        ('["none", "optical"]', '["optical"]', "method 'none, cameras all, with aux' is in the store"),
    ],
)
def test_another_study_is_refused_with_the_difference(store: Path, old: str, new: str, line: str) -> None:
    before = contents(store)
    with pytest.raises(StoreError, match=line.replace("[", r"\[")):
        run_here(store, study(TEXT, (old, new)))
    assert contents(store) == before


def test_without_its_manifest_a_store_of_another_study_is_still_refused(store: Path, tmp_path: Path) -> None:
    import shutil

    shutil.copytree(store, tmp_path / "copy")
    (tmp_path / "copy" / "manifest.json").unlink()
    with pytest.raises(StoreError, match="belongs to another study"):
        run_here(tmp_path / "copy", study(TEXT, ('name = "small"', 'name = "other"')))


def test_verify_finds_a_sound_store_sound(store: Path) -> None:
    said: list[str] = []
    assert verify(store, said.append) == []
    assert said[0] == "every shard is whole"
    assert len(said) == 3


def test_replay_gives_the_numbers_of_the_store(store: Path) -> None:
    plan = Plan.of(study())
    condition = condition_named(plan, "2")
    text = "\n".join(replay(plan, condition, 37))
    columns, _ = joined(Store(store, plan.identity_hash), plan, condition, 96)
    assert f"m0_um {columns['optical, cameras all, with aux|m0_um'][37]:.4g}" in text
    assert f"ww.a3 {columns['optical, cameras all, with aux|ww.a3'][37]:.8g}" in text
    assert condition_named(plan, condition.id[:6]) == condition
    with pytest.raises(StudyError, match="no condition 'zz'"):
        condition_named(plan, "zz")


def test_0_and_1_trials_and_a_condition_that_cannot_be_adjusted(tmp_path: Path) -> None:
    outcome, _ = run_here(tmp_path / "none", study(TEXT, ("max = 96", "max = 0")))
    rows = rows_of(tmp_path / "none")
    assert {r["n"] for r in rows} == {"0"}
    assert {r["estimate"] for r in rows} == {""}
    assert "nan" not in (tmp_path / "none" / "report.md").read_text(encoding="utf-8")
    assert outcome.failures == ()
    run_here(tmp_path / "one", study(TEXT, ("max = 96", "max = 1")))
    found = {r["measure"]: r for r in rows_of(tmp_path / "one") if r["noise_um"] == "3"}
    assert found["m0_um"]["estimate"] != ""
    assert found["m0_um"]["mcse"] == ""
    lost = study(TEXT, ('control = { rest = "check" }', 'control = { layout = "none", rest = "check" }'))
    outcome, _ = run_here(tmp_path / "lost", lost)
    assert len(outcome.failures) == 4
    assert "96 of 96 trials failed" in outcome.failures[0]
    rows = rows_of(tmp_path / "lost")
    assert {(r["n"], r["failures"]) for r in rows} == {("0", "96")}
    assert next(r for r in rows if r["measure"] == "failure_share")["estimate"] == "1"
    assert float(next(r for r in rows if r["measure"] == "failure_share")["mcse"]) > 0.0
    reasons = json.loads(next((tmp_path / "lost" / "failures").rglob("nominal.json")).read_text(encoding="utf-8"))
    assert "singular" in str(reasons)


def early(target: str) -> Study:
    return study(TEXT, ("max = 96", "max = 1000"), ("block = 32", f"block = 128\ntarget_mcse = {{ {target} }}"))


def test_a_target_stops_a_condition_never_below_500_and_the_same_for_any_jobs(tmp_path: Path) -> None:
    asked = early("m0_um = 10.0")
    run_here(tmp_path / "a", asked)
    assert {r["n"] for r in rows_of(tmp_path / "a")} == {"512"}
    run_here(tmp_path / "b", early("m0_um = 0.0085"))
    found = {r["noise_um"]: r for r in rows_of(tmp_path / "b") if r["measure"] == "m0_um" and r["ap"] == "none"}
    assert float(found["3"]["mcse"]) <= 0.0085
    assert int(found["3"]["n"]) < int(found["6"]["n"]) <= 1000
    run_here(tmp_path / "c", early("m0_um = 0.0085"), jobs=4)
    assert (tmp_path / "b" / "summary.csv").read_bytes() == (tmp_path / "c" / "summary.csv").read_bytes()


def test_further_blocks_that_exist_do_not_move_the_stop(tmp_path: Path) -> None:
    run_here(tmp_path, study(TEXT, ("max = 96", "max = 1000"), ("block = 32", "block = 128")))
    run_here(tmp_path, early("m0_um = 10.0"))
    assert {r["n"] for r in rows_of(tmp_path)} == {"512"}


def test_stopping_waits_for_all_methods_and_patterns(tmp_path: Path) -> None:
    asked = early('"coverage*" = 1e-9')
    plan = Plan.of(asked)
    run_here(tmp_path, asked)
    assert stopping.trials_of(plan, Store(tmp_path, plan.identity_hash), plan.conditions[0]) == 1000


def test_no_cell_is_taken_for_a_formula_and_no_name_for_markup(tmp_path: Path) -> None:
    label = '=HYPERLINK("x")<script>$\\\\frac$'
    evil = study(TEXT, ("[3.0, 6.0]", f"[{{ label = '{label}', value = 3.0 }}]"))
    run_here(tmp_path, evil)
    assert {r["noise_um"] for r in rows_of(tmp_path)} == {"'" + label}
    report = (tmp_path / "report.md").read_text(encoding="utf-8")
    assert "<script>" not in report
    assert summary.to_csv([{"a": "-1+1", "b": float("nan")}]) == b"a,b\n'-1+1,\n"
