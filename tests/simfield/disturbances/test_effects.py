"""Each effect against values typed by hand; the sums against the forms of Mauelshagen 1980."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from simfield.disturbances.effects import (
    EFFECTS,
    Decentering,
    EarthCurvature,
    EffectOn,
    FilmAffine,
    FilmPolynomial,
    RadialPolynomial,
    RadialTable,
    Refraction,
    UnflatFilm,
)

ROUNDING_MM = 1e-15
"""Effects are below 0.1 mm; the sums of a dozen terms differ in the last places."""

TRACED_UM = 0.02
"""what is asked for; the integration here is good to a tenth of that"""

XY = np.array([[60.0, -80.0], [100.0, 0.0], [0.0, 0.0], [-37.5, 91.25], [110.0, 110.0]])


def same(found, wanted):
    np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=ROUNDING_MM)


def test_radial_polynomial():
    effect = RadialPolynomial(k1=1e-8, k2=2e-12, k3=3e-16, r0_mm=50.0)
    bracket = 1e-8 * (100**2 - 50**2) + 2e-12 * (100**4 - 50**4) + 3e-16 * (100**6 - 50**6)
    same(effect.displacement(XY)[:3], [[60 * bracket, -80 * bracket], [100 * bracket, 0], [0, 0]])
    zero = RadialPolynomial(k1=1e-8, k2=2e-12, k3=3e-16, r0_mm=100.0).displacement(XY[:2])
    same(zero, np.zeros((2, 2)))


def test_decentering():
    found = Decentering(p1=1e-7, p2=-2e-7).displacement(XY[:1])
    same(found, [[1e-7 * (10000 + 7200) + 2e-7 * 9600, -1e-7 * 9600 - 2e-7 * (10000 + 12800)]])


def test_film_affine():
    same(FilmAffine(1e-5, 2e-5, 3e-5, 4e-5).displacement(XY[:1]), [[60e-5 - 160e-5, 180e-5 - 320e-5]])


@pytest.mark.parametrize("name", ["x2", "xy", "y2", "x3", "x2y", "xy2", "y3"])
def test_every_monomial_of_the_film_polynomial(name):
    x, y = XY.T
    powers = {"x2": x**2, "xy": x * y, "y2": y**2, "x3": x**3, "x2y": x**2 * y, "xy2": x * y**2, "y3": y**3}
    zero = np.zeros_like(x)
    same(FilmPolynomial(**{f"dx_{name}": 2e-9}).displacement(XY), np.column_stack([2e-9 * powers[name], zero]))
    same(FilmPolynomial(**{f"dy_{name}": 2e-9}).displacement(XY), np.column_stack([zero, 2e-9 * powers[name]]))


def test_unflat_film_is_radial_and_zero_at_the_centre():
    found = UnflatFilm(1e-7, 2e-9, 3e-9, 4e-9, 5e-9).displacement(XY[:3])
    q = 1e-7 * -4800 + 2e-9 * 60**3 + 3e-9 * 3600 * -80 + 4e-9 * 60 * 6400 + 5e-9 * -(80**3)
    same(found, [[0.6 * q, -0.8 * q], [2e-9 * 100**3, 0.0], [0.0, 0.0]])


def test_earth_curvature_has_the_published_size():
    """For RMK A 15/23 at 1:10 500 and r = 140 mm 14.9 um inward; the flying height is known to one per cent."""
    curvature = EarthCurvature(height_above_ground_m=1606.0, c_mm=153.0).displacement(np.array([[140.0, 0.0]]))
    np.testing.assert_allclose(1000 * curvature, [[-14.9, 0.0]], atol=0.2)


FLIGHTS = [
    (1660.0, 50.0, 153.0),
    (922.0, 50.0, 85.5),
    (6000.0, 4000.0, 153.0),
    (13_000.0, 200.0, 153.0),
    (120.0, 0.0, 24.0),
]
"""heights of camera and ground above sea level, m, and c, mm: 1980, high ground, above the tropopause, a drone"""


@pytest.mark.parametrize(("camera", "ground", "c"), FLIGHTS)
def test_refraction_is_that_of_traced_rays(camera: float, ground: float, c: float):
    """The ray and the pressure of the air are integrated here as differential equations, from camera to ground."""

    def kelvin(z: float) -> float:
        return 288.15 - 0.0065 * min(z, 11_000.0)

    def pressures(heights: list[float]) -> np.ndarray:
        solved = solve_ivp(lambda z, p: [-9.80665 * p[0] / (287.05287 * kelvin(z))], (0.0, 20_000.0), [1013.25],
                           t_eval=heights, rtol=1e-11, atol=1e-9, max_step=50.0)  # fmt: skip
        return solved.y[0]

    grid = np.linspace(0.0, 20_000.0, 4001)
    index = CubicSpline(grid, 1.0 + 277.9e-6 * 288.15 / 1013.25 * pressures(list(grid)) / [kelvin(z) for z in grid])
    slope = index.derivative()
    for tangent in (0.2, 0.6, 1.0):
        # a ray in a layered medium: d theta / dz = - tan(theta) n' / n
        solved = solve_ivp(
            lambda z, y: [np.tan(y[1]), -np.tan(y[1]) * slope(z) / index(z)], (camera, ground),
            [0.0, np.arctan(tangent)], rtol=1e-12, atol=1e-12, max_step=(camera - ground) / 50.0,
        )  # fmt: skip
        straight = -solved.y[0, -1] / (camera - ground)
        xy = np.array([[0.6, -0.8]]) * c * tangent
        moved = 1000.0 * Refraction(camera, ground, c).displacement(xy)
        expected = 1000.0 * c * (tangent - straight) * np.array([[0.6, -0.8]])
        np.testing.assert_allclose(moved, expected, atol=TRACED_UM)


@pytest.mark.parametrize(("flight", "urad"), [(FLIGHTS[0], 19.7), (FLIGHTS[1], 11.1), (FLIGHTS[2], 17.6)])
def test_a_ray_at_45_degrees_is_bent_as_the_standard_atmosphere_bends_it(flight: tuple[float, ...], urad: float):
    """Figures of an independent trace; Bertram's formula has 16.4, 9.0 and 31 for these."""
    moved = Refraction(*flight).displacement(np.array([[flight[2], 0.0]]))[0, 0]
    assert 1e6 * moved / flight[2] / 2.0 == pytest.approx(urad, abs=0.1)


def test_the_radial_table_passes_its_nodes_and_is_smooth_and_odd():
    radii, values = (20.0, 40.0, 80.0, 120.0), (3.0, 4.0, -1.0, -5.0)
    table = RadialTable(radii, values)
    same(table.distortion_mm(np.array(radii)), np.array(values) / 1000)
    assert table.distortion_mm(np.zeros(1)) == 0.0
    same(table.displacement(np.array([[-20.0, 0.0], [0.0, 40.0]])), [[-0.003, 0.0], [0.0, 0.004]])
    step = 1e-3
    for node in (40.0, 80.0):
        r = node + step * np.array([-2, -1, 0, 1, 2])
        d = table.distortion_mm(r)
        assert abs((d[4] - 2 * d[2] + d[0]) / 4 - (d[3] - 2 * d[2] + d[1])) < 1e-12, "second derivative is continuous"
    near = table.distortion_mm(np.array([1e-3, 2e-3]))
    np.testing.assert_allclose(near[1] / near[0], 2.0, rtol=1e-6, err_msg="linear at the centre")


def test_the_radial_table_reproduces_a_straight_line_and_refuses_what_nobody_measured():
    table = RadialTable((0.0, 50.0, 100.0), (0.0, 5.0, 10.0))
    same(table.distortion_mm(np.linspace(0, 100, 7)), np.linspace(0, 0.01, 7))
    with pytest.raises(ValueError, match="ends at 100 mm"):
        table.displacement(np.array([[100.0, 1.0]]))


@pytest.mark.parametrize(
    ("radii", "values", "reason"),
    [
        ((10.0,), (1.0, 2.0), "same number"),
        ((), (), "at least one"),
        ((10.0, 10.0), (1.0, 2.0), "rise"),
        ((-1.0, 10.0), (1.0, 2.0), "rise"),
        ((0.0, 10.0), (1.0, 2.0), "is 0"),
        ((0.0,), (0.0,), "beyond it"),
    ],
)
def test_defective_tables_are_refused(radii, values, reason):
    with pytest.raises(ValueError, match=reason):
        RadialTable(radii, values)


def test_the_sums_are_the_models_of_mauelshagen_1980():
    """3.2 and 3.3 typed from their printed lines (with the signs of the erratum)."""
    x, y = XY.T
    r2, r0 = x**2 + y**2, 100.0
    r = np.where(r2 > 0, np.sqrt(r2), 1.0)
    a1, a2, a3, a4, a5, a6 = 1e-5, 8e-5, -2e-8, 5e-13, 3e-7, -2e-7
    bracket = a3 * (r2 - r0**2) + a4 * (r2**2 - r0**4)
    dx = x * bracket + a5 * (r2 + 2 * x**2) + a6 * 2 * x * y
    dy = a1 * x + a2 * y + y * bracket + a5 * 2 * x * y + a6 * (r2 + 2 * y**2)
    torlegard = [RadialPolynomial(a3, a4), Decentering(a5, a6), FilmAffine(c=a1, d=a2)]
    same(sum(e.displacement(XY) for e in torlegard), np.column_stack([dx, dy]))

    b = dict(enumerate([2e-5, 3e-5, 4e-9, -3e-9, 1e-7, 2e-9, -1e-9, 3e-9, 2e-9, -2e-8, 5e-13, 1e-17, 3e-7, -2e-7], 1))
    q = b[5] * x * y + b[6] * x**3 + b[7] * x**2 * y + b[8] * x * y**2 + b[9] * y**3
    bracket = b[10] * (r2 - r0**2) + b[11] * (r2**2 - r0**4) + b[12] * (r2**3 - r0**6)
    dx = b[1] * x + b[2] * y + b[3] * x * y**2 + x / r * q + x * bracket + b[13] * (r2 + 2 * x**2) + b[14] * 2 * x * y
    dy = b[4] * x**2 * y + y / r * q + y * bracket + b[13] * 2 * x * y + b[14] * (r2 + 2 * y**2)
    brown = [
        FilmAffine(b[1], b[2]),
        FilmPolynomial(dx_xy2=b[3], dy_x2y=b[4]),
        UnflatFilm(*(b[i] for i in range(5, 10))),
        RadialPolynomial(b[10], b[11], b[12]),
        Decentering(b[13], b[14]),
    ]
    same(sum(e.displacement(XY) for e in brown), np.column_stack([dx, dy]))


def test_an_effect_acts_where_it_is_attached():
    names = ("ww", "before", "before-h0-1")
    effect = FilmAffine()
    assert EffectOn(effect).acts_on(*names)
    assert EffectOn(effect, camera="ww").acts_on(*names)
    assert EffectOn(effect, camera="ww", flight="before", image="before-h0-1").acts_on(*names)
    assert not EffectOn(effect, camera="sww").acts_on(*names)
    assert not EffectOn(effect, camera="ww", flight="after").acts_on(*names)
    assert not EffectOn(effect, image="before-h0-2").acts_on(*names)


def test_kinds_are_unique():
    assert len({e.__dataclass_fields__["kind"].default for e in EFFECTS}) == len(EFFECTS)
