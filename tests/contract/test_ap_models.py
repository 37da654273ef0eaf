"""One contract for every set of additional parameters, with its default settings."""

from __future__ import annotations

import dataclasses
import pickle

import numpy as np
import pytest

from adjust import ap_models
from adjust.ap_models import properties
from adjust.ap_models.lookup import MODELS
from adjust.ap_models.model import ApModel, Certainty

EXPECTED = {
    "none": 0,
    "optical": 4,
    "torlegard": 6,
    "brown14": 14,
    "ebner12": 12,
    "elhakim-faig11": 11,
    "gruen12": 12,
    "koelbl-juhl9": 9,
    "mauelshagen14": 14,
    "schut14": 14,
    "salmenpera-kilpela7": 7,
    "gruen44": 44,
    "brown1971": 10,
    "brown1976": 21,
    "jacobsen12": 12,
    "legendre": 26,
    "fourier": 16,
    "chebyshev": 26,
    "zernike": 24,
}
SMALLEST_SINGULAR_VALUE = 0.01
"""of columns scaled to unit length; the closest set, brown1976, has 0.017, rounding gives 1e-16"""
ROUNDING = 1e-12
SUMMED_UP = ("torlegard", "gruen44", "legendre", "chebyshev", "fourier", "zernike")
"""sets whose formula refers to another or is written as a sum, and does not name every parameter"""

SETS = [pytest.param(kind(), id=kind.id) for kind in MODELS]
every_set = pytest.mark.parametrize("model", SETS)


def test_every_public_id_is_there_once():
    assert ap_models.names() == tuple(dict.fromkeys(ap_models.names()))
    assert set(EXPECTED) <= set(ap_models.names())


@every_set
def test_the_id_finds_the_set(model: ApModel):
    assert ap_models.get(model.id) == model


@every_set
def test_one_term_for_every_parameter(model: ApModel):
    x, y = properties.grid(115.0, 5)
    assert len(model.terms(x, y)) == len(model.parameters) == EXPECTED.get(model.id, len(model.parameters))
    assert len(set(model.parameters)) == len(model.parameters)
    assert all(name and " " not in name and "," not in name for name in model.parameters)


@every_set
def test_shape_of_the_basis(model: ApModel):
    x, y = properties.grid(115.0, 4)
    assert model.basis(x, y).shape == (16, 2, len(model.parameters))
    assert model.basis(x[:0], y[:0]).shape == (0, 2, len(model.parameters))
    assert model.basis(x[:1], y[:1]).shape == (1, 2, len(model.parameters))


@every_set
def test_each_point_stands_for_itself(model: ApModel):
    x, y = properties.grid(115.0, 5)
    together = model.basis(x, y)
    one_by_one = np.concatenate([model.basis(x[i : i + 1], y[i : i + 1]) for i in range(x.size)])
    np.testing.assert_allclose(together, one_by_one, rtol=1e-13, atol=0)


@every_set
def test_finite_and_continuous_over_the_format(model: ApModel):
    axis = np.concatenate([np.linspace(-115, 115, 47), [-1e-9, 1e-9, -0.0, 0.0]])
    x, y = (a.ravel() for a in np.meshgrid(axis, axis))
    assert np.all(np.isfinite(model.basis(x, y)))
    largest = np.max(np.abs(model.basis(x, y)), axis=(0, 1))
    centre = model.basis(np.zeros(1), np.zeros(1)) / largest
    for direction in np.linspace(0, 2 * np.pi, 9):
        near = model.basis(1e-9 * np.array([np.cos(direction)]), 1e-9 * np.array([np.sin(direction)])) / largest
        np.testing.assert_allclose(near, centre, atol=1e-9)


@every_set
def test_the_terms_are_independent(model: ApModel):
    assert properties.independence(model) > SMALLEST_SINGULAR_VALUE


@every_set
def test_what_is_called_estimable_is_independent_of_the_orientation(model: ApModel):
    assert properties.independence_of_orientation(model, model.not_estimable) > SMALLEST_SINGULAR_VALUE


@every_set
def test_what_is_called_not_estimable_is_dependent(model: ApModel):
    assert set(model.not_estimable) <= set(model.parameters)
    for name in model.not_estimable:
        assert properties.dependence_on_others(model, name) < ROUNDING
        assert model.why_not_estimable[name]


@every_set
def test_orthogonal_where_it_says_so(model: ApModel):
    if model.orthogonal_on_mm:
        assert max(properties.largest_cosines(model, *properties.product_grid(model.orthogonal_on_mm))) < ROUNDING


@every_set
def test_pickles_and_compares_by_value(model: ApModel):
    again = pickle.loads(pickle.dumps(model))
    assert again == model
    assert hash(again) == hash(model)
    assert again is not model
    x, y = properties.grid(115.0, 3)
    np.testing.assert_array_equal(again.basis(x, y), model.basis(x, y))
    assert sum(model == kind() for kind in MODELS) == 1


@every_set
def test_cannot_be_changed(model: ApModel):
    name = next(iter(model.settings), "id")
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(model, name, 1.0)


@every_set
def test_says_where_it_comes_from(model: ApModel):
    for text in (model.title, model.author, model.source, model.formula):
        assert text.strip() == text != ""
    assert isinstance(model.certainty, Certainty)
    assert model.year == 0 if model.id == "none" else 1960 < model.year < 2030
    if model.id not in SUMMED_UP:
        assert [name for name in model.parameters if f"{name} " not in model.formula] == []


@every_set
def test_settings_say_what_they_are(model: ApModel):
    for f in dataclasses.fields(model):
        assert f.metadata["about"]
        if isinstance(f.default, float):
            assert f.name.endswith("_mm")


@every_set
def test_unknown_setting_is_refused_by_name(model: ApModel):
    with pytest.raises(TypeError, match=f"{model.id} has no setting 'zero_mm'"):
        ap_models.get(model.id, zero_mm=1.0)


@pytest.mark.parametrize(
    ("kind", "name"), [pytest.param(k, f.name, id=f"{k.id}-{f.name}") for k in MODELS for f in dataclasses.fields(k)]
)
def test_impossible_settings_are_refused_by_name(kind: type[ApModel], name: str):
    default = kind().settings[name]
    impossible = [None, "100", float("nan")]
    if isinstance(default, bool):
        impossible += [1, 0.0]
    elif isinstance(default, tuple):
        impossible += [("nothing",), (kind().parameters[0],) * 2, kind().parameters, True]
    elif isinstance(default, int):
        impossible += [0, -1, 2.5, True, 10]
    else:
        impossible += [-1.0, float("inf"), True]
    for value in impossible:
        with pytest.raises(ValueError, match=f"{kind.id}: {name} = .* is not allowed, it must be"):
            kind(**{name: value})


@pytest.mark.parametrize("kind", [k for k in MODELS if "without" in k().settings])
def test_parameters_can_be_left_out_by_name(kind: type[ApModel]):
    whole = kind()
    part = kind(without=whole.parameters[1:3])
    assert part.parameters == (whole.parameters[0], *whole.parameters[3:])
    x, y = properties.grid(115.0, 5)
    kept = [whole.parameters.index(name) for name in part.parameters]
    np.testing.assert_array_equal(part.basis(x, y), whole.basis(x, y)[:, :, kept])
    assert set(part.not_estimable) == set(whole.not_estimable) & set(part.parameters)


@every_set
def test_evaluation_at_zero_is_the_basis(model: ApModel):
    x, y = properties.grid(115.0, 5)
    nothing = np.zeros(len(model.parameters))
    d, by_values = model.evaluate(x, y, nothing)
    np.testing.assert_array_equal(d, 0.0)
    others = [j for j, name in enumerate(model.parameters) if name != model.principal_distance]
    np.testing.assert_allclose(by_values[:, :, others], model.basis(x, y)[:, :, others], rtol=1e-13, atol=0.0)


@every_set
def test_derivatives_are_those_of_the_evaluation(model: ApModel):
    """Central differences around parameters that move the corners by some tenths of a millimetre."""
    x, y = properties.grid(18.0, 5)
    size = np.abs(model.basis(x, y)).max(axis=(0, 1))
    values = 0.3 * np.random.default_rng(8).uniform(-1.0, 1.0, len(size)) / size
    _, by_values = model.evaluate(x, y, values)
    for j, step in enumerate(1e-4 / size):
        change = np.eye(len(size))[j] * step
        by_differences = model.evaluate(x, y, values + change)[0] - model.evaluate(x, y, values - change)[0]
        np.testing.assert_allclose(by_values[:, :, j] * 2.0 * step, by_differences, rtol=0.0, atol=1e-10)


@every_set
def test_settings_matter(model: ApModel):
    x, y = properties.grid(115.0, 3)
    for name, value in model.settings.items():
        other = not value if isinstance(value, bool) else model.parameters[:1] if value == () else value + 1
        changed = dataclasses.replace(model, **{name: other})
        assert changed != model
        shown = changed.basis(x, y)
        assert shown.shape != model.basis(x, y).shape or np.any(shown != model.basis(x, y))


def test_an_unknown_set_is_refused_with_the_nearest():
    with pytest.raises(KeyError, match="did you mean 'ebner12'"):
        ap_models.get("ebner")


def test_a_reconstruction_is_called_so_wherever_it_is_named():
    for model in (kind() for kind in MODELS):
        if model.certainty is Certainty.RECONSTRUCTION:
            for text in (model.title, model.source, model.formula):
                assert "reconstruction" in text
