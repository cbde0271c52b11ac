"""Devices that miss positive real by rounding: the smallest parallel damper that repairs them.

Optimisers return devices on the boundary, where Re Y(jω) touches zero, and rounding puts them to either side. With
poles in order, Y + c is positive real if and only if c ≥ −min Re Y(jω).
"""

from __future__ import annotations

from flint import fmpq, fmpz

from posreal.admittance import NegativeReal, Rational, check, is_positive_real, require, resistance, roots
from posreal.admittance.exact import to_float
from posreal.realise.long import squared_size

ROUNDING = fmpq(1, 10**6)  # a miss below this part of |Y| where it happens counts as rounding


def lifted(y: Rational, limit: fmpq = ROUNDING) -> tuple[Rational, float]:
    """(positive-real admittance, damper added): the device itself and 0 if it is positive real.

    Raises
    ------
    NotPositiveReal
        If the miss is larger than rounding, or a pole is to blame.
    """
    if is_positive_real(y):
        return y, 0.0
    verdict = check(y)
    damper = smallest_damper(y)
    if not isinstance(verdict.witness, NegativeReal) or damper is None:
        return require(y), 0.0
    E, D = resistance.coprime(*resistance.real_part(y))
    place = resistance.minimum(E, D).x
    size = squared_size(y, place) if place is not None else (y.n.leading_coefficient()) ** 2
    if damper * damper > limit * limit * size:
        return require(y), 0.0
    return y | Rational([damper]), to_float(damper)


def smallest_damper(y: Rational) -> fmpq | None:
    """The least c, to 60 bits, for which Y + c is exactly positive real; None if no damper can do it."""
    E, D = resistance.coprime(*resistance.real_part(y))
    with roots.precision(256):
        least = resistance.minimum(E, D)
    if isinstance(least.value, float):
        return None
    step = max(-least.value, fmpq(0))
    for bits in (60, 50, 40, 20, 8):
        damper = step * (1 + fmpq(1, fmpz(1) << bits))
        if is_positive_real(y | Rational([damper])):
            return damper
    return None
