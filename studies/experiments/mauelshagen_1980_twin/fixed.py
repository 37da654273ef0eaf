"""The fixed world: one deformation field a camera or flight, the same in every trial, with as few terms as do.

With coefficients b of the fields and variances of noise and survey, the expected square of a figure is b^T G b plus
what noise and survey add. Figures are brought near the published ones from several starts; then the smallest terms
are dropped, as long as as many figures as wanted stay near.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import optimize

from simfield import World
from simfield.block import Floats
from simfield.disturbances import DEGREES, REFERENCE_MM, EffectOn, FilmAffine, FilmPolynomial, film_monomials
from simfield.random import stream
from studies.experiments.mauelshagen_1980_twin.propagation import LinearRow

MONOMIALS = ("x", "y", "x2", "xy", "y2", "x3", "x2y", "xy2", "y3")
M0_WITHIN_UM, MU_WITHIN = 0.4, 0.2
TOLERANCE_M0_UM, TOLERANCE_MU = 0.3, 0.15
"""what the search counts as one unit of difference"""
KEEP_M0, KEEP_MU = 18, 30
"""how many figures have to stay near while terms are dropped"""
RIDGE = 0.05
"""small terms are preferred: a term of 10 um costs as much as five units of difference"""
LIMITS = ((2.0, 7.0), (2.0, 5.0), (0.0, 10.0))
"""of the noise of SWW and WW, um, and of the survey, mm"""


@dataclass(frozen=True, order=True)
class Term:
    """A monomial in dx or dy on a camera or a flight."""

    on: str
    axis: int
    monomial: int

    def __str__(self) -> str:
        return f"d{'xy'[self.axis]} {MONOMIALS[self.monomial]} on {self.on}"


@dataclass(frozen=True, eq=False)
class FixedWorld:
    """Terms with sizes, um at 100 mm; random: the noise of SWW and WW, um, and the survey, mm; figures (f) expected."""

    terms: tuple[Term, ...]
    sizes: Floats
    random: Floats
    figures: Floats
    published: Floats

    @property
    def near(self) -> tuple[int, int]:
        """How many m0 and how many mu are near the published ones."""
        return _near(self.figures, self.published)


def terms_of(world: World) -> tuple[Term, ...]:
    """Every term that the world may have."""
    plan = world.plan
    names = (*dict.fromkeys(plan.flight_ids), *dict.fromkeys(plan.camera_ids))
    return tuple(Term(on, axis, m) for on in names for axis in (0, 1) for m in range(len(MONOMIALS)))


def quadratic_forms(rows: Sequence[LinearRow], terms: Sequence[Term]) -> Floats:
    """(f, b, b): the matrices G of all figures."""
    fields = _fields(rows[0].world, terms)
    forms = []
    for row in rows:
        carried = row.carry(fields)
        count = len(carried.deviations)
        plan, height = carried.deviations[:, :2].reshape(-1, len(terms)), carried.deviations[:, 2]
        forms += [carried.v.T @ carried.v / row.redundancy, plan.T @ plan / count, height.T @ height / count]
    return np.array(forms)


def search(
    published: Floats, forms: Floats, random: Floats, terms: Sequence[Term], starts: int, seed: int
) -> FixedWorld:
    """The world with the fewest terms found; random (f, 3): squares of unit noise of SWW, WW and of the survey."""
    found = [_from_one_start(published, forms, random, terms, seed, start) for start in range(starts)]
    return max(found, key=lambda w: (w.near[0] >= KEEP_M0 and w.near[1] >= KEEP_MU, -len(w.terms), sum(w.near)))


def _from_one_start(
    published: Floats, forms: Floats, random: Floats, terms: Sequence[Term], seed: int, start: int
) -> FixedWorld:
    first = np.array([4.5, 3.0, 8.0])
    values = np.concatenate([first, 3.0 * stream(seed, "fixed world", start).standard_normal(len(terms))])
    kept = np.arange(len(terms))
    values = _nearest(values, published, forms, random)
    while len(kept) > 1:
        drop = np.argsort(np.abs(values[3:]))[: max(1, len(kept) // 8)]
        fewer, shorter = np.delete(kept, drop), np.delete(values, 3 + drop)
        shorter = _nearest(shorter, published, forms[:, fewer[:, None], fewer], random)
        m0, mu = _near(_figures(shorter, forms[:, fewer[:, None], fewer], random), published)
        if m0 < KEEP_M0 or mu < KEEP_MU:
            break
        kept, values = fewer, shorter
    values = np.round(values, 1)
    figures = _figures(values, forms[:, kept[:, None], kept], random)
    return FixedWorld(tuple(terms[k] for k in kept.tolist()), values[3:], values[:3], figures, published)


def _nearest(values: Floats, published: Floats, forms: Floats, random: Floats) -> Floats:
    bounds = [*LIMITS, *[(-15.0, 15.0)] * (len(values) - 3)]
    done = optimize.minimize(
        _cost, values, (published, forms, random), jac=True, bounds=bounds, method="L-BFGS-B", options={"maxiter": 400}
    )
    return np.asarray(done.x)


def _cost(values: Floats, published: Floats, forms: Floats, random: Floats) -> tuple[float, Floats]:
    b, s = values[3:], values[:3]
    half = forms @ b
    figures = np.sqrt(half @ b + random @ s**2)
    tolerance = np.where(_is_m0(published), TOLERANCE_M0_UM, TOLERANCE_MU * published)
    difference = (figures - published) / tolerance
    by_square = difference / tolerance / figures
    gradient = np.concatenate([2.0 * (by_square @ random) * s, 2.0 * (by_square @ half) + 2.0 * RIDGE * b])
    return float((difference**2).sum() + RIDGE * (b @ b)), gradient


def _figures(values: Floats, forms: Floats, random: Floats) -> Floats:
    return np.asarray(np.sqrt((forms @ values[3:]) @ values[3:] + random @ values[:3] ** 2))


def _is_m0(figures: Floats) -> npt.NDArray[np.bool_]:
    return np.asarray(np.arange(len(figures)) % 3 == 0)


def _near(figures: Floats, published: Floats) -> tuple[int, int]:
    m0 = _is_m0(published)
    difference = np.abs(figures - published)
    return int((difference <= M0_WITHIN_UM)[m0].sum()), int((difference <= MU_WITHIN * published)[~m0].sum())


def _fields(world: World, terms: Sequence[Term]) -> Floats:
    """(2k, b): the displacements, mm, of every term of 1 um at 100 mm."""
    flights, cameras = (np.array(ids)[world.image] for ids in (world.plan.flight_ids, world.plan.camera_ids))
    monomials = 1e-3 * film_monomials(world.distorted) / REFERENCE_MM ** np.array(DEGREES)
    fields = np.zeros((len(world.image), 2, len(terms)))
    for column, term in enumerate(terms):
        own = (flights == term.on) | (cameras == term.on)
        fields[own, term.axis, column] = monomials[own, term.monomial]
    return fields.reshape(-1, len(terms))


def effects_of(found: FixedWorld, world: World) -> tuple[EffectOn, ...]:
    """The terms as effects of a scenario, one field a camera or flight."""
    effects: list[EffectOn] = []
    for on in dict.fromkeys(term.on for term in found.terms):
        table = np.zeros((2, len(MONOMIALS)))
        for term, size in zip(found.terms, found.sizes, strict=True):
            if term.on == on:
                table[term.axis, term.monomial] = 1e-3 * size / REFERENCE_MM ** DEGREES[term.monomial]
        dx: Any
        dy: Any
        dx, dy = table.tolist()
        where = {"camera": on} if on in world.plan.camera_ids else {"flight": on}
        if any(dx[:2] + dy[:2]):
            effects.append(EffectOn(FilmAffine(*dx[:2], *dy[:2]), **where))
        if any(dx[2:] + dy[2:]):
            effects.append(EffectOn(FilmPolynomial(*dx[2:], *dy[2:]), **where))
    return tuple(effects)
