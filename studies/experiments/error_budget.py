"""An error budget: micrometres that a stage puts into the images, that the reductions take out, that the AP model takes
up, and what is left in the check points, by Monte-Carlo with one stage at a time and all together.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from adjust import ApModel, adjust_replicates
from adjust.reductions import ReductionPlan, reduce
from simfield import World, build_world
from simfield.block import Block, Floats, ImageObservations
from simfield.chain import FILM, Air, Chain, Comparator, Errors, PreparedChain, prepare
from simfield.disturbances import Noise
from simfield.scenario import Scenario
from studies.design import fitting
from studies.summary import performance
from studies.trials import MeasuredTrials

EVERYTHING = "all together"
TRIALS_AT_ONCE = 64
"""trials whose coordinates are in memory at once"""
UNDISTURBED_UM = 1e-6
"""noise of a world without noise: the block's weights need some"""


@dataclass(frozen=True)
class Budget:
    """scenario and chain with all that disturbs them; plan and model by which they are reduced and adjusted."""

    scenario: Scenario
    chain: Chain
    plan: ReductionPlan
    model: ApModel


def stages(budget: Budget) -> Mapping[str, tuple[Scenario, Chain]]:
    """Every stage by itself: scenario and chain in which nothing else disturbs, then all together."""
    full, chain = budget.scenario, budget.chain
    quiet = replace(full, effects=(), film=(), noise=Noise(UNDISTURBED_UM, full.noise.assumed_um, 0.0))
    still = replace(
        chain,
        air=Air(),
        lenses=(),
        film_field=None,
        marks=replace(chain.marks, calibration_um=0.0),
        comparator=Comparator(settings=chain.comparator.settings),
        errors=Errors(),
    )
    machine = replace(chain.comparator, setting_um=0.0)
    own = full.effects
    return {
        "refraction": (quiet, replace(still, air=replace(chain.air, curvature=False))),
        "earth curvature": (quiet, replace(still, air=replace(chain.air, refraction=False))),
        "lens": (
            replace(quiet, effects=tuple(e for e in own if not _is_film(e.effect))),
            replace(still, lenses=chain.lenses),
        ),
        "film, constant": (replace(quiet, effects=tuple(e for e in own if _is_film(e.effect))), still),
        "film, drawn": (replace(quiet, film=full.film), replace(still, film_field=chain.film_field)),
        "marks": (quiet, replace(still, marks=chain.marks, errors=Errors(pointing_um=chain.errors.pointing_um))),
        "comparator": (quiet, replace(still, comparator=machine)),
        "settings": (
            quiet,
            replace(still, comparator=replace(still.comparator, setting_um=chain.comparator.setting_um)),
        ),
        "image noise": (replace(quiet, noise=replace(full.noise, geodetic_mm=0.0)), still),
        "geodetic error": (replace(quiet, noise=replace(quiet.noise, geodetic_mm=full.noise.geodetic_mm)), still),
        EVERYTHING: (full, chain),
    }


def table(budget: Budget, trials: int, seed: int, report: Callable[[int], object] = lambda _: None) -> pd.DataFrame:
    """A line a stage: put_in_um and left_um before and after the reductions (rms of a coordinate after the best rigid
    placement of each image), taken_out_um the root of the difference of their squares (negative: the reductions add),
    ap_um taken up by the model, residual_um (rms), m0_um, mu_xy_mm (2-D), mu_z_mm with their Monte-Carlo
    standard errors (_mcse), n trials and failures.
    """
    lines = []
    for name, (scenario, chain) in stages(budget).items():
        prepared = prepare(build_world(scenario, seed), chain)
        plan = fitting(budget.plan, prepared.chain)
        lines.append({"stage": name, **_measured(prepared, plan, budget.model, trials)})
        report(1)
    return pd.DataFrame(lines)


def _is_film(effect: object) -> bool:
    return isinstance(effect, FILM)


def _measured(prepared: PreparedChain, plan: ReductionPlan, model: ApModel, trials: int) -> dict[str, float]:
    world = prepared.world
    machine = MeasuredTrials(prepared, None, 0, trials)
    reduced = MeasuredTrials(prepared, plan, 0, trials)
    given = np.stack([world.given_coordinates(trial) for trial in range(trials)])
    squares = np.zeros(2)
    for first in range(0, trials, TRIALS_AT_ONCE):
        some = slice(first, min(first + TRIALS_AT_ONCE, trials))
        squares += [_squares_beyond_rigid(m[some], world).sum() for m in (machine, reduced)]
    before, after = (float(v) for v in 1000.0 * np.sqrt(squares / (trials * 2 * prepared.count)))
    return _figures(reduce(prepared.measure(0), plan).block, reduced, given, model, before, after, world.ideal)


def _figures(
    block: Block, points: MeasuredTrials, given: Floats, model: ApModel, put_in: float, left: float, ideal: Floats
) -> dict[str, float]:
    o = block.observations
    # the ideal block is the nominal one, so that all trials are near it
    nominal = Block(block.cameras, block.images, block.points, ImageObservations(o.image, o.point, ideal, o.sigma))
    r = adjust_replicates(nominal, model, points, coordinates=given)
    check = block.points.role == "check"
    deviations = 1000.0 * (r.points - given)[r.ok][:, check]
    taken = np.sign(put_in**2 - left**2) * np.sqrt(abs(put_in**2 - left**2))
    layout, xy = r.nominal.layout, ideal
    absorbed = np.zeros((int(r.ok.sum()), len(xy), 2))
    for number, s in enumerate(layout.sets):
        own = layout.image_set[o.image] == number
        if s.model.parameters and own.any():
            basis = s.model.basis(xy[own, 0], xy[own, 1])
            absorbed[:, own] = np.einsum("kca,ta->tkc", basis, r.ap(s.id)[r.ok])
    return {
        "put_in_um": put_in,
        "taken_out_um": float(taken),
        "left_um": left,
        "ap_um": 1000.0 * float(np.sqrt(np.mean(absorbed**2))),
        "residual_um": float(np.sqrt(np.mean(r.m0_um[r.ok] ** 2) * r.nominal.redundancy / r.nominal.observations)),
        **_mean("m0_um", r.m0_um[r.ok]),
        **_mean("mu_xy_mm", np.hypot(*np.sqrt(np.mean(deviations[:, :, :2] ** 2, axis=1)).T)),
        **_mean("mu_z_mm", np.sqrt(np.mean(deviations[:, :, 2] ** 2, axis=1))),
        "n": int(r.ok.sum()),
        "failures": int(np.sum(~r.ok)),
    }


def _mean(name: str, values: Floats) -> dict[str, float]:
    """The mean over trials and its Monte-Carlo standard error."""
    found = performance.mean(np.asarray(values)[:, None])
    return {name: float(found.estimate[0]), f"{name}_mcse": float(found.mcse[0])}


def _squares_beyond_rigid(measured: Floats, world: World) -> Floats:
    """(t, k) mm^2: squared distances of points (t, k, 2) from the ideal ones after the best shift and rotation of every
    image of every trial.
    """
    left = np.empty(measured.shape[:2])
    for i in range(len(world.plan)):
        own = world.image == i
        z, w = measured[:, own] @ [1.0, 1.0j], world.ideal[own] @ [1.0, 1.0j]
        z, w = z - z.mean(axis=1, keepdims=True), w - w.mean()
        turn = np.exp(-1j * np.angle(z @ w.conj()))
        left[:, own] = np.abs(z * turn[:, None] - w) ** 2
    return left
