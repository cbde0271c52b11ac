"""Element values as short as the proof allows.

Long arithmetic leaves hundreds of digits. A value that is a plain fraction to far more digits than it
needs to write *is* that fraction; the others are rounded to 17 significant digits, or more where the
network amplifies rounding.
"""

from __future__ import annotations

from fractions import Fraction

from flint import fmpq, fmpz

from posreal.admittance import Rational
from posreal.admittance.exact import rounded, to_fraction
from posreal.admittance.roots import simplest_between
from posreal.network import Element, Lever, Network
from posreal.realisation.elements import revalued
from posreal.realisation.multiprecision import Long
from posreal.realisation.proof import branch_residual

ALLOWED = 1e-12  # residual that rounding may cause
TRIED = (17, 20, 25, 30, 40, 60, 100, 160)


def shortest(network: Network, target: Rational, arithmetic: Long) -> Network:
    """The same network with the shortest values whose residual stays under 1e-12."""
    snapped = revalued(network, lambda part: _plain(part.exact, arithmetic))
    for digits in TRIED:
        short = revalued(snapped, lambda part, digits=digits: _short(part, digits))  # type: ignore[misc]
        if branch_residual(short, target) <= ALLOWED:
            return short
    return snapped


def _plain(value: Fraction, arithmetic: Long) -> Fraction:
    """The simplest fraction within the tolerance, if it is far simpler than chance would have it."""
    exact = fmpq(value.numerator, value.denominator)
    size, sign = abs(exact), 1 if value > 0 else -1
    found = simplest_between(size * (1 - arithmetic.tolerance), size * (1 + arithmetic.tolerance))
    simple = found.p.height_bits() + found.q.height_bits() < arithmetic.bits // 12
    return to_fraction(sign * found) if simple else value


def _short(part: Element, digits: int) -> Fraction:
    value = part.exact
    if max(value.numerator.bit_length(), value.denominator.bit_length()) <= 40 and not isinstance(part, Lever):
        return value  # already short, and exact
    return to_fraction(rounded(fmpq(fmpz(value.numerator), fmpz(value.denominator)), digits))
