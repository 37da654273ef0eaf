"""Sizes of the variance components, fitted to all 54 published figures at once.

First the expected squares, which are linear in the variances: non-negative least squares of relative differences, m0
with a standard deviation of 5 %, mu of 17 %. A published figure is one draw from a skew distribution, though, and the
figures of one experiment hang together; so the sizes are then refined: sampled worlds give the mean and the standard
deviation of the logarithm of every figure for any sizes, and the sizes that make the published logarithms most likely
(each figure for itself, a composite likelihood) are searched within bounds. Figures outside the range of nearly all
worlds cost extra.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import optimize

from simfield import World
from simfield.block import Floats
from simfield.random import stream
from studies.experiments.mauelshagen_1980_twin.components import Component, film_fields
from studies.experiments.mauelshagen_1980_twin.propagation import LinearRow

RELATIVE_OF_SQUARES = (0.1, 0.35, 0.35)
"""standard deviations of the squares of m0, mu_xy, mu_z in the first fit, relative"""
ROUNDING = 0.01
"""standard deviation of a published figure from its rounding, relative"""
TAIL, TAIL_WEIGHT = 1.6, 3.0
"""a figure further from its mean than so many standard deviations costs extra, so much for the square of the excess"""
NOISE_LEAST_UM = 2.0
"""below this no comparator of the time measured (rheidt: plates gave 2.3 to 2.5 um)"""
GEODETIC_MOST_MM = 10.0
"""the stated accuracy of the field"""
MOST = 20.0
SMALLEST = 0.5
"""film components below this are left out"""
RANGE = (2.5, 97.5)


@dataclass(frozen=True, eq=False)
class Sampled:
    """gram (f, t, c, c): the squares of figure f in sampled world t are s^T gram[f, t] s for any sizes s (c)."""

    gram: Floats

    def logs(self, sizes: Floats) -> tuple[Floats, Floats]:
        """The logarithms (f, t) of the figures, and their derivatives (f, t, c) by the sizes."""
        half = self.gram @ sizes
        squares = half @ sizes
        return 0.5 * np.log(squares), half / squares[:, :, None]

    def of(self, chosen: Sequence[int]) -> Sampled:
        """The same worlds of fewer components."""
        at = np.asarray(chosen)
        return Sampled(np.ascontiguousarray(self.gram[:, :, at[:, None], at]))


@dataclass(frozen=True, eq=False)
class Fit:
    """Fitted sizes (c) beside those of the first fit; logs (f, t) of the figures in sampled worlds of these sizes."""

    first: Floats
    sizes: Floats
    target: Floats
    logs: Floats
    log_likelihood: float

    @property
    def inside(self) -> int:
        """How many published figures lie inside 95 % of the sampled worlds."""
        lo, hi = np.percentile(self.logs, RANGE, axis=1)
        return int(((self.target >= lo) & (self.target <= hi)).sum())


def sampled(rows: Sequence[LinearRow], components: Sequence[Component], draws: int, seed: int) -> Sampled:
    """Draw worlds of unit components and carry them through all adjustments."""
    world = rows[0].world
    errors = [_unit_errors(world, c, draws, seed) for c in components]
    grams = []
    for row in rows:
        carried = [row.carry(e, s) for e, s in errors]
        count = len(carried[0].deviations)
        plan = [p.deviations[:, :2].reshape(-1, draws) for p in carried]
        for parts, divisor in (
            ([p.v for p in carried], row.redundancy),
            (plan, count),
            ([p.deviations[:, 2] for p in carried], count),
        ):
            stacked = np.stack(parts).transpose(2, 0, 1)
            grams.append(stacked @ stacked.transpose(0, 2, 1) / divisor)
    return Sampled(np.array(grams))


def fit(published: Floats, expected: Floats, worlds: Sampled, components: Sequence[Component]) -> Fit:
    """Fit the sizes to published figures (f); expected (f, c) are the squares of unit components."""
    weight = 1.0 / (published**2 * np.tile(RELATIVE_OF_SQUARES, len(published) // 3))
    variances, _ = optimize.nnls(expected * weight[:, None], published**2 * weight)
    target = np.log(published)
    low, high = _bounds(components)
    sizes = _refined(target, worlds, np.full(len(components), 3.0), low, high)
    small = np.array([c.kind == "film" for c in components]) & (sizes < SMALLEST)
    sizes = _refined(target, worlds, np.where(small, 0.0, sizes), low, np.where(small, 0.0, high))
    sizes = np.round(sizes, 1)
    logs, _ = worlds.logs(sizes)
    return Fit(np.sqrt(variances), sizes, target, logs, -_cost(sizes, target, worlds, 0.0)[0])


def refitted(fitted: Fit, worlds: Sampled, components: Sequence[Component], count: int) -> Floats:
    """(count, c): sizes fitted again to the figures of sampled worlds with the fitted sizes (parametric bootstrap)."""
    low, high = _bounds(components)
    start = np.maximum(fitted.sizes, 0.3)
    return np.array([_refined(fitted.logs[:, t], worlds, start, low, high, 40) for t in range(count)])


def _bounds(components: Sequence[Component]) -> tuple[Floats, Floats]:
    low = np.array([NOISE_LEAST_UM if c.kind == "noise" else 0.0 for c in components])
    return low, np.array([GEODETIC_MOST_MM if c.kind == "geodetic" else MOST for c in components])


def _refined(target: Floats, worlds: Sampled, start: Floats, low: Floats, high: Floats, most: int = 300) -> Floats:
    free = np.flatnonzero(high > 0.0)
    part, bounds = worlds.of(free.tolist()), list(zip(low[free], high[free], strict=True))
    done = optimize.minimize(
        lambda s: _cost(s, target, part, TAIL_WEIGHT),
        np.clip(start, low, high)[free],
        jac=True,
        bounds=bounds,
        method="L-BFGS-B",
        options={"maxiter": most},
    )
    sizes = np.zeros(len(start))
    sizes[free] = done.x
    return sizes


def _cost(sizes: Floats, target: Floats, worlds: Sampled, tail: float) -> tuple[float, Floats]:
    """Minus the composite log-likelihood with the extra cost of the tails, and its gradient."""
    logs, slopes = worlds.logs(sizes)
    deviation = logs - logs.mean(axis=1)[:, None]
    sd = np.sqrt((deviation**2).mean(axis=1) + ROUNDING**2)
    z = (target - logs.mean(axis=1)) / sd
    excess = np.maximum(np.abs(z) - TAIL, 0.0)
    by_z = z + 2.0 * tail * excess * np.sign(z)
    by_sd = (1.0 - z * by_z) / sd
    by_log = (-by_z / sd)[:, None] + by_sd[:, None] * deviation / sd[:, None]
    gradient = np.einsum("ft,ftc->c", by_log, slopes) / logs.shape[1]
    return float(np.sum(0.5 * z**2 + np.log(sd) + tail * excess**2)), gradient


def _unit_errors(world: World, component: Component, draws: int, seed: int) -> tuple[Floats, Floats | None]:
    """Errors (2k, t) mm of the image coordinates and (3n, t) m of the given coordinates, of size 1."""
    random = stream(seed, "twin", str(component))
    images = np.zeros((2 * len(world.image), draws))
    if component.kind == "geodetic":
        return images, 1e-3 * random.standard_normal((3 * len(world.place), draws))
    if component.kind == "noise":
        own = np.repeat((np.array(world.plan.camera_ids) == component.camera)[world.image], 2)
        images[own] = 1e-3 * random.standard_normal((int(own.sum()), draws))
        return images, None
    fields = film_fields(world, component)
    return fields @ random.standard_normal((fields.shape[1], draws)), None
