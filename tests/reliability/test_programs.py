"""A store begun by one version is not gone on with by another: refused, or both are named."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from studies.run import verify
from studies.run.story import How, run
from studies.run.work import run_task
from studies.run.worker import BackendError
from studies.session import program
from studies.store import StoreError
from studies.store.store import Store
from studies.trials import image_points
from tests.studies.small_study import contents, run_here, study


def manifest(folder: Path) -> dict:
    return json.loads((folder / "manifest.json").read_bytes())


def begun_by_another(folder: Path, change: Callable[[dict], object]) -> None:
    """Make its trials those of another program, and lose one block of them."""
    found = manifest(folder)
    change(found)
    (folder / "manifest.json").write_text(json.dumps(found), encoding="utf-8")
    lose_a_block(folder)


def lose_a_block(folder: Path) -> None:
    sorted((folder / "trials").glob("*/[0-9]*.parquet"))[-1].unlink()


def program_with(**other: str) -> Callable[[dict], object]:
    return lambda found: found.update(programs=[{**program(), **other}])


OTHERS = {
    "another numpy": program_with(numpy="1.26.4"),
    "another numba": program_with(numba="0.59.0"),
    "another scipy": program_with(scipy="1.11.0"),
    "another release": program_with(simfield="0.0.9"),
    "another checkout of this release": program_with(code="0123456789abcdef"),
    "one of before programs were told apart": lambda found: found.pop("programs"),
}


def test_the_manifest_names_the_program_that_computed(store: Path) -> None:
    assert manifest(store)["programs"] == [program()]


def test_the_same_program_goes_on(copy: Path, store: Path) -> None:
    lose_a_block(copy)
    run_here(copy)
    assert contents(copy) == contents(store)
    assert manifest(copy)["programs"] == [program()]


@pytest.mark.parametrize("change", OTHERS.values(), ids=OTHERS)
def test_another_program_is_refused_and_leaves_all_as_it_was(copy: Path, change: Callable[[dict], object]) -> None:
    begun_by_another(copy, change)
    before, trials = manifest(copy)["conditions"], sorted((copy / "trials").rglob("*"))
    with pytest.raises(StoreError, match=r"its trials were computed by .* and not .*--other-program"):
        run_here(copy)
    assert manifest(copy)["conditions"] == before
    assert program() not in manifest(copy).get("programs", [])
    assert sorted((copy / "trials").rglob("*")) == trials


def test_with_leave_it_goes_on_and_both_are_named(copy: Path) -> None:
    begun_by_another(copy, OTHERS["another numpy"])
    said: list[str] = []
    run(study(), copy, How(backend="here", other_program=True), said.append)
    assert any("numpy 1.26.4 and not" in line for line in said)
    assert [each["numpy"] for each in manifest(copy)["programs"]] == ["1.26.4", program()["numpy"]]
    said.clear()
    verify(copy, said.append)
    assert any("trials of 2 programs are averaged here" in line and "1.26.4" in line for line in said)
    run_here(copy)  # whole, so that nothing is computed and nothing asked


def test_a_whole_store_is_summarised_by_any_program(copy: Path) -> None:
    found = manifest(copy)
    OTHERS["another numpy"](found)
    (copy / "manifest.json").write_text(json.dumps(found), encoding="utf-8")
    run_here(copy)
    assert [each["numpy"] for each in manifest(copy)["programs"]] == ["1.26.4"]
    said: list[str] = []
    assert not verify(copy, said.append)
    assert any("numpy 1.26.4 and not" in line for line in said)


def test_a_store_that_came_without_its_trials_is_begun_anew(copy: Path) -> None:
    """As the results of this repository: what another program computed is not there, so nothing can be mixed."""
    begun_by_another(copy, OTHERS["another numpy"])
    shutil.rmtree(copy / "trials")
    run_here(copy)
    assert manifest(copy)["programs"] == [program()]


def test_a_worker_with_another_program_writes_nothing(tmp_path: Path) -> None:
    from studies.design.plan import Plan

    plan = Plan.of(study())
    task = plan.task(plan.conditions[0], 0, {})
    with pytest.raises(BackendError, match="a worker has numba"):
        run_task(Store(tmp_path, plan.identity_hash), image_points, {**program(), "numba": "0.1"}, task)
    assert not list(tmp_path.iterdir())
