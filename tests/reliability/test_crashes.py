"""Workers that die, trials that hang, runs that are killed or interrupted: the store stays whole, nothing is lost."""

from __future__ import annotations

import contextlib
import csv
import io
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from studies.design.plan import Plan
from studies.store.look import joined, look_at
from studies.store.store import Store
from tests.reliability import traps
from tests.studies.small_study import TEXT, contents, run_here, study

TOP = Path(__file__).parents[2]
RUN = (
    "import sys; from pathlib import Path\n"
    "from studies.run.story import How, run\n"
    "from studies.design.study_file import read_study\n"
    "from tests.reliability import traps\n"
    "def main():\n"
    "    run(read_study(sys.argv[1]), Path(sys.argv[2]), How(jobs=int(sys.argv[3]), draw=traps.slow), print)\n"
    "if __name__ == '__main__': main()\n"
)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder: Path = tmp_path_factory.mktemp("undisturbed")
    run_here(folder)
    return folder


def start(folder: Path, jobs: int) -> subprocess.Popen[bytes]:
    """A run in a process group of its own, whose blocks take 0.3 s each."""
    (folder / "study.toml").write_text(TEXT, encoding="utf-8")
    (folder / "main.py").write_text(RUN, encoding="utf-8")
    command = [sys.executable, str(folder / "main.py"), str(folder / "study.toml"), str(folder / "store"), str(jobs)]
    return subprocess.Popen(
        command, cwd=TOP, env={**os.environ, "PYTHONPATH": str(TOP)}, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip


def group(leader: int) -> list[int]:
    """The living processes of a session."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == leader and fields[0] != "Z":
            found.append(int(path.parent.name))
    return found


def gone(leader: int, seconds: float) -> bool:
    ends = time.monotonic() + seconds
    while group(leader):
        if time.monotonic() > ends:
            return False
        time.sleep(0.1)
    return True


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_trial_that_kills_its_worker_is_marked_and_all_others_are_done(
    tmp_path: Path, undisturbed: Path, jobs: int
) -> None:
    asked = study(TEXT, ("[3.0, 6.0]", "[3.0]"))
    outcome, said = run_here(tmp_path, asked, backend="joblib", jobs=jobs, draw=traps.killing)
    plan = Plan.of(asked)
    condition = plan.conditions[0]
    assert Store(tmp_path, plan.identity_hash).failed(condition.id) == {traps.KILLER: "crashed"}
    assert any("its worker died or did not end" in line for line in said)
    assert f"trial {traps.KILLER}: crashed; simfield replay" in "\n".join(outcome.failures)
    columns, _ = joined(Store(tmp_path, plan.identity_hash), plan, condition, 96)
    sound, _ = joined(Store(undisturbed, plan.identity_hash), plan, condition, 96)
    for name, values in columns.items():
        kept = [t for t in range(96) if t != traps.KILLER]
        assert values[kept].tobytes() == sound[name][kept].tobytes(), name
        assert values[traps.KILLER] == 100 if name.endswith("status") else values[traps.KILLER] != values[traps.KILLER]
    rows = list(csv.DictReader(io.StringIO((tmp_path / "summary.csv").read_text(encoding="utf-8"))))
    assert {(r["n"], r["failures"]) for r in rows} == {("95", "1")}
    _, said = run_here(tmp_path, asked, backend="joblib", jobs=jobs, draw=traps.killing)
    assert said == ["3 of 3 blocks are there and whole"]


@pytest.mark.slow
def test_a_trial_that_hangs_is_given_up(tmp_path: Path) -> None:
    asked = study(TEXT, ("[3.0, 6.0]", "[3.0]"), ('["none", "optical"]', '["none"]'))
    started = time.monotonic()
    run_here(tmp_path, asked, backend="joblib", jobs=2, draw=traps.killing_and_sleeping, trial_limit_s=6.0)
    plan = Plan.of(asked)
    found = Store(tmp_path, plan.identity_hash).failed(plan.conditions[0].id)
    assert found == {traps.KILLER: "crashed", traps.SLEEPER: "timeout"}
    assert time.monotonic() - started < 400.0


def test_a_trial_that_cannot_be_simulated_is_counted(tmp_path: Path) -> None:
    outcome, _ = run_here(tmp_path, draw=traps.refusing)
    rows = list(csv.DictReader(io.StringIO((tmp_path / "summary.csv").read_text(encoding="utf-8"))))
    assert {(r["n"], r["failures"]) for r in rows} == {("95", "1")}
    assert outcome.failures == ()


KILLS = 10
MOST_STARTS = 60
"""a run that ends before its kill does not count and starts anew"""


def wait_for_a_shard_more(store: Path, process: subprocess.Popen[bytes], seconds: float) -> None:
    """Until a shard has been added, the process has ended or the time is up."""
    before, ends = len(shards_of(store)), time.monotonic() + seconds
    while len(shards_of(store)) <= before and process.poll() is None and time.monotonic() < ends:
        time.sleep(0.02)


def shards_of(store: Path) -> list[Path]:
    return list((store / "trials").rglob("[0-9]*.parquet"))


@pytest.mark.slow
@pytest.mark.parametrize("jobs", [1, 2])
def test_killed_ten_times_the_run_goes_on_and_ends_with_the_same_bytes(
    tmp_path: Path, undisturbed: Path, jobs: int
) -> None:
    """Every second kill at any instant from the start of the interpreter on, every other soon after a new shard."""
    chance, store = random.Random(jobs), tmp_path / "store"
    plan, kills, amid = Plan.of(study()), 0, 0
    begin = time.monotonic()
    start(tmp_path, jobs).communicate(timeout=200)
    whole_run_s = time.monotonic() - begin
    shutil.rmtree(store)
    for _ in range(MOST_STARTS):
        if kills == KILLS:
            break
        process = start(tmp_path, jobs)
        if kills % 2:
            wait_for_a_shard_more(store, process, 60.0)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(chance.uniform(0.0, 0.3 if kills % 2 else whole_run_s))
        if process.poll() is None:
            kills += 1
        process.kill()
        process.communicate(timeout=30)
        assert gone(process.pid, 10.0)
        own = Store(store, plan.identity_hash)
        states = [look_at(own, plan, condition, block).state for condition, block in plan.tasks()]
        assert set(states) <= {"whole", "missing"}
        amid += len(set(states)) == 2
        if "missing" not in states:
            shutil.rmtree(store / "trials")
    assert kills == KILLS
    assert amid  # some kill left a part of the work
    process = start(tmp_path, jobs)
    said = process.communicate(timeout=120)[0].decode()
    assert process.returncode == 0, said
    assert contents(store) == contents(undisturbed)


@pytest.mark.slow
def test_a_killed_worker_costs_nothing_but_time(tmp_path: Path, undisturbed: Path) -> None:
    process = start(tmp_path, 2)
    killed = 0
    ends = time.monotonic() + 60.0
    while killed < 2 and process.poll() is None and time.monotonic() < ends:
        time.sleep(0.4)
        others = [p for p in group(process.pid) if b"LokyProcess" in command(p)]
        if others and list((tmp_path / "store").rglob("*.parquet")):
            os.kill(others[-1], signal.SIGKILL)
            killed += 1
    said = process.communicate(timeout=120)[0].decode()
    assert process.returncode == 0, said
    assert killed
    assert contents(tmp_path / "store") == contents(undisturbed)


def command(process: int) -> bytes:
    try:
        return Path(f"/proc/{process}/cmdline").read_bytes()
    except OSError:
        return b""


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_the_command_soon_and_it_says_how_to_go_on(
    tmp_path: Path, number: signal.Signals, code: int
) -> None:
    (tmp_path / "small.toml").write_text(TEXT.replace("max = 96", "max = 200000"), encoding="utf-8")
    process = subprocess.Popen(
        [sys.executable, "-c", "from studies.commands.program import main; main()", "run", str(tmp_path / "small.toml"),
         "--out", str(tmp_path / "store"), "--jobs", "2"],
        cwd=TOP, start_new_session=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        # a shell has its background jobs ignore interrupts, and children inherit that
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    ends = time.monotonic() + 60.0
    while len(list((tmp_path / "store").rglob("[0-9]*.parquet"))) < 8 and time.monotonic() < ends:
        time.sleep(0.05)
    send: Callable[[int, int], None] = os.killpg if number == signal.SIGINT else os.kill
    send(process.pid, number)
    started = time.monotonic()
    _, errors = process.communicate(timeout=30)
    assert time.monotonic() - started < 5.0
    assert process.returncode == code, errors.decode()
    assert b"the same command goes on from there" in errors
    assert b"Traceback" not in errors
    assert gone(process.pid, 10.0)
    plan = Plan.of(study(TEXT, ("max = 96", "max = 320")))
    states = {look_at(Store(tmp_path / "store", plan.identity_hash), plan, *task).state for task in plan.tasks()}
    assert "damaged" not in states
    assert "whole" in states
