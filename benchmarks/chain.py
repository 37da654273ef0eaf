"""What the measurement chain costs beside the adjustment it feeds: trials a second with all stages, and plain noise.

    python -m benchmarks.chain [--rounds N] [--trials N]

Both go through `adjust_replicates` over the same block with the same model, in one process on one core, turn by turn;
`stages` are also timed without adjusting. Writes benchmarks/chain.json.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from adjust import adjust_replicates, ap_models
from adjust.reductions import ReductionPlan, reduce
from benchmarks.machine import description
from benchmarks.timing import summary
from simfield import World, build_world, presets
from simfield.chain import Chain, Errors, Marks, chains, prepare
from simfield.numerics import TOGETHER
from studies.trials import MeasuredTrials

SCENARIO, SEED, MODEL = "rheidt-1980-film", 1980, "brown14"
ROUNDS, TRIALS = 15, 1920
WITH_ERRORS = Errors(pointing_um=2.0, gross_rate=0.002, gross_um=60.0, confused_rate=0.001)
"""these trials are drawn only: an adjustment with gross errors of many sigma is left to Gauss-Newton, and is slow"""
DRAWN_ONLY = "psk-1969, errors"


def draws_of(world: World, trials: int) -> dict[str, Any]:
    """Plain noise, and chains from few to all stages, by name."""
    psk = chains["psk-1969"]
    marks = Marks("both", reseau_spacing_mm=25.0, calibration_um=1.0)

    def measured(chain: Chain, plan: ReductionPlan) -> MeasuredTrials:
        return MeasuredTrials(prepare(world, chain), plan, 0, trials)

    plain = replace(world.scenario, film=())
    return {
        "plain noise": build_world(plain, SEED).draws(0, trials),
        "noise and film": world.draws(0, trials),
        "psk-1969": measured(psk, ReductionPlan("helmert")),
        "psk-1969, affine": measured(psk, ReductionPlan("affine")),
        "psk-1969, errors": measured(replace(psk, errors=WITH_ERRORS), ReductionPlan("affine")),
        "eight marks, projective": measured(replace(psk, marks=Marks("both")), ReductionPlan("projective")),
        "reseau of 81 crosses": measured(replace(psk, marks=marks), ReductionPlan("bilinear", reseau_degree=3)),
    }


def measure(rounds: int, trials: int, clock: Callable[[], float] = time.process_time) -> dict[str, Any]:
    """Milliseconds a trial, of drawing alone and of drawing and adjusting, by name."""
    world = build_world(presets[SCENARIO], SEED)
    draws, model = draws_of(world, trials), ap_models.get(MODEL)
    block = reduce(prepare(world, chains["psk-1969"]).measure(0), ReductionPlan("affine")).block
    lanes = np.empty((TOGETHER // 8, len(world.image), 2, 8))
    seconds: dict[str, dict[str, list[float]]] = {name: {"drawn": [], "adjusted": []} for name in draws}
    for turn in range(rounds + 1):
        for name, own in draws.items():
            begin = clock()
            for first in range(0, trials, TOGETHER):
                own.fill_lanes(slice(first, first + TOGETHER), lanes)
            drawn = clock() - begin
            begin = clock()
            if name != DRAWN_ONLY:
                adjust_replicates(block, model, own)
            adjusted = clock() - begin
            # the first turn compiles
            if turn:
                seconds[name]["drawn"].append(drawn)
                seconds[name]["adjusted"].append(adjusted)
    return {name: {what: summary(s, trials) for what, s in own.items()} for name, own in seconds.items()}


def shares(found: dict[str, Any]) -> dict[str, float]:
    """Trials a second as shares of those with plain noise, of medians."""
    plain = found["plain noise"]["adjusted"]["median_ms"]
    return {name: plain / own["adjusted"]["median_ms"] for name, own in found.items() if name != DRAWN_ONLY}


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    parser.add_argument("--trials", type=int, default=TRIALS)
    arguments = parser.parse_args()
    with threadpool_limits(1):
        found = measure(arguments.rounds, arguments.trials // TOGETHER * TOGETHER)
    of_plain = shares(found)
    for name, own in found.items():
        drawn, adjusted = own["drawn"]["median_ms"], own["adjusted"]["median_ms"]
        if name == DRAWN_ONLY:
            print(f"{name:26} drawn {1000 * drawn:6.0f} us")
            continue
        of = f"{of_plain[name]:.2f} of plain"
        print(f"{name:26} drawn {1000 * drawn:6.0f} us   adjusted {1000 * adjusted:6.0f} us   {of}")
    record = {
        "what": "processor time a trial, one core",
        "rounds": arguments.rounds,
        "trials": arguments.trials,
        "load_at_end": os.getloadavg()[0],
        "machine": description(),
        "seconds": found,
        "share_of_plain": of_plain,
    }
    Path(__file__).with_name("chain.json").write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
