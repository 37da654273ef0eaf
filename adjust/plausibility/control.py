"""Control and stations against each other and against the images, each without the other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from adjust.adjustment import Adjustment
from adjust.ap_models import ApModel
from adjust.bundle import adjust_block
from adjust.datum import InnerConstraints
from adjust.model import Similarity
from adjust.plausibility.finding import Finding, listed
from simfield.block import Block, Floats, Indices, Points

SUSPICIOUS = 1.5
"""sigma0 from which control is looked at; below, it fits"""
FEWEST_CONTROL, FEWEST_STATIONS = 4, 3
TRIPLES_MOST = 200
OBSERVATIONS_MOST = 200_000
"""beyond, adjusting again and again takes longer than anybody waits"""
BEYOND = 6.0
"""robust standard deviations by which a control point fails to fit"""
LEFT_OUT_MOST = 30
"""control points up to which each is left out in turn"""
ALONE_EXPLAINS = 0.5
"""of sigma0 that is left without the control point that is wrong"""
CLEAR = 5.0
"""standard errors of their mean by which stations are off"""


def findings(a: Adjustment) -> Iterator[Finding]:
    """Of an adjustment that failed or whose observations contradict each other; nothing of one that fits."""
    if (a.status.ok and a.sigma0 < SUSPICIOUS) or a.observations > OBSERVATIONS_MOST:
        return
    if a.regular is not a:  # a free network holds no control that could contradict anything
        return
    stations = list(_stations(a))
    yield from stations
    if not stations:
        yield from _control(a)


def _stations(a: Adjustment) -> Iterator[Finding]:
    """Observed positions against an adjustment without them."""
    s, p = a.block.further.stations, a.block.points
    seen = np.isfinite(s.position).all(axis=1) if len(s) else np.zeros(0, dtype=bool)
    if seen.sum() < FEWEST_STATIONS or (p.fixed | p.weighted).all(axis=1).sum() < 3:
        return
    alone = adjust_block(a.block.without("stations"), _model(a))
    if not alone.status.ok:
        return
    off = s.position[seen] - alone.exterior[s.image[seen], :3]
    mean, error = np.median(off, axis=0), off.std(axis=0, ddof=1) / np.sqrt(len(off))
    sigma = np.median(s.sigma_position[seen], axis=0)
    clear = np.abs(mean) > CLEAR * np.hypot(error, sigma / np.sqrt(len(off)))
    clear &= np.abs(mean) > 2.0 * sigma
    if not clear.any() or alone.sigma0 > 0.7 * a.sigma0:
        return
    said = ", ".join(
        f"{value:+.3g} m in {axis}" for value, axis, c in zip(mean, ("X0", "Y0", "Z0"), clear, strict=True) if c
    )
    yield Finding(
        "stations against control",
        "worthless",
        f"{int(seen.sum())} observed stations and {int((p.role == 'control').sum())} control points",
        f"the stations are off by {said} from where control puts the images, all alike; without them sigma0 is "
        f"{alone.sigma0:.3g} instead of {a.sigma0:.3g}",
        "check the datum of both (ellipsoid and geoid, antenna and projection centre), or ask for an offset: "
        "position_bias offset in strips.csv; do not throw control away",
    )


def _model(a: Adjustment) -> ApModel | None:
    """One of the models of the adjustment, for all cameras: which set follows a lens is not the question here."""
    return a.layout.sets[0].model if a.layout.sets else None


@dataclass(frozen=True, eq=False)
class _Free:
    """Control points numbered in the block (k), where the images alone put them (k, 3), and as given (k, 3)."""

    at: Indices
    free: Floats
    given: Floats

    def misfit(self, chosen: Indices, given: Floats | None = None) -> Floats:
        """(k) m: distances after the similarity that brings the chosen ones nearest."""
        given = self.given if given is None else given
        moved = Similarity.between(self.free[chosen], given[chosen]).points(self.free)
        return np.asarray(np.linalg.norm(moved - given, axis=1))

    def all_but_one(self) -> tuple[Indices, float] | None:
        """All but the one without which the others agree, and their rms, m; None where no single one explains it."""
        k = len(self.at)
        sets = [np.delete(np.arange(k), i) for i in range(k)]
        rms = np.array([np.sqrt(np.mean(self.misfit(each)[each] ** 2)) for each in sets])
        best, second = np.argsort(rms)[:2]
        everyone = np.sqrt(np.mean(self.misfit(np.arange(k)) ** 2))
        clear = rms[best] < ALONE_EXPLAINS * min(rms[second], everyone)
        return (sets[best], float(rms[best])) if clear else None

    def fitting(self) -> tuple[Indices, float]:
        """Those that agree best with each other, and their rms, m: least median of squares over triples."""
        k = len(self.at)
        triples = list(combinations(range(k), 3))
        if len(triples) > TRIPLES_MOST:
            chosen = np.random.default_rng(1984).choice(len(triples), TRIPLES_MOST, replace=False)
            triples = [triples[i] for i in chosen]
        best = min((np.array(t) for t in triples), key=lambda t: float(np.median(self.misfit(t))))
        for _ in range(3):
            misfit = self.misfit(best)
            scale = 1.4826 * float(np.median(misfit)) * (1.0 + 5.0 / max(k - 3, 1))
            best = np.flatnonzero(misfit <= max(BEYOND * scale / 2.0, np.sort(misfit)[2]))
        return best, float(np.sqrt(np.mean(self.misfit(best)[best] ** 2)))


def _control(a: Adjustment) -> Iterator[Finding]:
    """One point that explains everything, else what the block without control says, else those that might."""
    alone = _explaining_alone(a)
    if len(alone) == 1:
        yield _left_out(a, alone)
        return
    found = list(_against_free_network(a))
    yield from found
    if not found and alone:
        yield _left_out(a, alone)


def _explaining_alone(a: Adjustment) -> dict[str, float]:
    """Control points without any one of which all others fit, with the sigma0 that is left, the best first."""
    p = a.block.points
    control = [p.ids[i] for i in np.flatnonzero((p.role == "control") & np.isfinite(p.coordinates).all(axis=1))]
    if not a.status.ok or not FEWEST_CONTROL <= len(control) <= LEFT_OUT_MOST:
        return {}
    left = {}
    for name in control:
        without = adjust_block(a.block.select(points=[each for each in p.ids if each != name]), _model(a))
        left[name] = without.sigma0 if without.status.ok else np.inf
    least = min(left.values())
    if least > ALONE_EXPLAINS * a.sigma0:
        return {}
    return {name: s for name, s in sorted(left.items(), key=lambda each: each[1]) if s < max(2.0 * least, SUSPICIOUS)}


def _left_out(a: Adjustment, alone: dict[str, float]) -> Finding:
    s = next(iter(alone.values()))
    said = "no other control point explains that alone" if len(alone) == 1 else "which of them, the block cannot tell"
    return Finding(
        "coordinates",
        "worthless",
        f"control {listed(alone)}",
        f"without {'it' if len(alone) == 1 else 'any one of them'} sigma0 is {s:.3g} instead of {a.sigma0:.3g}; {said}",
        "check its name and its coordinates, digit by digit",
    )


def _against_free_network(a: Adjustment) -> Iterator[Finding]:
    free = _free_network(a)
    if free is None:
        return
    good, rms = free.all_but_one() or free.fitting()
    if len(good) < 3:
        return
    misfit = free.misfit(good)
    bad = np.array(
        [i for i in range(len(free.at)) if i not in good and misfit[i] > BEYOND * max(rms, 1e-6)], dtype=np.intp
    )
    ids, pairs = a.block.points.ids, []
    for i, j in combinations(bad, 2):
        swapped = free.given.copy()
        swapped[[i, j]] = free.given[[j, i]]
        if free.misfit(good, swapped)[[i, j]].max() < BEYOND * max(rms, 1e-6) * 2.0:
            pairs.append((i, j))
            yield Finding(
                "names exchanged",
                "worthless",
                f"points {ids[free.at[i]]} and {ids[free.at[j]]}",
                f"the images put each where the other is given, {misfit[i]:.4g} m away",
                "exchange the names of the points, in points.csv or in observations.csv",
            )
    rest = [i for i in bad if not any(i in pair for pair in pairs)]
    if not rest or 2 * len(rest) > len(free.at):
        return
    where = Similarity.between(free.free[good], free.given[good]).points(free.free)
    worst = max(rest, key=lambda i: misfit[i])
    off = free.given[worst] - where[worst]
    yield Finding(
        "coordinates",
        "worthless",
        f"control {listed(ids[free.at[i]] for i in rest)}",
        f"{len(rest)} of {len(free.at)} control points do not fit the others, which agree to {rms:.3g} m in the block "
        f"without control: {ids[free.at[worst]]} is given {off[0]:+.4g}, {off[1]:+.4g}, {off[2]:+.4g} m off",
        "check its name and its coordinates, digit by digit",
    )


def _free_network(a: Adjustment) -> _Free | None:
    """The block without control; None where it cannot be adjusted, or has too little control to compare."""
    block: Block = a.block.without()
    p = block.points
    control = np.flatnonzero((p.role == "control") & np.isfinite(p.coordinates).all(axis=1) & (block.rays >= 2))
    if len(control) < FEWEST_CONTROL:
        return None
    role, coordinates, sigma = np.array(p.role), p.coordinates.copy(), p.sigma.copy()
    role[role == "control"] = "tie"
    coordinates[control] = sigma[control] = np.nan
    loose = replace(block, points=Points(p.ids, role, coordinates, sigma))
    found = adjust_block(loose, _model(a), datum=InnerConstraints())
    if not found.status.ok or found.sigma0 > 3.0:
        return None
    return _Free(control, found.coordinates[control], p.coordinates[control])
