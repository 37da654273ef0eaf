"""Measurements that want a process of their own, because its peak of memory is one of the results.

    python -m benchmarks.separate scaling IMAGES SECONDS
    python -m benchmarks.separate memory TRIALS

One line of JSON on stdout.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from adjust import adjust_block, ap_models

REPETITIONS_MOST = 15


def peak_mb() -> float:
    """The largest resident set of this process so far, MB."""
    status = Path("/proc/self/status")
    if status.exists():  # getrusage would give that of the calling process where it was larger
        line = next(row for row in status.read_text(encoding="ascii").splitlines() if row.startswith("VmHWM"))
        return int(line.split()[1]) / 2.0**10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2.0**20 if sys.platform == "darwin" else 2.0**10)


def scaling(images: int, seconds: float) -> dict[str, Any]:
    """Adjust the growing block of `images` images again and again for about `seconds`, at least once."""
    from benchmarks.growing import SIZES, growing_block

    begin = time.perf_counter()
    block = growing_block(images)
    built = time.perf_counter() - begin
    model = ap_models.get("brown14")
    times: list[float] = []
    with threadpool_limits(1):
        adjust_block(growing_block(min(SIZES)), model)  # compiled code is loaded by the first call
        while not times or (sum(times) < seconds and len(times) < REPETITIONS_MOST):
            begin = time.perf_counter()
            a = adjust_block(block, model)
            times.append(time.perf_counter() - begin)
        if not a.status.ok:
            raise SystemExit(f"{images} images: {a.message}")
    return {
        "images": images,
        "points": len(block.points),
        "image_points": len(block.observations),
        "unknowns": a.unknowns,
        "iterations": a.iterations,
        "sigma0": a.sigma0,
        "seconds": times,
        "build_seconds": built,
        "peak_mb": peak_mb(),
    }


def memory(count: int) -> dict[str, Any]:
    """`count` trials of the main block, results kept."""
    from benchmarks.ours import AdjustReplicates
    from benchmarks.problem import BROWN14, Problem

    before = peak_mb()
    solver = AdjustReplicates(Problem.of(), BROWN14, count)
    begin = time.perf_counter()
    solver.solve()
    elapsed = time.perf_counter() - begin
    results = solver.replicates.trials.x.nbytes / 2.0**20
    return {"trials": count, "seconds": elapsed, "peak_mb": peak_mb(), "before_mb": before, "estimates_mb": results}


def apart(*arguments: object) -> dict[str, Any]:
    """One of the above in a process of its own. Raises CalledProcessError where it fails."""
    command = [sys.executable, "-m", "benchmarks.separate", *(str(a) for a in arguments)]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    return dict(json.loads(done.stdout))


if __name__ == "__main__":
    kind, *rest = sys.argv[1:]
    print(json.dumps(scaling(int(rest[0]), float(rest[1])) if kind == "scaling" else memory(int(rest[0]))))
