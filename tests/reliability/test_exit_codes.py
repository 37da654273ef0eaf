"""What a shell sees of a study: exit codes, and a line for each kind of failure instead of a traceback."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from studies.commands.program import main
from studies.run.work import Done
from studies.run.worker import BackendError
from studies.session.progress import progress_bar
from studies.store.store import locked
from tests.studies.small_study import TEXT, run_here


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the study file and its store."""
    folder: Path = tmp_path_factory.mktemp("ran")
    (folder / "small.toml").write_text(TEXT, encoding="utf-8")
    run_here(folder / "store")
    return folder


def call(*arguments: object) -> Result:
    done = CliRunner().invoke(main, [str(a) for a in arguments])
    assert "Traceback" not in done.output
    return done


def test_a_sound_store_is_0_and_a_damaged_one_3(ran: Path) -> None:
    assert call("verify", ran / "store").exit_code == 0
    path = next((ran / "store" / "trials").rglob("2.parquet"))
    whole = path.read_bytes()
    path.write_bytes(whole[:-1])
    done = call("verify", ran / "store")
    path.write_bytes(whole)
    assert done.exit_code == 3
    assert f"{path.parent.name}/2.parquet is damaged" in done.output


def test_the_store_of_another_study_is_3(ran: Path) -> None:
    done = call("run", ran / "small.toml", "--seed", 8, "--out", ran / "store")
    assert done.exit_code == 3
    assert "seed: the store has 7, the study 8" in done.output


def test_a_held_store_is_75(ran: Path) -> None:
    with locked(ran / "store"):
        done = call("run", ran / "small.toml", "--out", ran / "store")
    assert done.exit_code == 75
    assert "in use by another run" in done.output


def test_failed_cells_are_1_and_their_reason_is_said(tmp_path: Path) -> None:
    without = TEXT.replace('control = { rest = "check" }', 'control = { layout = "none", rest = "check" }')
    (tmp_path / "small.toml").write_text(without, encoding="utf-8")
    done = call("run", tmp_path / "small.toml", "--out", tmp_path / "store", "--jobs", 1)
    assert done.exit_code == 1
    assert "96 of 96 trials failed" in done.output
    assert (tmp_path / "store" / "summary.csv").exists()


@pytest.mark.filterwarnings("ignore")
def test_no_scheduler_is_1(ran: Path, tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{probe.getsockname()[1]}"
    done = call("run", ran / "small.toml", "--out", tmp_path, "--backend", "dask", "--scheduler", address)
    assert done.exit_code == 1
    assert f"no dask scheduler at {address}" in done.output


@pytest.mark.parametrize(
    "arguments",
    [
        ("run", "no-such-study"),
        ("run", "control", "--shard", "0/4"),
        ("run", "control", "--backend", "dask"),
        ("run", "control", "--trials", "-1"),
        ("replay", "control", "zz", "0"),
    ],
)
def test_a_wrong_call_is_2(arguments: tuple[str, ...]) -> None:
    assert call(*arguments).exit_code == 2


def test_blocks_that_were_computed_and_are_not_there_are_missed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As when a worker of a cluster writes into a folder of its own."""
    monkeypatch.setattr("studies.run.story.run_task", lambda store, draw, wanted, task: Done.of(task))
    with pytest.raises(BackendError, match=r"6 of 6 blocks were computed and are not in .*; do all workers see it"):
        run_here(tmp_path)


def test_without_a_terminal_progress_is_lines_and_seldom(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_bar(10, " trials") as bar:
        for _ in range(5):
            bar.update(1)
        bar.refresh()
    said = capsys.readouterr().err.splitlines(keepends=True)
    assert [line.split("%")[0].strip() for line in said] == ["0", "50"]
    assert all(line.endswith("\n") and "\r" not in line for line in said)
