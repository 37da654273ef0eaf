"""Angles survive their text: no bit is lost, and what a person typed short stays short."""

from __future__ import annotations

import decimal
import math

import pytest
from hypothesis import given, strategies as st

from simfield.files.degrees import degrees_text, radians_of


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_radians_come_back_exactly(radians: float) -> None:
    back = radians_of(degrees_text(radians))
    assert back == radians
    assert math.copysign(1.0, back) == math.copysign(1.0, radians)


@given(st.integers(-720_000_000, 720_000_000))
def test_a_short_text_comes_back_as_it_was_typed(microdegrees: int) -> None:
    typed = f"{microdegrees / 1_000_000:.6f}".rstrip("0")
    typed = typed + "0" if typed.endswith(".") else typed
    if abs(microdegrees) >= 10:
        assert degrees_text(radians_of(typed)) == typed
    assert float(degrees_text(radians_of(typed))) == float(typed)


@pytest.mark.parametrize(
    ("typed", "written"),
    [
        ("1", "1.0"),
        ("1.0", "1.0"),
        ("-90", "-90.0"),
        ("0", "0.0"),
        ("-0.0", "-0.0"),
        ("+.5", "0.5"),
        ("1e2", "100.0"),
        ("0.000001", "0.000001"),
        ("0.00000012", "1.2e-7"),
        ("", ""),
    ],
)
def test_texts_are_written_short(typed: str, written: str) -> None:
    assert degrees_text(radians_of(typed)) == written


def test_a_reading_is_rounded_once() -> None:
    assert radians_of("180") == math.pi
    assert radians_of("57.295779513082320876798154814105170332405") == 1.0
    assert radians_of("720") == 4 * math.pi


def test_the_decimal_context_of_the_caller_does_not_matter() -> None:
    with decimal.localcontext(prec=3):
        assert radians_of("123.456789") == pytest.approx(math.radians(123.456789), rel=1e-15)
        assert radians_of(degrees_text(0.1)) == 0.1


@pytest.mark.parametrize("text", ["nan", "inf", "-inf", "1e999", "x", "1,5"])
def test_what_is_no_finite_number_is_refused(text: str) -> None:
    with pytest.raises(ValueError):
        radians_of(text)


def test_an_infinite_angle_has_no_text() -> None:
    assert degrees_text(math.nan) == ""
    with pytest.raises(ValueError, match="not a finite angle"):
        degrees_text(math.inf)
