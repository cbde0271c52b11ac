"""Taylor coefficients in ζ at a point ω0 of the right half plane, enclosed in balls.

    ζ = (ω0 − s)/(ω0 + s),   s = ω0 (1 − ζ)/(1 + ζ)

maps Re s > 0 onto the unit disc and ω0 to its centre. A state space needs one solve and a recurrence,

    (sI − A)⁻¹ B = (1 + ζ) Σₖ Fᵏ ζᵏ (ω0 − A)⁻¹ B,   F = (ω0 − A)⁻¹ (ω0 + A),

a delay is e^{−sτ} of the series of s. Every float that goes in is the rational number it is, every operation rounds
outwards: the true coefficients of *these* matrices lie in the balls that come out.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TypeAlias

import numpy as np
from flint import arb, arb_mat, arb_series, ctx, fmpq

from posreal.admittance import Rational
from posreal.admittance.exact import to_fmpq
from posreal.errors import BadInput

Series: TypeAlias = arb_series
Array = np.ndarray


@contextmanager
def expansion(length: int, bits: int) -> Iterator[None]:
    """Series of so many coefficients, balls of so many bits, inside the block."""
    before = ctx.cap, ctx.prec
    ctx.cap, ctx.prec = length, bits
    try:
        yield
    finally:
        ctx.cap, ctx.prec = before


def constant(value: Any) -> Series:
    """A number as a series."""
    return arb_series([arb(value)])


def coefficients(series: Series) -> list[arb]:
    """The first ``ctx.cap`` coefficients; zeros where the series ends."""
    return [series[k] for k in range(ctx.cap)]


def laplace(omega0: fmpq) -> Series:
    """s itself: ω0 (1 − ζ)/(1 + ζ)."""
    w = arb(omega0)
    return arb_series([w, -w]) / arb_series([arb(1), arb(1)])


def delay(seconds: float, omega0: fmpq) -> Series:
    """e^{−sτ}."""
    return (-laplace(omega0) * constant(to_fmpq(seconds))).exp() if seconds else constant(1)


def rational(function: Rational, omega0: fmpq) -> Series:
    """A rational function of s, exact coefficients.

    Raises
    ------
    BadInput
        If ω0 is a pole.
    """
    # n(s)/d(s) with s = ω0 (1 − ζ)/(1 + ζ): both homogenised to polynomials in ζ of the same degree
    degree = max(function.n.degree(), function.d.degree(), 0)
    top, bottom = (_homogenised(part.coeffs(), degree, omega0) for part in (function.n, function.d))
    if bottom[0] == 0:
        raise BadInput(f"the expansion point ω0 = {omega0} rad/s is a pole of what stands at the port; choose another")
    return arb_series(top) / arb_series(bottom)


def _homogenised(p: list[fmpq], degree: int, omega0: fmpq) -> list[arb]:
    """Coefficients of Σ pₖ ω0ᵏ (1 − ζ)ᵏ (1 + ζ)^{degree − k}."""
    total = [fmpq(0)] * (degree + 1)
    for k, c in enumerate(p):
        term = [c * omega0**k]
        for factor in [-1] * k + [1] * (degree - k):
            term = [a + factor * b for a, b in zip([*term, fmpq(0)], [fmpq(0), *term], strict=True)]
        total = [a + b for a, b in zip(total, term, strict=True)]
    return [arb(c) for c in total]


def state_space(A: Array, B: Array, C: Array, D: Array, omega0: fmpq) -> list[list[Series]]:
    """D + C (sI − A)⁻¹ B as rows of series.

    Raises
    ------
    BadInput
        If ω0 is an eigenvalue of A.
    """
    n, m = B.shape
    plus, minus = matrix(A), matrix(-A)
    for i in range(n):
        plus[i, i], minus[i, i] = plus[i, i] + arb(omega0), minus[i, i] + arb(omega0)
    try:
        x, F = minus.solve(matrix(B)), minus.solve(plus)
    except ZeroDivisionError:
        raise BadInput(f"the expansion point ω0 = {omega0} rad/s is a pole of the vehicle; choose another") from None
    out = matrix(C)
    terms = []
    for _ in range(ctx.cap):
        terms.append(out * x)
        x = F * x
    one_plus = arb_series([arb(1), arb(1)])
    return [
        [arb_series([term[i, j] for term in terms]) * one_plus + constant(to_fmpq(D[i, j])) for j in range(m)]
        for i in range(len(C))
    ]


def matrix(entries: Array) -> arb_mat:
    """An array of floats, each the rational it is."""
    rows, columns = np.shape(entries)
    return arb_mat(rows, columns, [arb(float(value)) for value in np.ravel(entries)])


def midpoints(series: Series) -> Array:
    """Coefficients rounded to floats."""
    return np.array([float(c) for c in coefficients(series)])
