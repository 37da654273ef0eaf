"""A study on a dask cluster of two workers beside two processes of joblib: `python -m benchmarks.cluster`.

Scheduler and workers are processes of their own, as docs/howto/cluster.md starts them. Both sides are warm: pools
started, code imported and compiled, by a first round that is forgotten. Repetitions interleave.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import machine
from studies.design import Plan, shipped
from studies.run import story as run

LATEST = Path(__file__).parent / "latest_cluster.json"
LIMIT = 0.10
"""what dask may cost on top of joblib"""
WORKERS = 2


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.cluster", description=__doc__)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--trials", type=int, default=8192)
    parser.add_argument("--output", type=Path, help=f"the JSON file, such as {LATEST.name}")
    options = parser.parse_args(arguments)
    with cluster() as scheduler:
        results = measure(options.rounds, options.trials, scheduler)
    print(report(results))
    if options.output is not None:
        options.output.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    return 0


def measure(rounds: int, trials: int, scheduler: str) -> dict[str, Any]:
    """Seconds in which all blocks of study ap-models are computed and stored, by both back ends in turn."""
    plan = Plan.of(shipped.study("ap-models").with_changes(trials=trials))
    hows = {
        "joblib": run.How(jobs=WORKERS),
        "dask": run.How(jobs=WORKERS, backend="dask", scheduler=scheduler),
    }
    seconds: dict[str, list[float]] = {name: [] for name in hows}
    for number in range(rounds + 1):
        for name in sorted(hows, reverse=number % 2 == 1):  # neither always comes second
            seconds[name].append(timed(plan, hows[name]))
        print(f"round {number} of {rounds}", file=sys.stderr, flush=True)
    kept = {name: values[1:] for name, values in seconds.items()}
    ratio = np.array(kept["dask"]) / np.array(kept["joblib"]) - 1.0
    return {
        "overhead": float(np.median(kept["dask"]) / np.median(kept["joblib"]) - 1.0),
        "overhead_of_minima": min(kept["dask"]) / min(kept["joblib"]) - 1.0,
        "overhead_by_round": ratio.tolist(),
        "limit": LIMIT,
        "trials": trials,
        "blocks": plan.blocks * len(plan.conditions),
        "seconds": kept,
        "machine": machine.description(),
    }


def timed(plan: Plan, how: run.How) -> float:
    with tempfile.TemporaryDirectory() as name:
        store = run.opened(Path(name), plan)
        run.become_main()
        begin = time.perf_counter()
        run.compute_missing(plan, store, how, lambda line: None, lambda *done: None)
        return time.perf_counter() - begin


@contextlib.contextmanager
def cluster() -> Iterator[str]:
    """A scheduler and workers on the loopback; gives the scheduler's address."""
    import distributed

    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = str(probe.getsockname()[1])
    address = f"tcp://127.0.0.1:{port}"
    scheduler = _start("scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard")
    worker = ("worker", address, "--nthreads", "1", "--no-dashboard", "--local-directory", tempfile.gettempdir())
    processes = [scheduler, *(_start(*worker) for _ in range(WORKERS))]
    try:
        client_of: Any = distributed.Client
        with client_of(address, timeout=60, set_as_default=False) as client:
            client.wait_for_workers(WORKERS, timeout=60)
        yield address
    finally:
        for process in processes:
            os.killpg(process.pid, signal.SIGTERM)
            process.wait()


def _start(*arguments: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", f"distributed.cli.dask_{arguments[0]}", *arguments[1:]]
    return subprocess.Popen(command, stderr=subprocess.DEVNULL, start_new_session=True)


def report(results: dict[str, Any]) -> str:
    lines = [f"{results['blocks']} blocks, {results['trials']} trials, {WORKERS} processes; seconds"]
    for name, values in results["seconds"].items():
        lines.append(f"  {name:8} median {np.median(values):7.3f}   least {min(values):7.3f}")
    lines.append(
        f"dask on top of joblib: {results['overhead']:.1%} by medians, {results['overhead_of_minima']:.1%} by the"
        f" fastest rounds, allowed {results['limit']:.0%}"
    )
    return "\n".join(lines)


if __name__ == "__main__":
    raise SystemExit(main())
