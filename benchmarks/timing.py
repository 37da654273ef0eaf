"""Interleaved repetitions: every solver once, then every solver again, so that a busy minute hits all alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from benchmarks.problem import Solver


def interleaved(
    solvers: Mapping[str, Solver], rounds: int, calls: Mapping[str, int], each_round: Callable[[int], None]
) -> dict[str, list[float]]:
    """Seconds of every solve by solver. Round r solves trial r; calls: solves in a round (1 where not named)."""
    seconds: dict[str, list[float]] = {name: [] for name in solvers}
    for trial in range(rounds):
        each_round(trial)
        for name, solver in solvers.items():
            for _ in range(calls.get(name, 1)):
                solver.prepare(trial)
                begin = time.perf_counter()
                solver.solve()
                seconds[name].append(time.perf_counter() - begin)
    return seconds


def summary(seconds: list[float], per: int = 1) -> dict[str, Any]:
    """Median, least and all repetitions in ms, divided by `per`."""
    ms = [1000.0 * s / per for s in seconds]
    return {"median_ms": float(np.median(ms)), "min_ms": min(ms), "all_ms": [round(v, 6) for v in ms]}
