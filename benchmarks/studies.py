"""What a study costs on top of its bare adjustments: `python -m benchmarks.studies`, or `make bench-studies`.

bare: `adjust_replicates` for every method of study ap-models, drawing its trials and keeping nothing. study: the same
trials drawn, adjusted, compared with the truth, stored as shards with fsync, read again, summarised with Monte-Carlo
standard errors and written; report and figures apart, since they cost the same for any number of trials. One process,
interleaved repetitions. CPU time stands beside the clock's, because other programs slow down only the latter.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from adjust.trials import adjust_replicates
from benchmarks import machine
from simfield import build_world
from studies.design import Plan, shipped
from studies.pages import study_report
from studies.run import story as run
from studies.summary import summary
from studies.trials import Geometry, forget

LATEST = Path(__file__).parent / "latest_studies.json"
LIMIT = 0.30
"""what a study may cost on top of the bare adjustments"""


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.studies", description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--trials", type=int, default=2000)
    parser.add_argument("--output", type=Path, help=f"the JSON file, such as {LATEST.name}")
    options = parser.parse_args(arguments)
    results = measure(options.rounds, options.trials)
    print(report(results))
    if options.output is not None:
        options.output.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    return 0


def measure(rounds: int, trials: int) -> dict[str, Any]:
    """Seconds of the clock and of the processor, for each part, in every round."""
    plan = Plan.of(shipped.study("ap-models").with_changes(trials=trials))
    parts: dict[str, Callable[[], object]] = {"bare": bare(plan)}
    seconds: dict[str, list[tuple[float, float]]] = {}
    for number in range(rounds + 1):  # the first one compiles and is forgotten
        with tempfile.TemporaryDirectory() as name:
            for part, work in {**parts, **studied(plan, Path(name))}.items():
                seconds.setdefault(part, []).append(timed(work))
        print(f"round {number} of {rounds}", file=sys.stderr, flush=True)
    kept = {part: np.array(values[1:]) for part, values in seconds.items()}
    on_top = (kept["trials and store"] + kept["summary"]) / kept["bare"] - 1.0
    return {
        "overhead": float(np.median(on_top[:, 0])),
        "overhead_cpu": float(np.median(on_top[:, 1])),
        "limit": LIMIT,
        "trials": trials,
        "methods": len(plan.methods),
        "seconds": {part: values[:, 0].tolist() for part, values in kept.items()},
        "cpu_seconds": {part: values[:, 1].tolist() for part, values in kept.items()},
        "machine": machine.description(),
    }


def timed(work: Callable[[], object]) -> tuple[float, float]:
    clock, cpu = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - clock, time.process_time() - cpu


def bare(plan: Plan) -> Callable[[], object]:
    """The adjustments alone; worlds, parts and the survey's coordinates are made beforehand."""
    condition = plan.conditions[0]
    geometry = Geometry(build_world(condition.scenario, condition.seed))
    world = geometry.world
    given = np.array([world.given_coordinates(trial) for trial in range(plan.trials)])
    parts = [(method.ap_model(), geometry.prepared(method).part) for method in plan.methods]
    coordinates = [np.ascontiguousarray(given[:, part.points]) for _, part in parts]

    def adjust_all() -> None:
        for (model, part), own in zip(parts, coordinates, strict=True):
            adjust_replicates(part.block, model, world.draws(0, plan.trials).only(part.rays), coordinates=own)

    return adjust_all


def studied(plan: Plan, folder: Path) -> dict[str, Callable[[], object]]:
    """The chapters of a run, in their order; what one leaves, the next one finds."""
    found: dict[str, Any] = {}

    def trials() -> None:
        forget()  # as in a new process
        found["store"] = run.opened(folder, plan)
        run.compute_missing(plan, found["store"], run.How(backend="here"), lambda line: None, lambda *done: None)

    def summarise() -> None:
        found["summary"] = summary.summarise(plan, found["store"])
        summary.write(found["summary"], plan, folder)

    return {
        "trials and store": trials,
        "summary": summarise,
        "report and figures": lambda: study_report.write(found["summary"], plan, folder),
    }


def report(results: dict[str, Any]) -> str:
    lines = [
        f"{results['methods']} methods, {results['trials']} trials; median seconds of the clock (of the processor)"
    ]
    for part, values in results["seconds"].items():
        lines.append(f"  {part:20} {np.median(values):7.3f}  ({np.median(results['cpu_seconds'][part]):.3f})")
    lines.append(
        f"on top of the bare adjustments: {results['overhead']:.1%} ({results['overhead_cpu']:.1%}),"
        f" allowed {results['limit']:.0%}"
    )
    return "\n".join(lines)


if __name__ == "__main__":
    raise SystemExit(main())
