"""Second, independent forms of the families of sets: products of polynomials, Fourier, Zernike.

Typed as those of `second_forms` were, whose introduction says how.
"""

from __future__ import annotations

import math

from tests.published.second_forms import Term


def _legendre(n: int, t: float) -> float:
    """P_n(t) by its explicit sum: 2^-n sum_k (-1)^k C(n, k) C(2n - 2k, n) t^(n - 2k)."""
    total = 0.0
    for k in range(n // 2 + 1):
        total += (-1) ** k * math.comb(n, k) * math.comb(2 * n - 2 * k, n) * t ** (n - 2 * k)
    return math.ldexp(total, -n)


def _chebyshev(n: int, t: float) -> float:
    """T_n(t) by its explicit sum: sum_k C(n, 2k) (t^2 - 1)^k t^(n - 2k)."""
    return math.fsum(math.comb(n, 2 * k) * (t * t - 1) ** k * t ** (n - 2 * k) for k in range(n // 2 + 1))


def _products_less_orientation(
    fx: list[float], fy: list[float], x: float, y: float, kx: float, ky: float
) -> list[Term]:
    """Products fx[m] fy[n] in dx and dy, less the six orientation effects.

    (1, 0), (0, 1) are left out. The products of which the other four effects consist (m, n = 1,0 and 0,1 in both
    coordinates, 1,1 in both, 2,0 in dx and 0,2 in dy: eight) give way to the four complementary combinations
    (x, -y), (y, x), (-kx f2(x), xy) and (xy, -ky f2(y)); everything else stays as it is.
    """
    if len(fx) < 3 or len(fy) < 3:
        raise ValueError("the rule needs M >= 2 and N >= 2")
    xy = fx[1] * fy[1]
    out: list[Term] = [
        ("x,-y", x, -y),
        ("y,x", y, x),
        ("-kP2(x),xy", -kx * fx[2], xy),
        ("xy,-kP2(y)", xy, -ky * fy[2]),
    ]
    for m, f in enumerate(fx):
        for n, g in enumerate(fy):
            if (m, n) in {(0, 0), (1, 0), (0, 1), (1, 1)}:
                continue
            if (m, n) != (2, 0):
                out.append((f"dx{m},{n}", f * g, 0.0))
            if (m, n) != (0, 2):
                out.append((f"dy{m},{n}", 0.0, f * g))
    return out


def legendre(x: float, y: float, *, M: int, N: int, bx: float, by: float) -> list[Term]:
    """Tang, Fritsch & Cramer 2012: 2 (M+1)(N+1) - 6 parameters.

    Reading: (x, -y) and (y, x) literally, in mm. With u = x/bx, v = y/by the effect (x^2, xy) is, but for a constant,
    (2/3 bx^2 P2(u), bx by uv); the mean squares over the format are 1/5 for P2 and 1/9 for uv, so (-k P2(u), uv) is
    orthogonal to it with k = 5/6 by/bx, and (uv, -k P2(v)) to (xy, y^2) with k = 5/6 bx/by.
    """
    fx = [_legendre(m, x / bx) for m in range(M + 1)]
    fy = [_legendre(n, y / by) for n in range(N + 1)]
    return _products_less_orientation(fx, fy, x, y, 5 / 6 * by / bx, 5 / 6 * bx / by)


def chebyshev(x: float, y: float, *, M: int, N: int, bx: float, by: float) -> list[Term]:
    """T_m(x/bx) T_n(y/by) by the Legendre rule.

    Reading: orthogonal means with the weight of the Chebyshev polynomials (in which they are orthogonal at all). Then
    (x^2, xy) is, but for a constant, (1/2 bx^2 T2(u), bx by uv), the mean squares are 1/2 and 1/4: k = by/bx, bx/by.
    """
    fx = [_chebyshev(m, x / bx) for m in range(M + 1)]
    fy = [_chebyshev(n, y / by) for n in range(N + 1)]
    return _products_less_orientation(fx, fy, x, y, by / bx, bx / by)


def fourier(x: float, y: float, *, M: int, N: int, bx: float, by: float) -> list[Term]:
    """Tang 2012: cos(mu + nv), sin(mu + nv) in dx and dy; 4 [M (2N+1) + N] parameters. No orientation effect leaves."""
    u = math.pi * x / bx
    v = math.pi * y / by
    orders = [(m, n) for m in range(1, M + 1) for n in range(-N, N + 1)] + [(0, n) for n in range(1, N + 1)]
    out: list[Term] = []
    for m, n in orders:
        cosine = math.cos(m * u + n * v)
        sine = math.sin(m * u + n * v)
        out.append((f"dx cos {m},{n}", cosine, 0.0))
        out.append((f"dx sin {m},{n}", sine, 0.0))
        out.append((f"dy cos {m},{n}", 0.0, cosine))
        out.append((f"dy sin {m},{n}", 0.0, sine))
    return out


def _zernike(n: int, m: int, rho: float, theta: float) -> float:
    """Z_n^m without a norm factor: R_n^|m|(rho) cos(m theta) for m >= 0, R_n^|m|(rho) sin(|m| theta) for m < 0."""
    a = abs(m)
    radial = 0.0
    for k in range((n - a) // 2 + 1):
        radial += (
            (-1) ** k
            * math.factorial(n - k)
            / (math.factorial(k) * math.factorial((n + a) // 2 - k) * math.factorial((n - a) // 2 - k))
            * rho ** (n - 2 * k)
        )
    return radial * (math.cos(m * theta) if m >= 0 else math.sin(a * theta))


def zernike(x: float, y: float, *, order: int, radius: float) -> list[Term]:
    """Zernike polynomials up to the radial order on the circle of the radius: (n+1)(n+2) - 6 parameters.

    Reading: all Z_n^m with n <= order in dx and dy; left out are the six orientation effects, by taking of the orders
    0 to 2 only what is orthogonal to them on the full circle. Of order 1 that is (x, -y), (y, x). Of order 2 let
    A = Z_2^0, C = Z_2^2, S = Z_2^-2, with mean squares 1/3, 1/6, 1/6. But for constants (x^2, xy) is
    (A/4 + C/2, S/2) and (xy, y^2) is (S/2, A/4 - C/2); orthogonal to both are the four combinations below.
    """
    if order < 2:
        raise ValueError("the rule needs the order 2 at least")
    rho = math.hypot(x, y) / radius
    theta = math.atan2(y, x)
    a = _zernike(2, 0, rho, theta)
    c = _zernike(2, 2, rho, theta)
    s = _zernike(2, -2, rho, theta)
    out: list[Term] = [
        ("x,-y", x, -y),
        ("y,x", y, x),
        ("A-C,0", a - c, 0.0),
        ("A+2C,-3S", a + 2 * c, -3 * s),
        ("0,A+C", 0.0, a + c),
        ("-3S,A-2C", -3 * s, a - 2 * c),
    ]
    for n in range(3, order + 1):
        for m in range(-n, n + 1, 2):
            value = _zernike(n, m, rho, theta)
            out.append((f"dx{n},{m}", value, 0.0))
            out.append((f"dy{n},{m}", 0.0, value))
    return out
