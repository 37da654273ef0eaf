# Over 300 lines: one typed page, a form beside the other, read against the source in one go
"""Second forms of the sets of additional parameters: an independent check of the product's formulas.

Typed from the source without looking at the product's implementation: every function is written straight from the
published formula (as the project's reference pages quote it), for one point, with the math module only.

Each function takes the image coordinates x (in flight direction) and y (across) in mm, and the settings of the set by
keyword. It returns one tuple (name, dx, dy) for each parameter, in the source's order: the terms that a parameter of
value one adds to the distortion d, where measured + v = projected + d(measured). At r = 0 a term with x/r or y/r has
its limit, 0.

Where the source leaves a choice, the docstring of the function says which reading was taken.
"""

from __future__ import annotations

import math

Term = tuple[str, float, float]


def _unit(x: float, y: float) -> tuple[float, float]:
    """(x/r, y/r); (0, 0) in the centre, because every term that uses them vanishes there."""
    r = math.hypot(x, y)
    return (x / r, y / r) if r > 0.0 else (0.0, 0.0)


def _decentering(x: float, y: float, as_printed: bool) -> tuple[tuple[float, float], tuple[float, float]]:
    """The two decentering terms of Mauelshagen 1980; as printed they have a minus sign (see the erratum)."""
    r2 = x * x + y * y
    if as_printed:
        return (r2 - 2 * x * x, 2 * x * y), (2 * x * y, r2 - 2 * y * y)
    return (r2 + 2 * x * x, 2 * x * y), (2 * x * y, r2 + 2 * y * y)


# ---------------------------------------------------------------- Mauelshagen 1980, the three models


def optical(x: float, y: float, *, r0: float = 100.0, as_printed: bool = False) -> list[Term]:
    """Model 3.1, four parameters."""
    r2 = x**2 + y**2
    cubic = r2 - r0**2
    quintic = r2**2 - r0**4
    first, second = _decentering(x, y, as_printed)
    return [
        ("a3", x * cubic, y * cubic),
        ("a4", x * quintic, y * quintic),
        ("a5", *first),
        ("a6", *second),
    ]


def torlegard(x: float, y: float, *, r0: float = 100.0, as_printed: bool = False) -> list[Term]:
    """Model 3.2, six parameters: model 3.1 and a1 x + a2 y in dy."""
    return [("a1", 0.0, x), ("a2", 0.0, y), *optical(x, y, r0=r0, as_printed=as_printed)]


def brown14(x: float, y: float, *, r0: float = 100.0, as_printed: bool = False) -> list[Term]:
    """Model 3.3, fourteen parameters; as printed b4 has xy instead of x^2 y, and the minus sign in b13, b14."""
    r2 = x**2 + y**2
    ex, ey = _unit(x, y)
    first, second = _decentering(x, y, as_printed)
    return [
        ("b1", x, 0.0),
        ("b2", y, 0.0),
        ("b3", x * y**2, 0.0),
        ("b4", 0.0, x * y if as_printed else x**2 * y),
        ("b5", ex * (x * y), ey * (x * y)),
        ("b6", ex * x**3, ey * x**3),
        ("b7", ex * (x**2 * y), ey * (x**2 * y)),
        ("b8", ex * (x * y**2), ey * (x * y**2)),
        ("b9", ex * y**3, ey * y**3),
        ("b10", x * (r2 - r0**2), y * (r2 - r0**2)),
        ("b11", x * (r2**2 - r0**4), y * (r2**2 - r0**4)),
        ("b12", x * (r2**3 - r0**6), y * (r2**3 - r0**6)),
        ("b13", *first),
        ("b14", *second),
    ]


# ---------------------------------------------------------------- the sets of Ziemann & El-Hakim 1982


def ebner12(x: float, y: float, *, B: float) -> list[Term]:
    """Set b, Ebner 1976. B is the image base in mm."""
    X = x**2 - 2 * B**2 / 3
    Y = y**2 - 2 * B**2 / 3
    return [
        ("b1", x, -y),
        ("b2", y, x),
        ("b3", -2 * X, x * y),
        ("b4", x * y, -2 * Y),
        ("b5", Y, 0.0),
        ("b6", 0.0, X),
        ("b7", x * Y, 0.0),
        ("b8", 0.0, X * y),
        ("b9", X * y, 0.0),
        ("b10", 0.0, x * Y),
        ("b11", X * Y, 0.0),
        ("b12", 0.0, X * Y),
    ]


def elhakim_faig11(x: float, y: float) -> list[Term]:
    """Set c, El-Hakim & Faig, with the prefixes (x/r), (y/r) before q."""
    r = math.hypot(x, y)
    lam = math.atan2(y, x)
    ex, ey = _unit(x, y)
    q = {
        "a3": r * math.cos(lam),
        "a4": r * math.sin(lam),
        "a5": r**2,
        "a6": r**2 * math.cos(2 * lam),
        "a7": r**2 * math.sin(2 * lam),
        "a8": r**3 * math.cos(lam),
        "a9": r**3 * math.sin(lam),
        "a10": r**3 * math.cos(3 * lam),
        "a11": r**3 * math.sin(3 * lam),
    }
    return [("a1", x, -y), ("a2", y, x), *((name, ex * value, ey * value) for name, value in q.items())]


def gruen12(x: float, y: float) -> list[Term]:
    """Set f, Gruen, twelve parameters."""
    return [
        ("a1", y, 0.0),
        ("a2", x * y, 0.0),
        ("a3", x * y**2, 0.0),
        ("a4", x**2 * y, 0.0),
        ("a5", y**2, 0.0),
        ("a6", x**2 * y**2, 0.0),
        ("b1", 0.0, y),
        ("b2", 0.0, x * y),
        ("b3", 0.0, x * y**2),
        ("b4", 0.0, x**2 * y),
        ("b5", 0.0, x**2),
        ("b6", 0.0, x**2 * y**2),
    ]


def koelbl_juhl9(x: float, y: float, *, r0: float = 148.0) -> list[Term]:
    """Set k, Koelbl modified by Juhl: a reconstruction only. r0 is the given second zero."""
    r = math.hypot(x, y)
    lam = math.atan2(y, x)
    ex, ey = _unit(x, y)
    radial3 = r**3 - r**5 / r0**2
    radial4 = (math.sin(math.pi * r / r0) - 1) ** 2
    radial5 = math.sin(4 * math.pi * r / r0)
    power = r**1.85
    return [
        ("a1", 0.0, x),
        ("a2", 0.0, y),
        ("a3", ex * radial3, ey * radial3),
        ("a4", x * radial4, y * radial4),
        ("a5", ex * radial5, ey * radial5),
        ("a6", power * ex * math.cos(lam), power * ey * math.cos(lam)),
        ("a7", power * ex * math.sin(lam), power * ey * math.sin(lam)),
        ("a8", power * ex * math.cos(2 * lam), power * ey * math.cos(2 * lam)),
        ("a9", power * ex * math.sin(2 * lam), power * ey * math.sin(2 * lam)),
    ]


def mauelshagen14(x: float, y: float) -> list[Term]:
    """Set l, Mauelshagen's polynomial, fourteen parameters."""
    return [
        ("a1", x * y, 0.0),
        ("a2", y**2, 0.0),
        ("a3", x**3, 0.0),
        ("a4", x**2 * y, 0.0),
        ("a5", x * y**2, 0.0),
        ("a6", y**3, 0.0),
        ("b1", 0.0, x),
        ("b2", 0.0, y),
        ("b3", 0.0, x**2),
        ("b4", 0.0, x * y),
        ("b5", 0.0, x**3),
        ("b6", 0.0, x**2 * y),
        ("b7", 0.0, x * y**2),
        ("b8", 0.0, y**3),
    ]


def schut14(x: float, y: float) -> list[Term]:
    """Set m, Schut, fourteen parameters. c1 and the even numbers stand in dy, the odd numbers from c3 on in dx."""
    return [
        ("c1", 0.0, y),
        ("c2", 0.0, x),
        ("c3", x * y, 0.0),
        ("c4", 0.0, x**2),
        ("c5", y**2, 0.0),
        ("c6", 0.0, x * y),
        ("c7", x**2 * y, 0.0),
        ("c8", 0.0, x**2 * y),
        ("c9", x * y**2, 0.0),
        ("c10", 0.0, x * y**2),
        ("c11", x**2 * y**2, 0.0),
        ("c12", 0.0, x**2 * y**2),
        ("c13", x**3, 0.0),
        ("c14", 0.0, y**3),
    ]


def salmenpera_kilpela7(x: float, y: float, *, r0: float) -> list[Term]:
    """Set n, Salmenpera & Kilpela. r0 is the given first zero of the radial distortion."""
    r = math.hypot(x, y)
    zero = 1 - r0 / r if r > 0.0 else 0.0  # it stands before r^2 and higher powers: the limit of the terms is 0
    return [
        ("b1", x, -y),
        ("b2", y, x),
        ("b3", x * zero * r**2, y * zero * r**2),
        ("b4", x * zero * r**4, y * zero * r**4),
        ("b5", x * zero * r**6, y * zero * r**6),
        ("b6", 2 * x * y, r**2 + 2 * y**2),
        ("b7", r**2 + 2 * x**2, 2 * x * y),
    ]


# ---------------------------------------------------------------- the sets that the scans do not have


def gruen44(x: float, y: float, *, b: float) -> list[Term]:
    """Gruen 1978, 44 parameters. F has the coefficients b1..b19, G has c1..c19, on the same 19 functions."""
    k = x**2 - b**2 / 2
    l = y**2 - b**2 / 2  # noqa: E741 - the source's letter
    p = x**2 - 17 * b**2 / 20
    q = y**2 - 17 * b**2 / 20
    r = x**2 * (x**2 - 31 * b**2 / 28) + 9 * b**4 / 70
    s = y**2 * (y**2 - 31 * b**2 / 28) + 9 * b**4 / 70
    functions = [
        x * p,
        y * k,
        x * l,
        y * q,
        r,
        x * y * p,
        k * l,
        x * y * q,
        s,
        y * r,
        x * l * p,
        y * k * q,
        x * s,
        l * r,
        x * y * p * q,
        k * s,
        y * q * r,
        x * p * s,
        r * s,
    ]
    return [
        ("a1", x, -y),
        ("a2", y, x),
        ("a3", x * y, -(10 / 7) * l),
        ("a4", -(10 / 7) * k, x * y),
        ("a5", l, 0.0),
        ("a6", 0.0, k),
        *((f"b{i}", f, 0.0) for i, f in enumerate(functions, start=1)),
        *((f"c{i}", 0.0, f) for i, f in enumerate(functions, start=1)),
    ]


def brown1971(x: float, y: float, *, c: float) -> list[Term]:
    """Brown 1971 with the interior orientation; the listed corrections with the opposite sign.

    The source corrects the measurement; the project's d is the distortion contained in it, so each term is negated:
    minus the factor of dc, of xp and yp (which the source lists as -X/c, -1 and -1), and of K, P and B.
    """
    r2 = x**2 + y**2
    corrections = [
        ("dc", -x / c, -y / c),
        ("xp", -1.0, 0.0),
        ("yp", 0.0, -1.0),
        ("K1", x * r2, y * r2),
        ("K2", x * r2**2, y * r2**2),
        ("K3", x * r2**3, y * r2**3),
        ("P1", r2 + 2 * x**2, 2 * x * y),
        ("P2", 2 * x * y, r2 + 2 * y**2),
        ("B1", x, 0.0),
        ("B2", y, 0.0),
    ]
    return [(name, -dx, -dy) for name, dx, dy in corrections]


def brown1976(x: float, y: float, *, c: float) -> list[Term]:
    """Brown 1976, airborne form, 21 parameters. Reading: a19 is a constant in dx, a20 a constant in dy."""
    r2 = x**2 + y**2
    plate13 = x**2 - y**2
    plate14 = x**2 * y**2
    plate15 = x**4 - y**4
    return [
        ("a1", x, 0.0),
        ("a2", y, 0.0),
        ("a3", x * y, 0.0),
        ("a4", y**2, 0.0),
        ("a5", x**2 * y, 0.0),
        ("a6", x * y**2, 0.0),
        ("a7", x**2 * y**2, 0.0),
        ("a8", 0.0, x * y),
        ("a9", 0.0, x**2),
        ("a10", 0.0, x**2 * y),
        ("a11", 0.0, x * y**2),
        ("a12", 0.0, x**2 * y**2),
        ("a13", x / c * plate13, y / c * plate13),
        ("a14", x / c * plate14, y / c * plate14),
        ("a15", x / c * plate15, y / c * plate15),
        ("a16", x * r2, y * r2),
        ("a17", x * r2**2, y * r2**2),
        ("a18", x * r2**3, y * r2**3),
        ("a19", 1.0, 0.0),
        ("a20", 0.0, 1.0),
        ("a21", x / c, y / c),
    ]


def jacobsen12(x: float, y: float) -> list[Term]:
    """Jacobsen's twelve parameters of BLUH for the 23 cm format, in the order of the list."""
    r = math.hypot(x, y)
    lam = math.atan2(y, x)
    return [
        ("p1", y, x),
        ("p2", x, -y),
        ("p3", x * math.cos(2 * lam), y * math.cos(2 * lam)),
        ("p4", x * math.sin(2 * lam), y * math.sin(2 * lam)),
        ("p5", x * math.cos(lam), y * math.cos(lam)),
        ("p6", x * math.sin(lam), y * math.sin(lam)),
        ("p7", -y * r * math.cos(lam), x * r * math.cos(lam)),
        ("p8", -y * r * math.sin(lam), x * r * math.sin(lam)),
        ("p9", x * (r**2 - 16384), y * (r**2 - 16384)),
        ("p10", x * math.sin(0.049087 * r), y * math.sin(0.049087 * r)),
        ("p11", x * math.sin(0.098174 * r), y * math.sin(0.098174 * r)),
        ("p12", x * math.sin(4 * lam), y * math.sin(4 * lam)),
    ]
