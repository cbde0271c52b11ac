"""Brune [Brune1931]: a minimum function with one perfectly coupled pair a cycle, here a spring and a lever.

For an impedance with Z(jω₀) = jX, of either sign,

    L₁ = X/ω₀,   1/(Z − L₁ s) = α s/(s² + ω₀²) + Y₁,   L₂ = 1/α,  C₂ = α/ω₀²,   1/Y₁ = L₃ s + rest,   L₁L₂
    + L₂L₃ + L₃L₁ = 0.

One of L₁ and L₃ is negative, but the tee L₁, L₃, L₂ (L₂ in the leg) is a spring 1/(L₁ + L₂) under a lever
of ratio n = L₂/(L₁ + L₂) about the leg's node, both positive:

    1 ──┬── lever ── b ──┐
        └ k ─┐│pivot     rest
             g ── b₂ ────┴── 0
"""

from __future__ import annotations

from flint import fmpq

from posreal.admittance import Rational
from posreal.admittance.exact import to_fraction
from posreal.admittance.rational import S
from posreal.network import Graph, Lever, Network
from posreal.realisation.elements import inerter, spring
from posreal.realisation.multiprecision import Long, susceptance_slope
from posreal.realisation.preamble import Recurse, without_resonance


def cycle(y: Rational, x: fmpq, arithmetic: Long, recurse: Recurse) -> Network:
    """A network for the admittance of a minimum function that vanishes in Re at ω₀² = x."""
    z = y.inverse()
    first = susceptance_slope(z, x)  # L₁
    shunted = Rational(z.d, z.n - first * S * z.d)
    # The denominator holds s² + x up to rounding; naming the factor makes it so.
    factor = S * S + x
    exactly = Rational(shunted.n, factor * (shunted.d // factor))
    alpha, rest = without_resonance(exactly, x, arithmetic)
    second = 1 / alpha  # L₂
    third = -first * second / (first + second)  # L₃
    remainder = rest.d - third * S * rest.n  # 1/Y₁ − L₃ s, one degree less than its terms
    degree = rest.n.degree()
    after = Rational(rest.n, arithmetic.cut(remainder.truncate(degree + 1)))
    ratio = second / (first + second)
    g, b = 2, 3
    branches = (
        (1, g, spring(1 / (first + second))),
        (g, 0, inerter(alpha / x)),
        (b, 0, recurse(after)),
    )
    return Graph(branches, ((1, g, b, Lever(to_fraction(ratio))),))
