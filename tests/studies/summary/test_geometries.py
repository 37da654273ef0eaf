"""Two levels of error: several geometries of each condition, and what their scatter says."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from studies.design.plan import Plan
from studies.design.study import Study, StudyError
from studies.pages import study_report
from studies.run import verify
from studies.store.store import Store
from studies.store.stored_study import study_of
from studies.summary import summarise, summary_file
from studies.summary.over_geometries import error_of, over_geometries, with_correlated
from tests.studies import small_study

GEOMETRIES = 4


def study(geometries: int = GEOMETRIES, *more: tuple[str, str]) -> Study:
    return small_study.study(
        small_study.TEXT,
        ("max = 96", f"geometries = {geometries}\nmax = 96"),
        ("[report]", '[paired]\nagainst = { ap = "none" }\n\n[report]'),
        *more,
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("geometries") / "store"
    outcome, _ = small_study.run_here(folder, study())
    assert not outcome.failures
    return folder


def table(path: Path) -> list[dict[str, Any]]:
    with path.open(encoding="utf-8", newline="") as file:
        return [{k: float(v) if k in ("estimate", "mcse", "geometry_se") and v else v for k, v in row.items()}
                for row in csv.DictReader(file)]  # fmt: skip


def test_one_geometry_has_the_ids_and_the_bytes_that_it_had() -> None:
    plan, more = Plan.of(study(1)), Plan.of(study())
    assert [c.id for c in plan.conditions] == [c.id for c in Plan.of(small_study.study()).conditions]
    assert [c.id for c in more.firsts] == [c.id for c in plan.conditions]
    assert plan.identity_hash == more.identity_hash
    assert all(c.geometry is None and str(c) == c.said for c in plan.conditions)


def test_geometries_are_worlds_of_their_own() -> None:
    plan = Plan.of(study())
    assert len(plan.conditions) == 2 * GEOMETRIES
    assert len({c.seed for c in plan.conditions}) == len({c.id for c in plan.conditions}) == 2 * GEOMETRIES
    for first, *others in plan.situations:
        assert [c.geometry for c in (first, *others)] == [1, 2, 3, 4]
        assert {c.situation for c in others} == {first.id}
        assert str(others[0]) == f"{first.said}, geometry 2"


def test_rows_are_those_of_each_geometry_put_together(folder: Path) -> None:
    """Against the summaries of studies of one geometry each, made by hand from the same store."""
    plan = study_of(folder)
    store = Store(folder, plan.identity_hash)
    together = {(r["condition"], r["method"], r["measure"]): r for r in summarise(plan, store).rows}
    for situation in plan.situations:
        alone = []
        for condition in situation:
            one = Plan(study(1), (condition,), plan.methods, plan.base)
            alone.append({(r["method"], r["measure"]): r for r in summarise(one, store).rows})
        for key in (("optical", "m0_um"), ("none", "mu_z_mm"), ("optical", "coverage_z"), ("optical", "emp_se ww.a3")):
            method = next(m for m, _ in alone[0] if m.startswith(key[0]))
            each = [rows[method, key[1]] for rows in alone]
            row = together[situation[0].id, method, key[1]]
            values = np.array([e["estimate"] for e in each])
            assert row["estimate"] == pytest.approx(values.mean())
            assert row["geometry_se"] == pytest.approx(values.std(ddof=1) / 2.0)
            assert row["mcse"] == pytest.approx(np.sqrt(np.sum([e["mcse"] ** 2 for e in each])) / GEOMETRIES)
            assert (row["geometries"], row["n"], row["failures"]) == (GEOMETRIES, 96 * GEOMETRIES, 0)


def test_tables_differences_report_and_verification(folder: Path) -> None:
    rows, differences = table(folder / "summary.csv"), table(folder / "differences.csv")
    for each in (rows, differences):
        assert list(each[0])[-6:] == ["n", "failures", "estimate", "mcse", "geometries", "geometry_se"]
    m0 = [r for r in rows if r["measure"] == "mu_z_mm"]
    assert len(m0) == 4
    plan = study_of(folder)
    read = summary_file.read_summary(plan, folder)
    assert len(read.rows) == len(rows)
    report = (folder / "report.md").read_text(encoding="utf-8")
    assert "in 4 geometries together" in report
    assert "over geometries and trials" in report
    row = next(r for r in read.rows if r["measure"] == "mu_z_mm")
    assert error_of(row) == row["geometry_se"]
    assert study_report.with_error(row) in report
    assert verify(folder, lambda line: None) == []


def test_a_store_goes_on_with_more_geometries(folder: Path, tmp_path: Path) -> None:
    small_study.run_here(tmp_path / "store", study(2))
    small_study.run_here(tmp_path / "store", study())
    for name in ("summary.csv", "differences.csv"):
        assert (tmp_path / "store" / name).read_bytes() == (folder / name).read_bytes()


def test_a_geometry_without_a_result_is_no_part_of_the_mean() -> None:
    def row(measure: str, estimate: float, mcse: float) -> dict[str, Any]:
        return {"condition": "x", "method": "m", "measure": measure, "unit": "1", "n": 5, "failures": 1,
                "estimate": estimate, "mcse": mcse}  # fmt: skip

    rows = [
        [row("failure_share", 1.0, 0.1)],
        [row("a", 2.0, 0.3), row("failure_share", 0.0, 0.1)],
        [row("a", 4.0, 0.4), row("failure_share", 0.0, 0.1)],
        [row("a", float("nan"), float("nan")), row("failure_share", 0.0, 0.1)],
    ]
    found = over_geometries(rows, {"condition": "first"})
    assert [r["measure"] for r in found] == ["a", "failure_share"]
    assert found[0]["estimate"] == 3.0
    assert found[0]["geometries"] == 2
    assert found[0]["mcse"] == pytest.approx(0.25)
    assert found[0]["geometry_se"] == pytest.approx(1.0)
    assert found[1]["n"] == 20
    pairs = [row("formal_correlation p~q", 0.2, 0.0), row("correlation p~q", 0.4, 0.1), row("a", 0.0, 0.1)]
    assert [r["measure"] for r in with_correlated(pairs, 0.3)] == ["a"]
    assert len(list(with_correlated(pairs, 0.1))) == 3


def test_wrong_numbers_are_refused() -> None:
    for wrong in (0, -1, 1001):
        with pytest.raises(StudyError, match=f"trials.geometries: found {wrong}, allowed: 1 to 1000"):
            study(wrong)


@pytest.mark.slow
def test_other_seeds_confirm_the_error_over_geometries(tmp_path: Path) -> None:
    """Eight studies of other seeds scatter as each says of itself; by the error over trials alone they scatter more."""
    estimates, claimed, of_trials = [], [], []
    for seed in range(8):
        folder = tmp_path / str(seed)
        small_study.run_here(folder, study(8, ("seed = 7", f"seed = {100 + seed}"), ("max = 96", "max = 960")))
        rows = [r for r in table(folder / "summary.csv") if r["measure"] == "mu_z_mm"]
        estimates.append([r["estimate"] for r in rows])
        claimed.append([r["geometry_se"] for r in rows])
        of_trials.append([r["mcse"] for r in rows])
    # the conditions share nothing, four of them in two pairs of methods: some 14 degrees of freedom
    scatter = np.var(estimates, axis=0, ddof=1).mean()
    assert 0.4 < scatter / np.mean(np.square(claimed)) < 2.0
    assert scatter > 3.0 * np.mean(np.square(of_trials))
