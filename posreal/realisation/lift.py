"""Devices that miss positive real by rounding: the smallest parallel damper that repairs them.

Optimisers return devices on the boundary, where Re Y(jω) touches zero, and rounding puts them to either
side. With poles in order, Y + c is positive real if and only if c ≥ −min Re Y(jω).
"""

from __future__ import annotations

import math

import numpy as np
from flint import fmpq, fmpz

from posreal.admittance import NegativeReal, Rational, check, is_positive_real, require, resistance, roots
from posreal.admittance.exact import to_float

ROUNDING = 1e-6  # a miss below this part of the device's typical |Y| counts as rounding


def lifted(y: Rational, limit: float = ROUNDING) -> tuple[Rational, float]:
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
    if to_float(damper) > limit * typical_size(y):
        return require(y), 0.0
    return y | Rational([damper]), to_float(damper)


def typical_size(y: Rational) -> float:
    """The median of |Y(jω)| over the sizes of the poles and zeros, in N s/m; inf where floats hold none of it."""
    with roots.precision(64):
        corners = [abs(complex(root)) for p in (y.n, y.d) for root, _ in roots.complex_roots(p)]
    omega = np.array([w for w in corners if w > 0] or [1.0])
    for points in (omega, 2 * omega):  # twice as high where all poles and zeros lie on the axis
        sizes = np.abs(y(1j * points))
        usable = sizes[np.isfinite(sizes) & (sizes > 0)]
        if usable.size:
            return float(np.median(usable))
    return math.inf


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
