"""Bott–Duffin [BottDuffin1949]: a minimum function as springs, dampers and inerters alone, no lever.

For an impedance with Z(jω₀) = jX, X > 0 (its dual otherwise), take κ > 0 with Z(κ)/κ = X/ω₀ and Richards'
function

    R(s) = (κ Z(s) − s Z(κ)) / (κ Z(κ) − s Z(s)),        R(±jω₀) = 0,
    Z = [Z(κ) R  ∥  C = 1/(κ Z(κ))]  +  [Z(κ)/R  ∥  L = Z(κ)/κ].

1/R has poles at ±jω₀, so 1/R = α s/(s² + ω₀²) + W with W positive real and two degrees lower; one bracket
holds W/Z(κ), the other its dual, so W is realised once.
"""

from __future__ import annotations

from flint import arb, fmpq

from posreal.admittance import Rational, roots
from posreal.admittance.rational import S
from posreal.network import Network, parallel, series
from posreal.realisation.elements import dual, inerter, scaled, spring
from posreal.realisation.multiprecision import Long, at_axis, shortened, susceptance_slope
from posreal.realisation.preamble import Recurse


def cycle(y: Rational, x: fmpq, arithmetic: Long, recurse: Recurse) -> Network:
    """A network for the admittance of a minimum function that vanishes in Re at ω₀² = x."""
    z = y.inverse()
    if susceptance_slope(z, x) < 0:
        return dual(cycle(z, x, arithmetic, recurse))
    size, kappa, alpha, w = richards(z, x, arithmetic)
    z_kappa = kappa * size
    rest = [] if w.is_zero() else [recurse(w)]
    first = [scaled(part, 1 / z_kappa) for part in rest]
    second = [scaled(dual(part), 1 / z_kappa) for part in rest]
    tank = series(spring(alpha), inerter(alpha / x))
    return series(
        parallel(scaled(tank, 1 / z_kappa), *first, inerter(1 / (kappa * z_kappa))),
        parallel(series(scaled(dual(tank), 1 / z_kappa), *second), spring(kappa / z_kappa)),
    )


def richards(z: Rational, x: fmpq, arithmetic: Long) -> tuple[fmpq, fmpq, fmpq, Rational]:
    """(X/ω₀, κ, α, W) with 1/R = α s/(s² + x) + W; known factors, s − κ and s² + x, are divided by name."""
    size = susceptance_slope(z, x)
    kappa = _kappa(z, size, arithmetic)
    z_kappa = kappa * size
    top = (kappa * z.n - z_kappa * S * z.d) // (S - kappa)
    bottom = (kappa * z_kappa * z.d - S * z.n) // (S - kappa)
    rest = top // (S * S + x)
    # 1/R = bottom/((s² + x) rest)
    (a, b), (c, e) = at_axis(bottom, x), at_axis(rest, x)
    alpha = shortened((b * c - a * e) / (c * c + x * e * e), arithmetic.bits)
    w = Rational(arithmetic.cut((bottom - alpha * S * rest) // (S * S + x)), arithmetic.cut(rest))
    return size, kappa, alpha, w


def _kappa(z: Rational, size: fmpq, arithmetic: Long) -> fmpq:
    """The κ > 0 with Z(κ) = κ X/ω₀, by certified isolation."""
    with roots.precision(arithmetic.bits):
        found = roots.positive_roots(z.n - size * S * z.d)
        balls: list[arb] = [ball for ball, _ in found]
        return shortened(roots.midpoint(balls[0]), arithmetic.bits)
