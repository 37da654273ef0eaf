"""Every set of additional parameters against its second form, which was typed from the source independently."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from adjust import ap_models
from tests.published import second_forms, second_forms_families
from tests.published.second_forms import Term

ROUNDING = 1e-12
"""Of the largest value of a term. The forms differ only in the order of their operations: a few rounding units of
2e-16 each, enlarged a little where powers cancel (r^6 - r0^6 near r0) - but relative to the term's size over the
format, not to its value near a zero. For spans it bounds the sine of the angle between a normalised term and the other
form's span, whose condition number is below 10 here."""

HALF_MM = 115.0


@dataclass(frozen=True)
class Second:
    """A second form; `renamed` gives its name for each setting of the product."""

    form: Callable[..., list[Term]]
    renamed: Mapping[str, str] = field(default_factory=dict)
    cases: tuple[Mapping[str, Any], ...] = ({},)
    """settings of the product"""
    named: bool = True
    """the source names the parameters"""
    span: bool = False
    """the source leaves the basis of the space open: compare the spaces"""

    def matrix(self, x: np.ndarray, y: np.ndarray, settings: Mapping[str, Any]) -> np.ndarray:
        """(k, 2, a), from one scalar call a point."""
        own = {self.renamed.get(name, name): value for name, value in settings.items()}
        rows = [self.form(float(px), float(py), **own) for px, py in zip(x, y, strict=True)]
        return np.array([[[dx for _, dx, _ in row], [dy for _, _, dy in row]] for row in rows])

    def names(self, settings: Mapping[str, Any]) -> tuple[str, ...]:
        own = {self.renamed.get(name, name): value for name, value in settings.items()}
        return tuple(name for name, _, _ in self.form(1.0, 2.0, **own))


def zernike_on_corners(x: float, y: float, *, order: int, bx: float, by: float) -> list[Term]:
    """The circle goes through the corners of the format."""
    return second_forms_families.zernike(x, y, order=order, radius=math.hypot(bx, by))


R0 = {"r0_mm": "r0"}
MAUELSHAGEN_1980 = ({}, {"as_printed": True}, {"r0_mm": 0.0}, {"r0_mm": 90.0, "as_printed": True})
PRODUCT = {"m": "M", "n": "N", "bx_mm": "bx", "by_mm": "by"}


def orders(*pairs: tuple[int, int], half: tuple[float, float] = (HALF_MM, HALF_MM)) -> tuple[dict[str, Any], ...]:
    return tuple({"m": m, "n": n, "bx_mm": half[0], "by_mm": half[1]} for m, n in pairs)


SECOND: dict[str, Second] = {
    "optical": Second(second_forms.optical, R0, MAUELSHAGEN_1980),
    "torlegard": Second(second_forms.torlegard, R0, MAUELSHAGEN_1980),
    "brown14": Second(second_forms.brown14, R0, MAUELSHAGEN_1980),
    "ebner12": Second(second_forms.ebner12, {"b_mm": "B"}, ({"b_mm": 90.0}, {"b_mm": 92.5})),
    "elhakim-faig11": Second(second_forms.elhakim_faig11),
    "gruen12": Second(second_forms.gruen12),
    "koelbl-juhl9": Second(second_forms.koelbl_juhl9, R0, ({}, {"r0_mm": 140.0})),
    "mauelshagen14": Second(second_forms.mauelshagen14),
    "schut14": Second(second_forms.schut14),
    "salmenpera-kilpela7": Second(second_forms.salmenpera_kilpela7, R0, ({"r0_mm": 100.0}, {"r0_mm": 85.0})),
    "gruen44": Second(second_forms.gruen44, {"b_mm": "b"}, ({"b_mm": 90.0}, {"b_mm": 92.5})),
    "brown1971": Second(second_forms.brown1971, {"c_mm": "c"}, ({"c_mm": 153.0}, {"c_mm": 85.5})),
    "brown1976": Second(second_forms.brown1976, {"c_mm": "c"}, ({"c_mm": 153.0}, {"c_mm": 85.5})),
    "jacobsen12": Second(second_forms.jacobsen12, named=False),
    "legendre": Second(
        second_forms_families.legendre, PRODUCT, orders((2, 2), (3, 3), (4, 4), (2, 4), (5, 5)), named=False, span=True
    ),
    "fourier": Second(
        second_forms_families.fourier,
        PRODUCT,
        orders((1, 1), (2, 2), (2, 1)) + orders((1, 1), half=(115.0, 80.0)),
        named=False,
        span=True,
    ),
    "chebyshev": Second(
        second_forms_families.chebyshev, PRODUCT, orders((2, 2), (3, 3), (4, 4), (2, 4)), named=False, span=True
    ),
    "zernike": Second(
        zernike_on_corners,
        {"n": "order", "bx_mm": "bx", "by_mm": "by"},
        tuple({"n": n, "bx_mm": HALF_MM, "by_mm": by} for n, by in ((2, HALF_MM), (3, HALF_MM), (4, 80.0))),
        named=False,
        span=True,
    ),
}

CASES = [
    pytest.param(model_id, settings, id="-".join([model_id, *(f"{k}={v}" for k, v in settings.items())]))
    for model_id in ap_models.names()
    if model_id in SECOND
    for settings in SECOND[model_id].cases
]


def points() -> tuple[np.ndarray, np.ndarray]:
    """200 random points over the format, and its centre."""
    xy = np.random.default_rng(1980).uniform(-HALF_MM, HALF_MM, (200, 2))
    return np.append(xy[:, 0], 0.0), np.append(xy[:, 1], 0.0)


def product_matrix(model: ap_models.ApModel, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(k, 2, a), point by point as the second form."""
    return np.concatenate(
        [model.basis(np.array([px]), np.array([py])) for px, py in zip(x, y, strict=True)],
    )


def outside(terms: np.ndarray, span: np.ndarray) -> float:
    """The largest part of a normalised term (column) that does not lie in the span."""
    q, _ = np.linalg.qr(span)
    return float(np.linalg.norm(terms - q @ (q.T @ terms), axis=0).max())


@pytest.mark.parametrize(("model_id", "settings"), CASES)
def test_set_equals_its_second_form(model_id: str, settings: dict[str, Any]) -> None:
    second = SECOND[model_id]
    model = ap_models.get(model_id, **settings)
    x, y = points()
    ours, theirs = product_matrix(model, x, y), second.matrix(x, y, settings)

    assert ours.shape == theirs.shape
    if second.named:
        assert model.parameters == second.names(settings)
    if not second.span:
        size = np.abs(theirs).max(axis=(0, 1))
        wrong = np.abs(ours - theirs).max(axis=(0, 1)) / size
        assert wrong.max() <= ROUNDING, dict(zip(model.parameters, wrong, strict=True))
        return
    a, b = (m.reshape(-1, m.shape[2]) for m in (ours, theirs))
    a, b = a / np.linalg.norm(a, axis=0), b / np.linalg.norm(b, axis=0)
    assert np.linalg.matrix_rank(a) == np.linalg.matrix_rank(b) == a.shape[1]
    assert outside(a, b) <= ROUNDING
    assert outside(b, a) <= ROUNDING


@pytest.mark.parametrize("model_id", [name for name in ap_models.names() if name in {"legendre", "chebyshev"}])
def test_products_on_a_rectangular_format_equal_beside_the_orientation(model_id: str) -> None:
    """Where bx != by the source's (x, -y), (y, x) are not orthogonal to (x, y), (y, -x), as it says the set is.

    The second form keeps them literally, the product keeps the orthogonality: the spaces agree only together with the
    six orientation effects, which is what an adjustment sees.
    """
    (settings,) = orders((3, 3), half=(HALF_MM, 80.0))
    x, y = points()
    zero, one = np.zeros_like(x), np.ones_like(x)
    effects = np.array([[one, zero, x, y, x * x, x * y], [zero, one, y, -x, x * y, y * y]]).transpose(2, 0, 1)
    ours, theirs = product_matrix(ap_models.get(model_id, **settings), x, y), SECOND[model_id].matrix(x, y, settings)
    a, b = (np.concatenate([m, effects], axis=2).reshape(2 * x.size, -1) for m in (ours, theirs))
    a, b = a / np.linalg.norm(a, axis=0), b / np.linalg.norm(b, axis=0)
    assert np.linalg.matrix_rank(a) == np.linalg.matrix_rank(b) == a.shape[1]
    assert outside(a, b) <= ROUNDING
    assert outside(b, a) <= ROUNDING


def test_every_set_has_a_second_form() -> None:
    assert set(ap_models.names()) - {"none"} <= set(SECOND)
