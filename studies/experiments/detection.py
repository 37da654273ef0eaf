"""How often gross errors are found: size and power of data snooping in a block, beside Baarda's theory.

In every trial one image coordinate is wrong by a stated number of its standard deviations, all others have normal
errors. It is found when it is accused, missed when nobody is, and another is wrongly accused when the largest |w| is
not its own.
Theory: with the shift s sqrt(r) of its standardised residual, the power of its own test (Baarda 1968).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.special import ndtr

from adjust import ApModel, adjust_block
from adjust.observations import Observations
from adjust.quality import (
    ALPHA,
    LEAST_CHECKED,
    LEVEL,
    POWER,
    Cauchy,
    Danish,
    Huber,
    Inspection,
    Reliability,
    familywise,
    inspected,
    robust,
    snoop,
    w_critical,
)
from adjust.trials import adjust_replicates
from simfield.block import Block, Floats

SIZES = (0.0, 4.0, 6.0, 8.0, 12.0, 16.0, 20.0)
SEARCHED = {"clean block, anybody accused": LEVEL, "wrong, its test above": POWER, "wrong, accused": np.nan}
"""what the search of a block is asked, and the share that the protocol promises"""


@dataclass(frozen=True)
class Share:
    """A share of n trials with its Monte-Carlo standard error (that of Agresti and Coull, which is never 0)."""

    hits: int
    n: int

    @property
    def value(self) -> float:
        return self.hits / self.n

    @property
    def mcse(self) -> float:
        p = (self.hits + 2.0) / (self.n + 4.0)
        return float(np.sqrt(p * (1.0 - p) / (self.n + 4.0)))


def error_free(block: Block, model: ApModel, rounds: int = 4) -> Block:
    """The block as measured without errors, if its own adjustment were the truth. Raises ValueError if it has none."""
    for _ in range(rounds):
        a = adjust_block(block, model)
        if not a.status.ok:
            raise ValueError(f"the block cannot be adjusted: {a.message}")
        block = block.replace_image_points(block.observations.xy + a.residuals)
    return block


def detection(
    block: Block, model: ApModel, trials: int, seed: int, sizes: Sequence[float] = SIZES, alpha: float = ALPHA
) -> pd.DataFrame:
    """One row a size: found, missed, wrongly accused, the power of the test of the wrong coordinate and that of theory,
    and the rate of false alarms among all right coordinates with its level."""
    block = error_free(block, model)
    nominal = Reliability.of(adjust_block(block, model), alpha)
    return pd.DataFrame([_row(block, model, nominal, size, trials, seed) for size in sizes])


def _row(block: Block, model: ApModel, nominal: Reliability, size: float, trials: int, seed: int) -> dict[str, float]:
    o, critical = block.observations, w_critical(nominal.alpha)
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(round(1000 * size),)))
    rows = rng.integers(o.xy.size, size=trials)
    sign = rng.choice([-1.0, 1.0], trials)
    xy = o.xy + o.sigma * rng.standard_normal((trials, *o.xy.shape))
    xy.reshape(trials, -1)[np.arange(trials), rows] += sign * size * o.sigma.ravel()[rows]
    own, largest, first, false = (np.array(each) for each in zip(*_tests(block, model, nominal, xy, rows), strict=True))
    shift = size * np.sqrt(nominal.redundancy[nominal.image_points][rows])
    rate, among = false / (o.xy.size - 1), Share(int(np.sum(own > critical)), trials)
    outcome = {
        "found": (first == rows) & (largest > critical),
        "missed": largest <= critical,
        "wrongly_accused": (first != rows) & (largest > critical),
    }
    shares = {name: Share(int(np.sum(hits)), trials) for name, hits in outcome.items()}
    return {
        "size_sigma": size,
        "trials": float(trials),
        **{key: part for name, s in shares.items() for key, part in ((name, s.value), (f"{name}_mcse", s.mcse))},
        "power": among.value,
        "power_mcse": among.mcse,
        "power_theory": float(np.mean(ndtr(shift - critical) + ndtr(-shift - critical))),
        "false_alarms": float(rate.mean()),
        "false_alarms_mcse": float(rate.std(ddof=1) / np.sqrt(trials)),
        "level": nominal.alpha,
    }


def _tests(
    block: Block, model: ApModel, nominal: Reliability, xy: Floats, rows: np.typing.NDArray[np.intp]
) -> Iterator[tuple[float, float, int, int]]:
    """Of every trial: |w| of the wrong coordinate, the largest |w| and whose it is, and the false alarms."""
    found = adjust_replicates(block, model, xy)
    root = np.sqrt(nominal.redundancy[nominal.image_points]) * block.observations.sigma.ravel()
    for trial, wrong in enumerate(rows):
        groups = Observations.of(block.replace_image_points(xy[trial]), found.nominal.layout).image_points
        v, _ = groups.residuals(found.trials.x[trial])
        ordered = np.empty_like(v)
        ordered[groups.order] = v
        w = np.abs(ordered.ravel()) / root
        above = w > w_critical(nominal.alpha)
        yield float(w[wrong]), float(w.max()), int(w.argmax()), int(above.sum() - above[wrong])


def search_of_blocks(blocks: Iterable[Block], model: ApModel, seed: int) -> pd.DataFrame:
    """The search of the protocol in blocks with the errors that they have, which need not be those that are stated.

    In each block as it is, and once more with one image coordinate, chosen at random, wrong by the minimal detectable
    bias that the protocol prints for it. A row each for anybody accused in a clean block, for the test of the wrong
    coordinate above its critical value, and for this coordinate accused: how many blocks, the share with its
    Monte-Carlo standard error, and the share that is promised, NaN where none is. Raises ValueError for a block that
    cannot be adjusted.
    """
    alpha: float | None = None
    counts = dict.fromkeys(SEARCHED, 0)
    n = 0
    for n, block in enumerate(blocks, start=1):
        random = np.random.default_rng([seed, n])
        clean = _inspected(block, model, alpha)
        alpha, mdb = clean.alpha, clean.reliability.mdb[clean.reliability.image_points]
        row = int(
            random.choice(np.flatnonzero(clean.reliability.redundancy[clean.reliability.image_points] > LEAST_CHECKED))
        )
        xy = block.observations.xy.copy()
        xy.ravel()[row] += random.choice([-1.0, 1.0]) * mdb[row]
        wrong = _inspected(block.replace_image_points(xy), model, alpha)
        own_test = wrong.tests[wrong.reliability.image_points][row]
        hits = (len(clean.suspected) > 0, own_test > 1.0, row in wrong.suspected)
        counts = {name: count + bool(hit) for (name, count), hit in zip(counts.items(), hits, strict=True)}
    rows = [(name, Share(counts[name], n), stated) for name, stated in SEARCHED.items()]
    return pd.DataFrame(
        [{"outcome": name, "n": s.n, "share": s.value, "share_mcse": s.mcse, "stated": p} for name, s, p in rows]
    )


def _inspected(block: Block, model: ApModel, alpha: float | None) -> Inspection:
    a = adjust_block(block, model)
    if not a.status.ok:
        raise ValueError(f"the block cannot be adjusted: {a.message}")
    return inspected(a, alpha=alpha)


def many_at_once(
    block: Block, model: ApModel, share: float, trials: int, seed: int, level: float = 0.05
) -> pd.DataFrame:
    """Data snooping one by one against robust estimation of all at once: a share of all coordinates is wrong by 6 to 20
    standard deviations. One row a method: the share of wrong ones found and of right ones accused, with the Monte-Carlo
    standard errors over trials, and the rms of the errors left in the points, m. `level` is that of all tests."""
    block = error_free(block, model)
    truth = adjust_block(block, model).coordinates
    rows = [row for trial in range(trials) for row in _contest(block, model, truth, share, level, (seed, trial))]
    columns = ("found", "accused_wrongly", "point_rms_m")
    frame = pd.DataFrame(rows, columns=["method", *columns]).groupby("method", sort=False)[list(columns)]
    return pd.concat([frame.mean(), frame.sem().add_suffix("_mcse")], axis=1).reset_index()


def _contest(
    block: Block, model: ApModel, truth: Floats, share: float, level: float, key: tuple[int, int]
) -> Iterator[tuple[str, float, float, float]]:
    o = block.observations
    rng = np.random.default_rng(key)
    wrong = rng.random(o.xy.shape) < share
    size = rng.choice([-1.0, 1.0], wrong.shape) * rng.uniform(6.0, 20.0, wrong.shape)
    a = adjust_block(
        block.replace_image_points(o.xy + o.sigma * (rng.standard_normal(wrong.shape) + wrong * size)), model
    )
    alpha = familywise(level, a.observations)
    snooped = snoop(a, alpha, most=wrong.size // 3)
    answers = {"none": (a, []), "data snooping": (snooped.adjustment, [each.row for each in snooped.accused])}
    for function in (Huber(), Danish(), Cauchy()):
        answer = robust(a, function, alpha)
        answers[type(function).__name__] = (answer.adjustment, [each.row for each in answer.suspects])
    for name, (adjusted, accused) in answers.items():
        hit = np.zeros(wrong.size, dtype=bool)
        hit[accused] = True
        found, false = hit[wrong.ravel()].mean(), hit[~wrong.ravel()].mean()
        yield name, float(found), float(false), float(np.sqrt(np.mean((adjusted.coordinates - truth) ** 2)))
