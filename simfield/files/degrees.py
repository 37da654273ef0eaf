"""Angles as text: degrees in files, radians in arrays, and no bit lost between them.

A file's degrees are multiplied by pi/180 in 40 decimal digits and rounded once to a float. The way back writes the
fewest digits that read as exactly the same radians, so 1.0 typed by hand is written as 1.0 again.
"""

from __future__ import annotations

import math
from decimal import Context, Decimal

DECIMAL = Context(prec=40, traps=[])
"""our own context: the caller's precision and traps do not matter, overflow gives inf instead of an exception"""
PI = Decimal("3.141592653589793238462643383279502884197169399375105820974944592")
RADIANS_PER_DEGREE = DECIMAL.divide(PI, Decimal(180))
FEWEST_DIGITS, MOST_DIGITS = 15, 20


def radians_of(text: str) -> float:
    """The radians of an angle written in degrees, correctly rounded; an empty text is NaN.

    Raises ValueError for a text that is not a finite number.
    """
    if not text:
        return math.nan
    float(text)  # a ValueError for what is no number, where Decimal would raise an ArithmeticError
    radians = float(DECIMAL.multiply(Decimal(text), RADIANS_PER_DEGREE))
    if not math.isfinite(radians):
        raise ValueError(f"{text!r} is not a finite angle")
    return radians


def degrees_text(radians: float) -> str:
    """The shortest text of 15 to 20 significant digits, in degrees, that radians_of reads as exactly these radians.

    NaN is the empty text. Raises ValueError for an infinite angle.
    """
    if math.isnan(radians):
        return ""
    if math.isinf(radians):
        raise ValueError(f"{radians} is not a finite angle")
    exact = DECIMAL.divide(Decimal(radians), RADIANS_PER_DEGREE)
    for digits in range(FEWEST_DIGITS, MOST_DIGITS + 1):
        text = _plain(Context(prec=digits, traps=[]).create_decimal(exact))
        if radians_of(text) == radians:
            return text
    raise AssertionError(f"{radians!r} rad has no text of {MOST_DIGITS} digits")  # 17 digits tell any two floats apart


def _plain(value: Decimal) -> str:
    """A decimal as a person writes it: 1.0, -90.5, 0.001; with an exponent only where zeros would swamp it."""
    if not value:
        return "-0.0" if value.is_signed() else "0.0"
    value = value.normalize(DECIMAL)
    if not -6 <= value.adjusted() <= 15:
        return f"{value:e}"
    text = f"{value:f}"
    return text if "." in text else text + ".0"
