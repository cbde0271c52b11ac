"""Foster's forms [Foster1924]: one leg for each pole, by partial fractions.

Second form, legs in parallel, for an admittance with simple poles on the imaginary or the negative real axis:

    Y = k/s + b s + Σ α s/(s² + ω²) + Σ r/(s + p) − Σ g p/(s + p) + Y(∞),      g p/(s + p) = g − g s/(s + p)

    α s/(s² + ω²) = spring α + inerter α/ω²;   r/(s + p) = spring r + damper r/p;   g s/(s + p) = damper g
    + inerter g/p.

First form: the same for 1/Y, legs in series. For functions of two kinds of element this is minimal.
"""

from __future__ import annotations

from flint import fmpq

from posreal.admittance import Rational, roots
from posreal.errors import DoesNotApply
from posreal.network import Network, parallel, series
from posreal.realisation.elements import damper, dual, inerter, spring
from posreal.realisation.multiprecision import Long
from posreal.realisation.preamble import axis_legs


def parallel_form(y: Rational, arithmetic: Long) -> Network:
    """Foster's second form.

    Raises
    ------
    DoesNotApply
        If a pole is complex or repeated, or the constant that is left is negative.
    """
    return parallel(*_legs(y, arithmetic, "Foster's second form", "admittance"))


def series_form(y: Rational, arithmetic: Long) -> Network:
    """Foster's first form.

    Raises
    ------
    DoesNotApply
        If a zero is complex or repeated, or the constant that is left is negative.
    """
    return series(*map(dual, _legs(y.inverse(), arithmetic, "Foster's first form", "impedance")))


def _legs(y: Rational, arithmetic: Long, form: str, quantity: str) -> list[Network]:
    legs, rest = axis_legs(y, arithmetic)
    constant = rest.n[rest.d.degree()] if rest.n.degree() == rest.d.degree() else fmpq(0)
    slope = rest.d.derivative()
    for pole, power in _poles(rest, arithmetic):
        if power > 1:
            raise DoesNotApply(f"{form} needs simple poles and the {quantity} has a repeated one; use bott-duffin.")
        if pole is None:
            raise DoesNotApply(f"{form} needs poles on the axes and the {quantity} has complex ones; use bott-duffin.")
        residue = rest.n(-pole) / slope(-pole)
        if residue > 0:
            legs.append(series(spring(residue), damper(residue / pole)))
        else:
            g = -residue / pole
            legs.append(series(damper(g), inerter(g / pole)))
            constant -= g
    size = abs(rest.n(fmpq(1)) / rest.d(fmpq(1))) + abs(constant)
    if abs(constant) > size * arithmetic.tolerance:
        if constant < 0:
            raise DoesNotApply(f"{form} would need a negative damper for this {quantity}; use bott-duffin.")
        legs.append(damper(constant))
    return legs


def _poles(y: Rational, arithmetic: Long) -> list[tuple[fmpq | None, int]]:
    """(p, multiplicity) for each pole −p on the negative real axis, (None, …) for the others."""
    with roots.precision(arithmetic.bits):
        return [
            (-roots.midpoint(root.real) if root.imag == 0 else None, power) for root, power in roots.complex_roots(y.d)
        ]
