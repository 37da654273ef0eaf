"""The claims that are made for the published sets, each by computation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest

from adjust import ap_models
from adjust.ap_models import properties
from adjust.ap_models.catalogue.elhakim_faig import ElHakimFaig11, harmonics
from adjust.ap_models.terms import Term
from simfield.block.block import Floats

ROUNDING = 1e-12
ONE_PER_CENT = 0.01


def gram(columns: Floats) -> Floats:
    return columns.T @ columns


# --- orthogonality ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("b", [60.0, 90.0, 92.0])
def test_ebner_is_orthogonal_on_three_by_three_also_to_the_orientation(b: float):
    x, y = (a.ravel() for a in np.meshgrid([-b, 0, b], [-b, 0, b]))
    terms = ap_models.get("ebner12", b_mm=b).basis(x, y).reshape(18, 12)
    effects = properties.orientation_effects(x, y).reshape(18, 6)
    terms, effects = (m / np.linalg.norm(m, axis=0) for m in (terms, effects))
    np.testing.assert_allclose(gram(terms), np.eye(12), atol=ROUNDING)
    np.testing.assert_allclose(effects.T @ terms, 0, atol=ROUNDING)


@pytest.mark.parametrize("b", [60.0, 90.0, 115.0])
def test_gruen44_is_orthogonal_on_five_by_five_also_to_the_orientation(b: float):
    positions = [-b, -b / 2, 0, b / 2, b]
    x, y = (a.ravel() for a in np.meshgrid(positions, positions))
    terms = ap_models.get("gruen44", b_mm=b).basis(x, y).reshape(50, 44)
    effects = properties.orientation_effects(x, y).reshape(50, 6)
    terms, effects = (m / np.linalg.norm(m, axis=0) for m in (terms, effects))
    np.testing.assert_allclose(gram(terms), np.eye(44), atol=ROUNDING)
    np.testing.assert_allclose(effects.T @ terms, 0, atol=ROUNDING)


def test_gruen44_and_the_orientation_fill_all_50_coordinates_of_the_five_by_five_grid():
    model = ap_models.get("gruen44")
    columns = properties.with_orientation(model, *properties.product_grid(model.orthogonal_on_mm))
    assert columns.shape == (50, 50)
    assert np.linalg.matrix_rank(columns) == 50


def weighted(positions: Floats, weights: Floats, bx: float, by: float) -> tuple[Floats, Floats, Floats]:
    """Points of a product quadrature over the format and the square roots of their weights."""
    u, v = np.meshgrid(positions, positions)
    return bx * u.ravel(), by * v.ravel(), np.sqrt(np.outer(weights, weights)).ravel()


@pytest.mark.parametrize(
    ("set_id", "quadrature"),
    [("legendre", np.polynomial.legendre.leggauss), ("chebyshev", np.polynomial.chebyshev.chebgauss)],
)
@pytest.mark.parametrize(("bx", "by"), [(115.0, 115.0), (50.0, 80.0)])
def test_products_are_orthogonal_over_the_format_under_their_weight(set_id, quadrature, bx: float, by: float):
    x, y, root = weighted(*quadrature(12), bx, by)
    model = ap_models.get(set_id, m=4, n=3, bx_mm=bx, by_mm=by)
    terms = (model.basis(x, y) * root[:, None, None]).reshape(2 * x.size, -1)
    effects = (properties.orientation_effects(x, y) * root[:, None, None]).reshape(2 * x.size, 6)
    terms, effects = (m / np.linalg.norm(m, axis=0) for m in (terms, effects))
    np.testing.assert_allclose(gram(terms), np.eye(terms.shape[1]), atol=ROUNDING)
    np.testing.assert_allclose(effects.T @ terms, 0, atol=ROUNDING)


def test_legendre_is_nearly_orthogonal_on_a_dense_even_grid():
    assert max(properties.largest_cosines(ap_models.get("legendre"), *properties.grid(115.0, 201))) < 0.03


def test_zernike_is_orthogonal_on_its_circle():
    model = ap_models.get("zernike", n=5, bx_mm=115.0, by_mm=80.0)
    t, w = np.polynomial.legendre.leggauss(12)
    rho, lam = np.meshgrid((t + 1) / 2 * np.hypot(115.0, 80.0), 2 * np.pi * np.arange(24) / 24)
    root = np.sqrt(rho * w).ravel()
    x, y = (rho * np.cos(lam)).ravel(), (rho * np.sin(lam)).ravel()
    terms = (model.basis(x, y) * root[:, None, None]).reshape(2 * x.size, -1)
    effects = (properties.orientation_effects(x, y) * root[:, None, None]).reshape(2 * x.size, 6)
    terms, effects = (m / np.linalg.norm(m, axis=0) for m in (terms, effects))
    np.testing.assert_allclose(gram(terms), np.eye(terms.shape[1]), atol=ROUNDING)
    np.testing.assert_allclose(effects.T @ terms, 0, atol=ROUNDING)


def test_fourier_terms_are_orthogonal_over_their_period():
    x, y = (a.ravel() for a in np.meshgrid(np.arange(-10, 10) * 11.5, np.arange(-10, 10) * 8.0))
    model = ap_models.get("fourier", m=2, n=3, bx_mm=115.0, by_mm=80.0)
    assert properties.largest_cosines(model, x, y)[0] < ROUNDING


# --- the same space --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (ap_models.get("gruen12"), ap_models.get("ebner12")),
        (ap_models.get("legendre", m=2, n=2), ap_models.get("ebner12")),
        (ap_models.get("legendre", m=4, n=4), ap_models.get("gruen44")),
        (ap_models.get("legendre", m=4, n=4, bx_mm=60.0, by_mm=115.0), ap_models.get("gruen44")),
        (ap_models.get("chebyshev", m=3, n=5), ap_models.get("legendre", m=3, n=5)),
        (ap_models.get("zernike", n=3), ap_models.get("mauelshagen14")),
    ],
    ids=lambda model: model.id,
)
def test_two_sets_span_the_same_beside_the_orientation(one, other):
    assert len(one.parameters) == len(other.parameters)
    assert properties.span_gap(one, other) < ROUNDING


def test_different_sets_do_not_span_the_same():
    assert properties.span_gap(ap_models.get("schut14"), ap_models.get("mauelshagen14")) > 0.1
    assert properties.span_gap(ap_models.get("gruen12"), ap_models.get("gruen44")) == 1.0


# --- independence of the orientation ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class WrongPrefix(ElHakimFaig11):
    """The misreading of the scan: x q instead of (x/r) q."""

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        return [(x, -y), (y, x), *((x * q, y * q) for q in harmonics(x, y))]


def test_elhakim_faig_is_singular_with_the_wrong_prefix():
    wrong, right = WrongPrefix(), ap_models.get("elhakim-faig11")
    assert properties.independence(wrong) > 0.1, "its terms among themselves are not the trouble"
    assert properties.independence_of_orientation(wrong) < ROUNDING
    assert properties.independence_of_orientation(wrong, ("a3", "a4")) > 0.01, "a3 and a4 are"
    assert properties.independence_of_orientation(right) > 0.01


def test_the_wrong_prefix_turns_a3_and_a4_into_phi_and_omega():
    x, y = properties.grid()
    effects = properties.orientation_effects(x, y)
    np.testing.assert_allclose(WrongPrefix().basis(x, y)[:, :, 2:4], effects[:, :, 4:6], atol=1e-9)


def test_each_orientation_effect_is_what_its_name_says():
    """The differences of a projection of flat ground by a vertical image, up to a scale and constants."""
    c, h = 153.0, 1500.0
    x, y = properties.grid(100.0, 5)
    X, Y = x * h / c, y * h / c

    def project(X0=0.0, Y0=0.0, Z0=0.0, kappa=0.0, phi=0.0, omega=0.0):
        R = np.eye(3) + np.array([[0, -kappa, phi], [kappa, 0, -omega], [-phi, omega, 0]])
        p = np.stack([X - X0, Y - Y0, np.full_like(X, -h - Z0)], axis=1) @ R
        return np.stack([-c * p[:, 0] / p[:, 2], -c * p[:, 1] / p[:, 2]], axis=1)

    effects = properties.orientation_effects(x, y)
    constants = effects[:, :, :2].reshape(-1, 2)
    for j, name in enumerate(properties.ORIENTATION_EFFECTS):
        step = 1e-3 if name.endswith("0") else 1e-6
        moved = (project(**{name: step}) - project(**{name: -step})).ravel()
        columns = np.column_stack([effects[:, :, j].ravel(), constants])
        fitted = columns @ np.linalg.lstsq(columns, moved, rcond=None)[0]
        np.testing.assert_allclose(fitted, moved, atol=1e-8 * np.max(np.abs(moved)))


def test_brown1976_without_its_interior_orientation_has_18_estimable_terms():
    model = ap_models.get("brown1976")
    assert model.not_estimable == ("a19", "a20", "a21")
    assert properties.independence_of_orientation(model) < ROUNDING


# --- numbers of parameters -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("set_id", ["legendre", "chebyshev"])
@pytest.mark.parametrize(("m", "n", "count"), [(2, 2, 12), (4, 4, 44), (5, 5, 66), (2, 3, 18)])
def test_number_of_product_parameters(set_id: str, m: int, n: int, count: int):
    assert len(ap_models.get(set_id, m=m, n=n).parameters) == count == 2 * (m + 1) * (n + 1) - 6


@pytest.mark.parametrize(("order", "count"), [(1, 16), (2, 48)])
def test_number_of_fourier_parameters(order: int, count: int):
    assert len(ap_models.get("fourier", m=order, n=order).parameters) == count


@pytest.mark.parametrize(
    "model",
    [
        ap_models.get("legendre", m=9, n=9),
        ap_models.get("chebyshev", m=5, n=5),
        ap_models.get("fourier", m=2, n=2),
        ap_models.get("zernike", n=6),
    ],
    ids=lambda model: model.id,
)
def test_high_orders_stay_independent(model):
    assert properties.independence_of_orientation(model) > 0.01


# --- what a set takes up of a lens's distortion ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("set_id", "share"),
    [
        ("ebner12", 0.57),
        ("gruen12", 0.57),
        ("elhakim-faig11", 0.97),
        ("mauelshagen14", 1.0),
        ("schut14", 1.0),
        ("salmenpera-kilpela7", 1.0),
        ("none", 0.0),
        ("optical", 1.0),
        ("gruen44", 1.0),
    ],
)
def test_share_of_a_radial_cubic(set_id: str, share: float):
    assert properties.share_of_radial_cubic(ap_models.get(set_id)) == pytest.approx(share, abs=ONE_PER_CENT)


# --- the erratum of 1980 ---------------------------------------------------------------------------------------------


def test_both_forms_of_brown14_differ_in_b4_and_the_decentering_signs_alone():
    x, y = properties.grid(115.0, 5)
    right = ap_models.get("brown14").basis(x, y)
    printed = ap_models.get("brown14", as_printed=True).basis(x, y)
    b4_alone = ap_models.get("brown14", b4_printed=True).basis(x, y)
    sign_alone = ap_models.get("brown14", sign_printed=True).basis(x, y)
    changed = [j + 1 for j in range(14) if np.any(right[:, :, j] != printed[:, :, j])]
    assert changed == [4, 13, 14]
    np.testing.assert_array_equal(right[:, 1, 3], x**2 * y)
    np.testing.assert_array_equal(printed[:, 1, 3], x * y)
    np.testing.assert_allclose(right[:, 0, 12], 3 * x**2 + y**2, atol=1e-9)
    np.testing.assert_allclose(right[:, 1, 13], x**2 + 3 * y**2, atol=1e-9)
    np.testing.assert_allclose(printed[:, 0, 12], y**2 - x**2, atol=1e-9)
    np.testing.assert_allclose(printed[:, 1, 13], x**2 - y**2, atol=1e-9)
    np.testing.assert_array_equal(b4_alone[:, :, 3], printed[:, :, 3])
    np.testing.assert_array_equal(b4_alone[:, :, 12:], right[:, :, 12:])
    np.testing.assert_array_equal(sign_alone[:, :, 12:], printed[:, :, 12:])
    np.testing.assert_array_equal(sign_alone[:, :, 3], right[:, :, 3])


@pytest.mark.parametrize("set_id", ["optical", "torlegard"])
def test_the_misprinted_sign_is_selectable_in_the_other_models_of_1980(set_id: str):
    x, y = properties.grid(115.0, 5)
    difference = ap_models.get(set_id).basis(x, y) - ap_models.get(set_id, as_printed=True).basis(x, y)
    assert not np.any(difference[:, :, :-2])
    np.testing.assert_allclose(difference[:, :, -2], np.stack([4 * x**2, 0 * x], axis=1), atol=1e-9)
    np.testing.assert_allclose(difference[:, :, -1], np.stack([0 * x, 4 * y**2], axis=1), atol=1e-9)


def test_the_printed_form_can_be_estimated_too():
    assert properties.independence_of_orientation(ap_models.get("brown14", as_printed=True)) > 0.01
