"""This engine beside scipy, GTSAM and Ceres: `python -m benchmarks.bench`, or `make bench`.

README.md says what is measured. Results on stdout, ratios first; progress on stderr; everything measured as JSON.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks import machine
from benchmarks.flops import BROWN14 as BROWN14_COUNT, TrialFlops
from benchmarks.growing import SIZES
from benchmarks.ours import AdjustBlock, AdjustReplicates
from benchmarks.page import report
from benchmarks.problem import BROWN14, IDEAL4, NONE, OPTICAL, Problem, Solver
from benchmarks.separate import apart
from benchmarks.timing import interleaved, summary

LATEST = Path(__file__).parent / "latest.json"
AGREEMENT = 1e-8
"""largest relative difference of the costs of solvers that state the same problem"""
STD_AGREEMENT = 1e-7
"""of standard deviations: GTSAM holds control and interior orientation by 1e-6 m, and stops earlier"""
PEERS = ("scipy", "gtsam", "ceres")
PACKAGE = {"scipy": "scipy", "gtsam": "gtsam", "ceres": "pycolmap"}
CALLS_OF_THE_FAST = 3


def main(arguments: list[str] | None = None) -> int:
    options = _options(arguments)
    with threadpool_limits(1):
        results = measure(options)
    print(report(results))
    if options.output is not None:
        options.output.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
        _say(f"written: {options.output}")
    return 0 if results["agree"] else 1


def _options(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.bench", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="some seconds: two rounds, few trials, one block size")
    parser.add_argument("--peers", nargs="*", default=list(PEERS), metavar="PEER", help="of scipy, gtsam and ceres")
    parser.add_argument("--rounds", type=int, help="interleaved repetitions (7; quick 2)")
    parser.add_argument("--trials", type=int, help="of adjust_replicates in a repetition (10000; quick 64)")
    parser.add_argument("--most-images", type=int, help="of the scaling (2500; quick 39)")
    parser.add_argument("--output", type=Path, help="the JSON file (benchmarks/latest.json; quick: none)")
    options = parser.parse_args(arguments)
    if unknown := sorted(set(options.peers) - set(PEERS)):
        parser.error(f"no peer named {unknown[0]!r}, there are {', '.join(PEERS)}")
    full = {"rounds": 7, "trials": 10_000, "most_images": max(SIZES), "output": LATEST}
    quick = {"rounds": 2, "trials": 64, "most_images": min(SIZES), "output": None}
    for name, value in (quick if options.quick else full).items():
        if getattr(options, name) is None:
            setattr(options, name, value)
    return options


def measure(options: argparse.Namespace) -> dict[str, Any]:
    """Everything that is measured, with the ratios at the top."""
    problem = Problem.of()
    solvers = build_solvers(problem, options.peers, options.trials)
    _say("first calls, which may compile")
    _first_calls(problem, solvers)
    peak: list[float] = []

    def each_round(number: int) -> None:
        _say(f"round {number + 1} of {options.rounds}")
        peak.extend(machine.dgemm_gflops(repetitions=3))

    calls = {name: CALLS_OF_THE_FAST for name in solvers if name.startswith(("ceres", "adjust_block"))}
    seconds = interleaved(solvers, options.rounds, calls, each_round)
    per = {name: options.trials if name.startswith("adjust_replicates") else 1 for name in solvers}
    times = {name: summary(s, per[name]) for name, s in seconds.items()}
    _say("agreement of the minima")
    agreement = agree(problem, solvers)
    flops = flop_limit(problem, solvers, times, float(np.median(peak)))
    scaling = measure_scaling(options.most_images, seconds=1.0 if options.quick else 20.0)
    memory = None if options.quick else _memory(options.trials)
    return {
        **ratios(times),
        "share_of_flop_limit": flops["share"],
        "scaling_exponent": scaling["exponent"],
        "agree": agreement["agree"],
        "quick": options.quick,
        "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "machine": machine.description(),
        "peak": {"dgemm_gflops_median": float(np.median(peak)), "dgemm_gflops_best": max(peak), "all": peak},
        "times": {name: {**times[name], "note": getattr(solvers[name], "note", "")} for name in solvers},
        "agreement": agreement,
        "flops": flops,
        "scaling": scaling,
        "memory": memory,
    }


def build_solvers(problem: Problem, peers: list[str], trials: int) -> dict[str, Solver]:
    """The solvers by name, "solver form [variant]"; peers that are not installed are left out."""
    solvers: dict[str, Solver] = {}
    for peer in peers:
        if machine.installed(PACKAGE[peer]) is None:
            _say(f"{PACKAGE[peer]} is not installed: {peer} is left out")
            continue
        solvers |= {"scipy": _scipy, "gtsam": _gtsam, "ceres": _ceres}[peer](problem)
    return solvers | {
        "adjust_block none": AdjustBlock(problem, NONE),
        "adjust_block optical": AdjustBlock(problem, OPTICAL),
        "adjust_block optical with std": AdjustBlock(problem, OPTICAL, with_std=True),
        "adjust_block brown14": AdjustBlock(problem, BROWN14),
        "adjust_block brown14 with std": AdjustBlock(problem, BROWN14, with_std=True),
        "adjust_block brown14 with std, plain numpy": AdjustBlock(problem, BROWN14, with_std=True, compiled=False),
        "adjust_replicates none": AdjustReplicates(problem, NONE, trials),
        "adjust_replicates optical": AdjustReplicates(problem, OPTICAL, trials),
        "adjust_replicates brown14": AdjustReplicates(problem, BROWN14, trials),
    }


def _scipy(problem: Problem) -> dict[str, Solver]:
    from benchmarks.peers_scipy import Scipy

    return {"scipy none": Scipy(problem, NONE), "scipy brown14": Scipy(problem, BROWN14)}


def _gtsam(problem: Problem) -> dict[str, Solver]:
    from benchmarks.peers_gtsam import Gtsam

    return {"gtsam none": Gtsam(problem, NONE), "gtsam ideal4": Gtsam(problem, IDEAL4)}


def _ceres(problem: Problem) -> dict[str, Solver]:
    from benchmarks.peers_ceres import Ceres, CeresWarm, CeresWritten

    return {
        "ceres none": Ceres(problem, NONE),
        "ceres ideal4": Ceres(problem, IDEAL4),
        "ceres ideal4 default": Ceres(problem, IDEAL4, tuned=False),
        "ceres ideal4 warm": CeresWarm(problem, IDEAL4),
        "ceres ideal4 written": CeresWritten(problem, IDEAL4),
        "ceres ideal4 looped": CeresWritten(problem, IDEAL4, tuned=False),
    }


def _first_calls(problem: Problem, solvers: dict[str, Solver]) -> None:
    for solver in solvers.values():
        first = AdjustReplicates(problem, solver.form, 32) if isinstance(solver, AdjustReplicates) else solver
        first.prepare(0)
        first.solve()


def agree(problem: Problem, solvers: dict[str, Solver]) -> dict[str, Any]:
    """vPv of every solver's answer to trial 0, by one function for all, and how far it lies above the form's least."""
    cost: dict[str, dict[str, float]] = {}
    for name, solver in solvers.items():
        solver.prepare(0)
        if not isinstance(solver, AdjustReplicates):  # which have solved trial 0 in every round
            solver.solve()
        cost.setdefault(solver.form, {})[name] = problem.cost(solver.answer(), solver.form, trial=0)
    forms: dict[str, Any] = {}
    for form, of_solver in cost.items():
        least = min(of_solver.values())
        forms[form] = {
            "unknowns": problem.unknowns(form),
            "cost": of_solver,
            "relative_difference": {name: value / least - 1.0 for name, value in of_solver.items()},
        }
    largest = max(max(f["relative_difference"].values()) for f in forms.values())
    std = std_agreement(solvers)
    return {
        "agree": bool(largest <= AGREEMENT and (std is None or std <= STD_AGREEMENT)),
        "tolerance": AGREEMENT,
        "largest": largest,
        "std_against_gtsam": std,
        "forms": forms,
    }


def std_agreement(solvers: dict[str, Solver]) -> float | None:
    """The largest relative difference of the points' standard deviations from GTSAM's marginals, without parameters."""
    if "gtsam none" not in solvers:
        return None
    gtsam, ours = solvers["gtsam none"].point_std(), solvers["adjust_block none"].point_std()  # type: ignore[attr-defined]
    free = ours > 0.0
    return float(np.max(np.abs(gtsam[free] / ours[free] - 1.0)))


def ratios(times: dict[str, dict[str, Any]]) -> dict[str, float | None]:
    """How many times faster, by medians; None where a peer was left out."""

    def over(slow: str, fast: str) -> float | None:
        return times[slow]["median_ms"] / times[fast]["median_ms"] if slow in times else None

    looped, tuned = "ceres ideal4 looped", "ceres ideal4"
    return {
        "replicates_over_ceres": over(looped, "adjust_replicates optical"),
        "adjust_over_ceres": over(looped, "adjust_block optical"),
        "adjust_with_std_over_ceres": over(looped, "adjust_block optical with std"),
        "replicates_brown14_over_ceres": over(looped, "adjust_replicates brown14"),
        "adjust_brown14_over_ceres": over(looped, "adjust_block brown14"),
        "replicates_over_ceres_tuned": over(tuned, "adjust_replicates optical"),
        "adjust_over_ceres_tuned": over(tuned, "adjust_block optical"),
        "adjust_with_std_over_ceres_tuned": over(tuned, "adjust_block optical with std"),
        "replicates_over_ceres_warm": over("ceres ideal4 warm", "adjust_replicates optical"),
        "replicates_over_ceres_both_none": over("ceres none", "adjust_replicates none"),
        "adjust_over_ceres_both_none": over("ceres none", "adjust_block none"),
        "replicates_over_gtsam": over("gtsam ideal4", "adjust_replicates optical"),
        "adjust_over_gtsam": over("gtsam ideal4", "adjust_block optical"),
        "replicates_over_scipy": over("scipy brown14", "adjust_replicates brown14"),
        "adjust_over_scipy": over("scipy brown14", "adjust_block brown14"),
    }


def flop_limit(
    problem: Problem, solvers: dict[str, Solver], times: dict[str, dict[str, Any]], peak_gflops: float
) -> dict[str, Any]:
    """The share of the measured peak that adjust_replicates reaches, and the operations it is computed from."""
    solver = solvers["adjust_replicates brown14"]
    assert isinstance(solver, AdjustReplicates)
    steps = float(solver.replicates.iterations.mean())
    flops = TrialFlops.of(len(problem.block.observations), problem.unknowns(BROWN14), steps, BROWN14_COUNT)
    limit_ms = flops.total / peak_gflops / 1e6
    measured_ms = times["adjust_replicates brown14"]["median_ms"]
    return {
        "share": limit_ms / measured_ms,
        "share_if_single_counts_full": (flops.total + flops.corrections + flops.first)
        / peak_gflops
        / 1e6
        / measured_ms,
        "steps_per_trial": steps,
        "mflop_per_trial": flops.total / 1e6,
        "mflop": {name: value / 1e6 for name, value in vars(flops).items()},
        "limit_ms": limit_ms,
        "measured_ms": measured_ms,
    }


def measure_scaling(most_images: int, seconds: float) -> dict[str, Any]:
    """adjust_block over the growing block, a process each; the exponent of a straight line through the logarithms."""
    blocks, failed = [], {}
    for images in (n for n in SIZES if n <= most_images):
        _say(f"scaling: {images} images")
        try:
            blocks.append(apart("scaling", images, seconds))
        except subprocess.CalledProcessError as error:
            failed[images] = error.returncode
            _say(f"{images} images could not be adjusted")
    median = [float(np.median(b["seconds"])) for b in blocks]
    exponent = None
    if len(blocks) >= 2:
        exponent = float(np.polyfit(np.log([b["images"] for b in blocks]), np.log(median), 1)[0])
    return {
        "exponent": exponent,
        "blocks": [{"median_s": m, **b} for m, b in zip(median, blocks, strict=True)],
        "failed": failed,
    }


def _memory(trials: int) -> dict[str, Any]:
    _say(f"memory of {trials} trials")
    return apart("memory", trials)


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    raise SystemExit(main())
