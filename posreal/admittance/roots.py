"""Certified roots of exact polynomials, and the signs that hang on them.

Flint isolates the roots of an integer polynomial in balls that are proven to hold one root each, and
a real root is known to be real. A sign that a ball leaves open is settled by doubling the precision.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from typing import Any, TypeVar

from flint import acb, acb_poly, arb, arb_poly, ctx, fmpq, fmpq_poly, fmpz

T = TypeVar("T")
Ball = TypeVar("Ball", arb, acb)

FIRST_PRECISION = 128  # bits
LAST_PRECISION = 1 << 17


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Ball arithmetic with so many bits inside the block."""
    before = ctx.prec
    ctx.prec = bits
    try:
        yield
    finally:
        ctx.prec = before


def settle(attempt: Callable[[], T | None], start: int = FIRST_PRECISION) -> T:
    """Repeat with doubled precision until the balls are fine enough for an answer."""
    bits = start
    while bits <= LAST_PRECISION:
        with precision(bits):
            answer = attempt()
        if answer is not None:
            return answer
        bits *= 2
    raise ArithmeticError("undecided at the highest precision; the question is degenerate")


def square_free(p: fmpq_poly) -> list[tuple[fmpq_poly, int]]:
    """Pairwise coprime square-free factors with their multiplicities, constants left out."""
    return [(factor, power) for factor, power in p.factor_squarefree()[1] if factor.degree() > 0]


def complex_roots(p: fmpq_poly) -> list[tuple[acb, int]]:
    """Every root as a ball with its multiplicity, at the precision in force."""
    return [(root, power) for factor, power in square_free(p) for root in _balls(factor)]


def _balls(factor: fmpq_poly) -> list[acb]:
    found: Any = factor.numer().complex_roots()
    return [root for root, _ in found]


def positive_roots(p: fmpq_poly, odd_only: bool = False) -> list[tuple[arb, int]]:
    """Roots in x > 0 as disjoint positive balls, ascending, with multiplicities.

    Parameters
    ----------
    p : fmpq_poly
        Not zero.
    odd_only : bool
        Leave out the roots of even multiplicity, where the sign does not change.
    """
    factors = []
    for factor, power in square_free(p):
        reduced = factor.right_shift(1) if factor[0] == 0 else factor
        if reduced.degree() > 0 and not (odd_only and power % 2 == 0) and _sign_changes(reduced):
            factors.append((reduced, power))
    if not factors:
        return []

    def attempt() -> list[tuple[arb, int]] | None:
        balls = []
        for factor, power in factors:
            for root in _balls(factor):
                if root.imag == 0:
                    if root.real.contains(0):
                        return None
                    if root.real > 0:
                        balls.append((root.real, power))
        balls.sort(key=lambda pair: float(pair[0].mid()))
        for (low, _), (high, _) in pairwise(balls):
            if not low < high:
                return None
        return balls

    return settle(attempt, start=max(FIRST_PRECISION, ctx.prec))


def _sign_changes(p: fmpq_poly) -> int:
    """Descartes: no sign change in the coefficients, no positive root."""
    signs = [c > 0 for c in p.coeffs() if c != 0]
    return sum(a != b for a, b in pairwise(signs))


def is_hurwitz(p: fmpq_poly) -> bool:
    """Whether every root has Re < 0: Routh's test, all entries of the first column of one sign."""
    coefficients = p.coeffs()[::-1]
    if len(coefficients) <= 1:
        return True
    if any(c * coefficients[0] <= 0 for c in coefficients):
        return False
    upper, lower = coefficients[0::2], coefficients[1::2]
    while lower:
        if lower[0] * coefficients[0] <= 0:
            return False
        ratio = upper[0] / lower[0]
        following = [u - ratio * v for u, v in zip(upper[1:], [*lower[1:], fmpq(0)], strict=False)]
        upper, lower = lower, following
    return True


def value(p: fmpq_poly, x: Ball) -> Ball:
    """p(x) for a real or a complex ball."""
    return acb_poly(p)(x) if isinstance(x, acb) else arb_poly(p)(x)


def lower_end(ball: arb) -> fmpq:
    """The ball's left end, exactly."""
    return _exact(ball.lower())


def upper_end(ball: arb) -> fmpq:
    """The ball's right end, exactly."""
    return _exact(ball.upper())


def midpoint(ball: arb) -> fmpq:
    """The ball's centre, exactly."""
    return _exact(ball.mid())


def _exact(point: arb) -> fmpq:
    m, e = point.man_exp()
    return fmpq(m) * (fmpq(fmpz(1) << int(e)) if e >= 0 else fmpq(1, fmpz(1) << int(-e)))


def simplest_between(low: fmpq, high: fmpq) -> fmpq:
    """The rational with the smallest denominator in the closed interval 0 ≤ low ≤ high (Stern–Brocot)."""
    wholes = []
    while True:
        whole = low.floor()
        if low == whole or whole + 1 <= high:
            value = fmpq(whole if low == whole else whole + 1)
            break
        wholes.append(whole)
        low, high = 1 / (high - whole), 1 / (low - whole)
    for whole in reversed(wholes):
        value = whole + 1 / value
    return value
