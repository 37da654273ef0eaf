"""What quality control costs: reliability, the full protocol, and everything there is, for the block of Rheidt.

    python -m benchmarks.quality [--rounds N]

Whole seconds on one core, of the 616 unknowns of `rheidt-1980` with brown14; writes benchmarks/quality.json.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from adjust import Adjustment, adjust_block, ap_models
from adjust.quality import (
    Reliability,
    aic,
    bic,
    delete_stepwise,
    leave_one_image_out,
    robust,
    snoop,
    variance_components,
)
from benchmarks.machine import description
from simfield import Block, presets, simulate
from studies.protocol import files as protocol_files

OUT = Path(__file__).parent / "quality.json"


def adjusted(block: Block) -> Adjustment:
    return adjust_block(block, ap_models.get("brown14"))


def reliability(block: Block) -> None:
    """Adjustment, redundancy numbers, tests, minimal detectable biases and their effects of 6626 observations."""
    found = Reliability.of(adjusted(block))
    for values in (found.redundancy, found.w, found.mdb, found.external):
        assert np.isfinite(values).any()


def protocol(block: Block) -> None:
    """Adjustment and all files of the protocol."""
    with tempfile.TemporaryDirectory() as folder:
        protocol_files.write(adjusted(block), Path(folder))


def everything(block: Block) -> None:
    """The protocol, and what has no place in it: robust estimation and stepwise deletion of parameters."""
    protocol(block)
    a = adjusted(block)
    robust(a)
    delete_stepwise(a)


PARTS: dict[str, Callable[[Adjustment], object]] = {
    "all standard deviations": lambda a: a.std,
    "snooping": snoop,
    "robust": robust,
    "variance components": variance_components,
    "leave one image out": leave_one_image_out,
    "stepwise deletion": delete_stepwise,
    "aic and bic": lambda a: (aic(a), bic(a)),
}


def measure(rounds: int) -> dict[str, Any]:
    """Seconds of the whole and of the parts, medians of interleaved repetitions."""
    block, _ = simulate(presets["rheidt-1980"], seed=1980)
    whole = {"adjust_block": adjusted, "reliability": reliability, "protocol": protocol, "everything": everything}
    seconds: dict[str, list[float]] = {name: [] for name in (*whole, *PARTS)}
    for part in (*whole.values(),):  # compiled code is loaded
        part(block)
    for _ in range(rounds):
        for name, job in whole.items():
            begin = time.perf_counter()
            job(block)
            seconds[name].append(time.perf_counter() - begin)
        for name, of in PARTS.items():
            a = adjusted(block)
            begin = time.perf_counter()
            of(a)
            seconds[name].append(time.perf_counter() - begin)
    return {
        "seconds": {name: float(np.median(s)) for name, s in seconds.items()},
        "all": seconds,
        "rounds": rounds,
        "machine": description(),
    }


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.quality", description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    with threadpool_limits(1):
        found = measure(options.rounds)
    for name, median in found["seconds"].items():
        print(f"{name:26} {median:8.3f} s")
    OUT.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
