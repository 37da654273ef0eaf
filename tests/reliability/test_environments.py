"""The same study under other circumstances: processes, block sizes, BLAS threads, locale, terminal, missing parts."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from studies.design.plan import Plan
from studies.design.study import Study
from studies.run.worker import BackendError
from studies.store.look import joined
from studies.store.store import Store
from studies.trials import geometry
from tests.studies.small_study import TEXT, contents, run_here, study

TOP = Path(__file__).parents[2]
RUN = "from studies.commands.program import main; main()"
ESCAPE = "\x1b"
NARROWEST = 50
"""click breaks its pages at no fewer columns; a narrower terminal wraps them"""
Trials = dict[str, npt.NDArray[np.generic]]


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder: Path = tmp_path_factory.mktemp("undisturbed")
    run_here(folder)
    return folder


def trials_of(folder: Path, asked: Study) -> list[Trials]:
    plan = Plan.of(asked)
    store = Store(folder, plan.identity_hash)
    return [joined(store, plan, condition, plan.trials)[0] for condition in plan.conditions]


def command(study_file: Path, out: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """`simfield run` as a shell starts it, without a terminal."""
    return subprocess.run(
        [sys.executable, "-c", RUN, "run", str(study_file), "--out", str(out), "--jobs", "1"],
        cwd=TOP, env={**os.environ, **environment}, stdin=subprocess.DEVNULL, capture_output=True, encoding="utf-8",
        timeout=300, check=False,
    )  # fmt: skip


def test_a_worker_that_is_told_to_give_memory_back_keeps_it() -> None:
    """dask tells its workers so; faults are counted while the same memory is taken and left again and again."""
    code = """if True:
        import resource, sys
        import numpy as np
        from studies.run.worker import prepare
        if sys.argv[1] == "prepared":
            prepare()
        faults = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_minflt
        np.ones(1 << 20)
        before = faults()
        for _ in range(20):
            np.ones(1 << 20)
        print(faults() - before)
    """
    told = {**os.environ, "MALLOC_TRIM_THRESHOLD_": "65536"}
    as_told, prepared = (
        int(subprocess.check_output([sys.executable, "-c", code, how], cwd=TOP, env=told, encoding="utf-8"))
        for how in ("as told", "prepared")
    )
    if as_told < 20:
        pytest.skip("this system's C library does not give memory back when it is told")
    assert prepared < as_told / 10


def test_four_jobs_for_six_blocks(tmp_path: Path, undisturbed: Path) -> None:
    run_here(tmp_path, backend="joblib", jobs=4)
    assert contents(tmp_path) == contents(undisturbed)


@pytest.mark.parametrize("size", [64, 96])
def test_the_size_of_blocks_changes_no_bit_of_a_trial(tmp_path: Path, undisturbed: Path, size: int) -> None:
    asked = study(TEXT, ("block = 32", f"block = {size}"))
    run_here(tmp_path, asked)
    assert (tmp_path / "summary.csv").read_bytes() == (undisturbed / "summary.csv").read_bytes()
    for found, wanted in zip(trials_of(tmp_path, asked), trials_of(undisturbed, study()), strict=True):
        assert list(found) == list(wanted)
        for name, values in found.items():
            assert values.tobytes() == wanted[name].tobytes(), name


@pytest.mark.parametrize("threads", [1, 2])
def test_blas_threads_change_no_bit(tmp_path: Path, undisturbed: Path, threads: int) -> None:
    """BLAS is allowed so many threads from outside; a block takes one."""
    from threadpoolctl import threadpool_limits

    geometry.forget()
    with threadpool_limits(threads):
        run_here(tmp_path)
    assert contents(tmp_path) == contents(undisturbed)


CIRCUMSTANCES = {
    "C, nothing allowed to others, no colour, 40 columns": (
        {"LC_ALL": "C", "TZ": "Asia/Kathmandu", "NO_COLOR": "1", "COLUMNS": "40"}, 0o077,
    ),
    "German, everything allowed, dumb terminal, ASCII streams": (
        {"LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8", "TZ": "Pacific/Kiritimati", "TERM": "dumb",
         "PYTHONIOENCODING": "ascii:strict"}, 0o000,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CIRCUMSTANCES)
def test_locale_time_zone_umlauts_umask_and_terminal(tmp_path: Path, undisturbed: Path, name: str) -> None:
    environment, umask = CIRCUMSTANCES[name]
    folder = tmp_path / "Größe in µm"
    folder.mkdir()
    (folder / "übung.toml").write_text(TEXT, encoding="utf-8")
    before = os.umask(umask)
    try:
        done = command(folder / "übung.toml", folder / "läuft", **environment)
    finally:
        os.umask(before)
    assert done.returncode == 0, done.stderr
    assert contents(folder / "läuft") == contents(undisturbed)
    assert "Traceback" not in done.stderr
    assert ESCAPE not in done.stdout + done.stderr
    assert done.stdout.splitlines()[0].endswith("summary.csv")
    wanted = 0o666 & ~umask
    assert {p.stat().st_mode & 0o777 for p in (folder / "läuft").rglob("*") if p.is_file()} == {wanted}


@pytest.mark.parametrize("arguments", [("--help",), ("run", "--help"), ("studies",), ("run", "control", "--dry-run")])
def test_pages_are_readable_in_40_columns_without_colour(arguments: tuple[str, ...]) -> None:
    done = subprocess.run(
        [sys.executable, "-c", RUN, *arguments], cwd=TOP, stdin=subprocess.DEVNULL, capture_output=True, text=True,
        env={**os.environ, "COLUMNS": "40", "NO_COLOR": "1", "TERM": "dumb"}, timeout=60, check=True,
    )  # fmt: skip
    assert ESCAPE not in done.stdout
    if arguments[-1] == "--help":
        assert max(map(len, done.stdout.splitlines())) <= NARROWEST
    assert "Error" not in done.stderr


def test_a_missing_extra_gives_the_line_that_installs_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)  # what an import finds that must fail
    with pytest.raises(BackendError, match=r"pip install 'simfield\[cluster\]'"):
        run_here(tmp_path, backend="dask", scheduler="tcp://127.0.0.1:1")
