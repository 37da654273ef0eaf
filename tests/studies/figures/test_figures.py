"""Figures: identical bytes every time, and what they show is what the data say."""

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.quiver import Quiver

from studies import figures
from studies.comparison.distortion_found import RadialCurve, VectorField, crest, format_grid
from studies.figures.canvas import house_style, new_figure, save

R_MM = np.linspace(0.0, 150.0, 151)


@pytest.fixture
def curve():
    d = 4.0 * np.sin(R_MM / 100.0 * np.pi)
    return RadialCurve("ww", "optical", 100.0, R_MM, d, 0.1 + 0.0 * d, d + 0.2)


@pytest.fixture
def field():
    return VectorField(format_grid(), np.tile([3.0, 4.0], (len(format_grid()), 1)))


def draw_all(curve, field):
    figure = new_figure(180, 120)
    a, b, c, d = figure.subplots(2, 2).ravel()
    figures.radial_curve(a, curve, {"other": curve})
    figures.vectors(b, field, field, 10.0)
    figures.radius_histogram(c, {"all": np.array([1.0, 5.0, 2.0])}, np.array([0.0, 10.0, 20.0, 30.0]))
    figures.correlation_matrix(d, np.eye(3), np.eye(3), ["a", "b", "c"])
    return figure


def test_bytes_are_identical_twice(curve, field, tmp_path):
    written = []
    for name in ("one", "two"):
        with house_style():
            written.append([path.read_bytes() for path in save(draw_all(curve, field), tmp_path / name)])
    assert written[0] == written[1]
    vector, raster = written[0]
    assert b"<dc:date>" not in vector
    assert raster.startswith(b"\x89PNG")


def test_file_names_keep_their_dots(curve, field, tmp_path):
    with house_style():
        files = save(draw_all(curve, field), tmp_path / "figure.1")
    assert [f.name for f in files] == ["figure.1.svg", "figure.1.png"]


def test_vectors_have_the_unit_that_the_legend_says(field):
    axes = new_figure(80, 80).subplots()
    figures.vectors(axes, field, field, 10.0)
    quiver = [c for c in axes.collections if isinstance(c, Quiver)][-1]
    drawn_mm = np.hypot(quiver.U, quiver.V) / quiver.scale
    np.testing.assert_allclose(drawn_mm, 5.0)  # 5 um at 10 um for 10 mm
    assert "5.0 µm" in axes.get_xlabel()


def test_heat_map_has_one_matrix_above_and_the_other_below():
    axes = new_figure(80, 80).subplots()
    mesh = figures.correlation_matrix(axes, np.full((3, 3), 0.5), np.full((3, 3), -0.5), ["a", "b", "c"])
    assert isinstance(mesh, QuadMesh)
    shown = np.asarray(mesh.get_array()).reshape(3, 3)
    np.testing.assert_array_equal(shown, [[0, 0.5, 0.5], [-0.5, 0, 0.5], [-0.5, -0.5, 0]])


def test_quadratic_mean_and_corner(field):
    assert field.rms_um == pytest.approx(5.0)
    growing = VectorField(format_grid(), format_grid() / 100.0)
    assert growing.corner_um == pytest.approx(np.sqrt(2.0))


def test_crest_is_the_extreme_before_the_second_zero(curve):
    assert curve.crest_um == pytest.approx(4.0)
    assert crest(R_MM, -curve.estimated_um, 100.0) == pytest.approx(-4.0)
