"""Stores of versions that kept other columns: they go on without what not all trials have, or are refused."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from studies.design.plan import Plan
from studies.pages.html_report import report
from studies.run.one_trial import replay
from studies.run.verification import verify
from studies.store.column_sets import CONSTANTS, DEVIATIONS, TRIAL, VERSION, described
from studies.store.look import joined
from studies.store.shards import BEFORE, Columns
from studies.store.status_codes import ABSENT
from studies.store.store import NOMINAL, Store, StoreError
from studies.summary.cells import Cell, measured
from studies.summary.stopping import trials_of
from studies.texts.markdown_text import escaped
from studies.trials.geometry import geometry_of
from tests.studies.small_study import TEXT, contents, run_here, study

IDENTITY = "8a6e112c1a1205eb798acb8638f87502fb0c94b3eb777d5a58dad306145ae55d"
"""of the small study, as it was before the manifest said columns"""
EVERY, SOME = (0, 1, 2), (1,)
"""blocks that another version wrote"""


def of_before(folder: Path) -> None:
    """Make the manifest that of a version which did not say columns."""
    rewritten(folder, lambda manifest: manifest.pop("columns"))


def rewritten(folder: Path, change: Callable[[dict], object]) -> None:
    path = folder / "manifest.json"
    manifest = json.loads(path.read_bytes())
    change(manifest)
    path.write_text(json.dumps(manifest), encoding="utf-8")


def change_blocks(folder: Path, blocks: tuple[int | str, ...], change: Callable[[Columns], Columns]) -> None:
    plan = Plan.of(study())
    own = Store(folder, plan.identity_hash)
    for condition in plan.conditions:
        for block in blocks:
            own.write_shard(condition.id, block, change(own.read_shard(condition.id, block, 1 << 16)))


def without(name: str) -> Callable[[Columns], Columns]:
    """A change that takes a quantity of every method away."""
    return lambda columns: {key: v for key, v in columns.items() if key.split(BEFORE)[1] != name}


def lines(folder: Path) -> list[str]:
    """The rows of a summary."""
    return (folder / "summary.csv").read_text(encoding="utf-8").splitlines()


def about(name: str) -> Callable[[str], bool]:
    return lambda line: f",{name}," in line


def test_the_identity_of_a_study_is_as_before() -> None:
    assert Plan.of(study()).identity_hash == IDENTITY


def test_the_manifest_says_the_columns_that_the_shards_have(store: Path) -> None:
    plan = Plan.of(study())
    said = json.loads((store / "manifest.json").read_bytes())["columns"]
    own = Store(store, plan.identity_hash)
    kept, nominal = (own.read_shard(plan.conditions[0].id, block, 1 << 16) for block in (0, NOMINAL))
    of_trials = {m.key: [*said["trials"], *said["unknowns"][m.key]] for m in plan.methods}
    expected = {f"{key}{BEFORE}{c['name']}": c for key, columns in of_trials.items() for c in columns}
    assert said["version"] == VERSION
    assert {name: values.dtype.name for name, values in kept.items()} == {k: c["dtype"] for k, c in expected.items()}
    unknowns = [f"{m.key}{BEFORE}{c['name']}" for m in plan.methods for c in said["unknowns"][m.key]]
    assert set(nominal) == {*unknowns, *(f"{m.key}{BEFORE}constants" for m in plan.methods)}
    units = {c["name"]: c["unit"] for c in (*of_trials[plan.methods[1].key], *said["constants"])}
    wanted = {"m0_um": "um", "mu_z_mm": "mm", "coverage_z": "1", "unit_weight_um": "um"}
    wanted |= {"ww.Z0": "m", "ww.phi": "rad", "edge.X": "m", "ww.a3": "mm-powers"}
    assert {name: units[name] for name in wanted} == wanted


def test_unknowns_are_said_for_the_cameras_and_the_set_of_each_method() -> None:
    i, j = TEXT.index("[scenario]"), TEXT.index("[grid]")
    text = TEXT[:i] + '[scenario]\npreset = "rheidt-1980"\n\n' + TEXT[j:]
    asked = study(text, ("[methods]", '[methods]\ncameras = ["all", "sww"]\naux_points = [true, false]'))
    plan = Plan.of(asked)
    geometry = geometry_of(plan.conditions[0])
    said = described(plan)["unknowns"]
    for method in plan.methods:
        assert tuple(c["name"] for c in said[method.key]) == geometry.prepared(method).tracked.names


def test_a_camera_that_is_not_flown_has_no_unknowns() -> None:
    cameras = 'cameras = [{ camera_id = "spare", c_mm = 85.0 }, { camera_id = "ww", c_mm = 153.0 }]\n'
    plan = Plan.of(study(TEXT, ('preset = "grid-small"\n', f'preset = "grid-small"\n{cameras}')))
    tracked = geometry_of(plan.conditions[0]).prepared(plan.methods[1]).tracked
    assert tuple(c["name"] for c in described(plan)["unknowns"][plan.methods[1].key]) == tracked.names


def test_a_store_of_before_goes_on_and_comes_to_the_same(copy: Path, tmp_path: Path) -> None:
    of_before(copy)
    assert verify(copy, lambda line: None) == []
    _, said = run_here(copy, study().with_changes(trials=160))
    assert said == ["6 of 10 blocks are there and whole"]
    run_here(tmp_path / "new", study().with_changes(trials=160))
    assert contents(copy) == contents(tmp_path / "new")
    assert verify(copy, lambda line: None) == []
    assert json.loads((copy / "manifest.json").read_bytes())["columns"]["version"] == VERSION


@pytest.mark.parametrize(
    ("name", "blocks"),
    [
        *((name, EVERY) for name in (*DEVIATIONS[1:], "edge.Z")),
        *((name, SOME) for name in ("mu_z_mm", "coverage_xy", "edge.Z")),
    ],
)
def test_a_measure_that_blocks_lack_is_left_out_and_said(
    store: Path, copy: Path, name: str, blocks: tuple[int, ...]
) -> None:
    of_before(copy)
    change_blocks(copy, blocks, without(name))
    outcome, said = run_here(copy)
    assert outcome.failures == ()
    assert sum(f"{name} (in 4 of 4 cells)" in line for line in said) == 1
    assert not any("computed again" in line for line in said)
    whole = [line for line in lines(store) if not line.split(",")[-6].endswith(name)]
    assert lines(copy) == whole
    note = f"Left out: {name} (in 4 of 4 cells)"
    assert escaped(note) in (copy / "report.md").read_text(encoding="utf-8")
    assert f"{name} (in 4 of 4 cells)" in report(copy)
    heard: list[str] = []
    assert verify(copy, heard.append) == []
    assert any("not compared" in line and name in line for line in heard) == (0 in blocks)


def test_a_followed_unknown_of_another_nominal_adjustment_is_left_out(store: Path, copy: Path) -> None:
    change_blocks(copy, (NOMINAL,), without("edge.Z"))
    _, said = run_here(copy)
    assert any("edge.Z (in 4 of 4 cells)" in line for line in said)
    assert lines(copy) == [line for line in lines(store) if not line.split(",")[-6].endswith("edge.Z")]


def test_formal_correlations_stay_with_their_unknowns(store: Path) -> None:
    plan = Plan.of(study())
    trials, nominal = joined(Store(store, plan.identity_hash), plan, plan.conditions[0], 96)
    key = plan.methods[1].key
    whole, part = (Cell.of(key, columns, nominal) for columns in (trials, without("ww.a4")(trials)))
    kept = [number for number, name in enumerate(whole.names) if name != "ww.a4"]
    assert part.names == tuple(whole.names[number] for number in kept)
    assert np.array_equal(part.formal, whole.formal[np.ix_(kept, kept)])


@pytest.mark.parametrize("blocks", [EVERY, SOME], ids=["every", "some"])
def test_without_m0_there_is_nothing_that_a_method_claims(store: Path, copy: Path, blocks: tuple[int, ...]) -> None:
    change_blocks(copy, blocks, without("m0_um"))
    run_here(copy)
    gone = ("m0_um", "aic", "bic", "parameters", "significant", "condition_number", "largest_ap_exterior")
    claimed = ("model_se ", "model_se_error ", "coverage ")
    measures = [line.split(",")[-6] for line in lines(store)]
    left = [m not in gone and not m.startswith(claimed) for m in measures]
    assert lines(copy) == list(itertools.compress(lines(store), left))
    assert verify(copy, lambda line: None) == []
    report(copy)


def test_new_blocks_have_the_measure_and_a_condition_of_new_blocks_alone_shows_it(copy: Path) -> None:
    change_blocks(copy, EVERY, without("true_z_mm"))
    _, said = run_here(copy, study(TEXT, ("[3.0, 6.0]", "[3.0, 6.0, 9.0]")).with_changes(trials=160))
    assert any("true_z_mm (in 4 of 6 cells)" in line for line in said)
    shown = [line.split(",")[1] for line in lines(copy) if about("true_z_mm")(line)]
    assert shown == ["9", "9"]
    assert verify(copy, lambda line: None) == []


def test_shorter_constants_leave_out_what_hangs_on_them(store: Path, copy: Path) -> None:
    plan = Plan.of(study())
    own = Store(copy, plan.identity_hash)
    trials, nominal = joined(own, plan, plan.conditions[0], 96)
    key = plan.methods[1].key
    whole = measured(Cell.of(key, trials, nominal))
    nominal[key + BEFORE + "constants"] = nominal[key + BEFORE + "constants"][:3]
    cell = Cell.of(key, trials, nominal)
    assert cell.left_out == CONSTANTS[3:]
    choice = {"aic", "bic", "parameters", "significant", "condition_number", "largest_ap_exterior"}
    assert set(whole) - set(measured(cell)) == choice
    nominal[key + BEFORE + "constants"] = np.zeros(0)
    assert not {"coverage edge.Z", "model_se edge.Z", "aic"} & set(measured(Cell.of(key, trials, nominal)))


def test_a_column_that_this_version_does_not_know_is_said(store: Path, copy: Path) -> None:
    change_blocks(
        copy, EVERY, lambda c: c | {k.replace("mu_z_mm", "mu_q_mm"): v for k, v in c.items() if "mu_z_mm" in k}
    )
    _, said = run_here(copy)
    assert any("mu_q_mm (in 4 of 4 cells)" in line for line in said)
    assert lines(copy) == lines(store)
    assert verify(copy, lambda line: None) == []


@pytest.mark.parametrize("lacking", [False, True])
def test_a_condition_does_not_stop_for_a_measure_that_is_not_known(tmp_path: Path, lacking: bool) -> None:
    asked = study(TEXT, ("max = 96", "max = 576\ntarget_mcse = { true_z_mm = 1e6 }"))
    plan = Plan.of(asked)
    run_here(tmp_path, asked)
    own = Store(tmp_path, plan.identity_hash)
    if lacking:
        condition = plan.conditions[0]
        own.write_shard(condition.id, 3, without("true_z_mm")(own.read_shard(condition.id, 3, 32)))
    assert trials_of(plan, own, plan.conditions[0]) == (576 if lacking else 512)
    assert trials_of(plan, own, plan.conditions[1]) == 512


def test_a_block_without_a_method_counts_as_failed_and_says_so(copy: Path) -> None:
    plan = Plan.of(study())
    key = plan.methods[1].key
    change_blocks(copy, SOME, lambda c: {k: v for k, v in c.items() if not k.startswith(key)})
    trials, nominal = joined(Store(copy, plan.identity_hash), plan, plan.conditions[0], 96)
    cell = Cell.of(key, trials, nominal)
    assert cell.status.dtype == np.int8
    assert cell.failures == np.sum(cell.status == ABSENT) == 32
    assert cell.lost
    assert cell.left_out == ()


def test_a_trial_is_replayed_whatever_columns_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = Plan.of(study())
    monkeypatch.setattr("studies.run.one_trial.DEVIATIONS", (*DEVIATIONS, "new_mm"))
    assert any("mu_z_mm" in line for line in replay(plan, plan.conditions[0], 1))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (
            lambda m: m["columns"].update(version=VERSION + 1),
            f"the store has version {VERSION + 1}, this simfield knows",
        ),
        (lambda m: m["columns"]["trials"][1].update(unit="mm"), "unit of m0_um is 'mm' in the store, 'um' here"),
        (lambda m: m["columns"]["trials"][0].update(dtype="int64"), "dtype of status is 'int64' in the store, 'int8'"),
        (lambda m: m["columns"]["constants"][0].update(kind="unknown"), "kind of redundancy is 'unknown' in the store"),
        (lambda m: m["columns"].pop("trials"), "columns.trials: damaged: no list of columns"),
        (lambda m: m["columns"].update(version="1"), "columns: damaged: the manifest names no version of them"),
        (lambda m: m.update(columns=[]), "columns: damaged: the manifest names no version of them"),
    ],
)
def test_columns_that_mean_something_else_are_refused_in_a_line(
    copy: Path, change: Callable[[dict], object], says: str
) -> None:
    rewritten(copy, change)
    for refused in (lambda: run_here(copy), lambda: verify(copy, lambda line: None), lambda: report(copy)):
        with pytest.raises(StoreError) as error:
            refused()
        assert says in str(error.value)
        assert len(str(error.value).splitlines()) == 1


def test_a_manifest_that_knows_fewer_columns_is_no_fault(copy: Path) -> None:
    rewritten(copy, lambda m: m["columns"].update(trials=m["columns"]["trials"][: len(TRIAL) - 1]))
    assert verify(copy, lambda line: None) == []
