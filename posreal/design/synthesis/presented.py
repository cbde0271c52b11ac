"""From a device in floats to one worth writing down: few digits, no dust, and exactly positive real.

A port-Hamiltonian form is exactly positive real as the rational numbers its floats are, with coefficients of hundreds
of digits. Rounding them can lose positive realness by a hair, as optimal devices touch its boundary; the smallest
parallel damper that repairs it is added, and said.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

from posreal.admittance import Rational, check, is_positive_real

SMALLEST = 1e-12  # N s/m, of a damper worth trying
DUST = 1e-7  # a coefficient that small beside the largest, in scaled units, may be one that wants to be zero


def tidy(H: Rational, acceptable: Callable[[Rational], bool]) -> Rational:
    """Drop coefficients of the scaled device that are dust, if what is left is positive real and `acceptable`.

    An optimum on the boundary of its order (a lossless pole at 0, say) is approached, never reached, in floats.
    """
    for dust in (DUST, DUST * 1e-3):
        clean = Rational(_without_dust(H.numerator, dust), _without_dust(H.denominator, dust))
        if clean != H and not clean.is_zero() and is_positive_real(clean) and acceptable(clean):
            return clean
    return H


def rounded(Y: Rational, digits: int = 15) -> tuple[Rational, str]:
    """Y with coefficients of `digits` significant digits, exactly positive real, and a note if it had to be lifted.

    Parameters
    ----------
    Y : Rational
        Exactly positive real.
    digits : int
        More are taken (up to all) if a damper cannot repair what rounding to so many breaks.
    """
    for precision in (digits, digits + 5, digits + 15, digits + 35):
        short = Y.rounded(precision)
        verdict = check(short)
        if verdict:
            return short, ""
        if not math.isfinite(verdict.margin):
            continue
        for excess in (1.5, 10.0, 100.0, 1e4):
            damper = Fraction(f"{max(-verdict.margin, SMALLEST) * excess:.1e}")
            lifted = (Y | Rational.damper(damper)).rounded(precision)
            if is_positive_real(lifted):
                return lifted, (
                    f"lifted by a parallel damper of {float(damper):g} N s/m: {precision} digits are then positive real"
                )
    return Y, "coefficients are exact and long: rounding them would lose positive realness"


def _without_dust(coefficients: tuple[Fraction, ...], dust: float) -> list[Fraction]:
    largest = max(abs(c) for c in coefficients)
    return [c if abs(c) > dust * largest else Fraction(0) for c in coefficients]
