"""Many trials of one block: an error-free block, noise on it, and the tests' statistics in every trial."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from adjust import Adjustment, ApModel, adjust_block
from adjust.observations.observations import Observations
from adjust.quality.reliability import Reliability
from adjust.trials.replicates import adjust_replicates
from simfield.block.block import Block, Floats

STANDARD_ERRORS = 3.0


def error_free(block: Block, model: ApModel) -> Block:
    """The block as it would have been measured without errors, if its own adjustment were the truth."""
    for _ in range(4):
        a = adjust_block(block, model)
        assert a.status.ok, a.message
        block = block.replace_image_points(block.observations.xy + a.residuals)
    return block


def noise(block: Block, trials: int, rng: np.random.Generator) -> Floats:
    """(t, k, 2) image coordinates with normal errors as the block states them."""
    o = block.observations
    return np.asarray(o.xy + o.sigma * rng.standard_normal((trials, *o.xy.shape)))


@dataclass(frozen=True, eq=False)
class Repeated:
    """Trials of one geometry: the corrections of all observations in standard deviations (t, n), sigma0 (t), x (t,
    size), and the reliability of the block without errors."""

    reliability: Reliability
    standard: Floats
    sigma0: Floats
    x: Floats
    image_points: Floats

    @property
    def w(self) -> Floats:
        """(t, n)."""
        return np.asarray(self.standard / np.sqrt(self.reliability.redundancy))

    @property
    def tau(self) -> Floats:
        return np.asarray(self.w / self.sigma0[:, None])

    def adjustments(self) -> Iterator[Adjustment]:
        """Every trial as an adjustment of its own, its estimate taken over."""
        nominal = self.reliability.influence.adjustment
        for x, xy in zip(self.x, self.image_points, strict=True):
            block = nominal.block.replace_image_points(xy)
            layout = replace(nominal.layout, block=block)
            groups = Observations.of(block, layout)
            yield replace(
                nominal, block=block, layout=layout, groups=groups, x=x, arithmetic=type(nominal.arithmetic)(groups)
            )


def repeat(block: Block, model: ApModel, image_points: Floats) -> Repeated:
    """Adjust all trials; every one must converge."""
    found = adjust_replicates(block, model, image_points)
    assert found.ok.all()
    nominal = found.nominal
    standard = np.empty((len(image_points), 2 * len(block.observations)))
    for trial, xy in enumerate(image_points):
        groups = Observations.of(block.replace_image_points(xy), nominal.layout)
        v, _ = groups.image_points.residuals(found.trials.x[trial])
        ordered = np.empty_like(v)
        ordered[groups.image_points.order] = v
        standard[trial] = (ordered / block.observations.sigma).ravel()
    return Repeated(Reliability.of(nominal), standard, found.sigma0, found.trials.x, image_points)


def assert_rate(rejected: Floats, level: float | Floats) -> None:
    """The mean over trials and tests of rejected (t, ...) is `level` within three standard errors; trials are the
    sample.
    """
    expected = np.broadcast_to(level, rejected.shape[1:]).mean() if rejected.ndim > 1 else float(np.mean(level))
    share = rejected.reshape(len(rejected), -1).mean(axis=1)
    binomial = np.sqrt(expected * (1.0 - expected) / rejected.size)
    standard_error = max(share.std(ddof=1) / np.sqrt(len(share)), 0.5 * binomial)
    assert abs(share.mean() - expected) <= STANDARD_ERRORS * standard_error, (share.mean(), expected, standard_error)
