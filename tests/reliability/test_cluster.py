"""dask: scheduler and workers started as processes of their own; one is killed in the middle."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from studies.run.worker import BackendError
from tests.reliability import traps
from tests.reliability.test_crashes import gone
from tests.studies.small_study import TEXT, contents, run_here

pytest.importorskip("distributed")
TOP = Path(__file__).parents[2]


def start(*arguments: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "distributed.cli.dask_" + arguments[0], *arguments[1:]]
    environment = {**os.environ, "PYTHONPATH": str(TOP), "DASK_DISTRIBUTED__WORKER__DAEMON": "False"}
    return subprocess.Popen(
        command, cwd=TOP, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Cluster:
    """A scheduler and two workers, each restarted by nobody."""

    def __init__(self, folder: Path) -> None:
        port = free_port()
        self.address = f"tcp://127.0.0.1:{port}"
        self.scheduler = start("scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard", "--no-show")
        options = ("--nthreads", "1", "--no-dashboard", "--no-nanny", "--local-directory", str(folder))
        self.workers = [start("worker", self.address, *options) for _ in range(2)]

    def stop(self) -> None:
        for process in (*self.workers, self.scheduler):
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    made = Cluster(tmp_path)
    try:
        wait_for_workers(made, 2)
        yield made
    finally:
        made.stop()


def wait_for_workers(cluster: Cluster, count: int) -> None:
    import distributed

    ends = time.monotonic() + 60.0
    while time.monotonic() < ends:
        try:
            with distributed.Client(cluster.address, timeout=5, set_as_default=False) as client:
                client.wait_for_workers(count, timeout=30)
                return
        except (OSError, TimeoutError):
            time.sleep(0.5)
    raise TimeoutError("no workers")


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder: Path = tmp_path_factory.mktemp("undisturbed")
    run_here(folder)
    return folder


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_cluster_of_which_a_worker_is_killed_gives_the_same_bytes(
    tmp_path: Path, undisturbed: Path, cluster: Cluster
) -> None:
    import threading

    def kill_one() -> None:
        ends = time.monotonic() + 60.0
        while not list((tmp_path / "store").rglob("[0-9]*.parquet")) and time.monotonic() < ends:
            time.sleep(0.05)
        os.killpg(cluster.workers[0].pid, signal.SIGKILL)

    killer = threading.Thread(target=kill_one)
    killer.start()
    run_here(tmp_path / "store", backend="dask", scheduler=cluster.address, draw=traps.slow)
    killer.join()
    assert cluster.workers[0].wait(10) != 0
    assert contents(tmp_path / "store") == contents(undisturbed)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_trial_that_kills_every_worker_is_found_at_last(tmp_path: Path, cluster: Cluster) -> None:
    how = {"backend": "dask", "scheduler": cluster.address, "draw": traps.killing, "trial_limit_s": 10.0}
    outcome, _ = run_here(tmp_path / "store", **how)
    assert sum("crashed" in line for line in outcome.failures) >= 1


@pytest.mark.slow
def test_a_killed_scheduler_ends_the_command_and_a_rerun_finishes(
    tmp_path: Path, undisturbed: Path, cluster: Cluster
) -> None:
    (tmp_path / "small.toml").write_text(TEXT.replace("max = 96", "max = 200000"), encoding="utf-8")
    store = tmp_path / "store"
    process = subprocess.Popen(
        [sys.executable, "-c", "from studies.commands import main; main()", "run", str(tmp_path / "small.toml"),
         "--out", str(store), "--backend", "dask", "--scheduler", cluster.address],
        cwd=TOP, start_new_session=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    ends = time.monotonic() + 120.0
    while len(list(store.rglob("[0-9]*.parquet"))) < 8 and process.poll() is None and time.monotonic() < ends:
        time.sleep(0.05)
    os.killpg(cluster.scheduler.pid, signal.SIGKILL)
    said = process.communicate(timeout=60)[0].decode()
    assert process.returncode == 1, said
    assert f"the dask scheduler at {cluster.address} is lost" in said
    assert "Traceback" not in said
    assert gone(process.pid, 10.0)
    for worker in cluster.workers:  # they write on until they notice, and nobody else may write then
        os.killpg(worker.pid, signal.SIGKILL)
    run_here(store)
    assert (store / "summary.csv").read_bytes() == (undisturbed / "summary.csv").read_bytes()


@pytest.mark.filterwarnings("ignore")
def test_no_scheduler_is_said_in_a_line(tmp_path: Path) -> None:
    with pytest.raises(BackendError, match="no dask scheduler at tcp://127"):
        run_here(tmp_path, backend="dask", scheduler=f"tcp://127.0.0.1:{free_port()}")
