"""Numbers and polynomials taken as the exact rationals they are.

Every finite float is a rational number, p/2^q; a decimal string is one too. Nothing here rounds.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from fractions import Fraction
from numbers import Integral, Real
from numbers import Rational as RationalNumber
from typing import Any, TypeAlias

import numpy as np
from flint import fmpq, fmpq_mat, fmpq_poly, fmpz

from posreal.errors import BadDevice, shown

Number: TypeAlias = "int | float | Fraction | str | fmpq"

LONGEST_NUMBER = 20_000  # characters of one typed number
LARGEST_EXPONENT = 2_000  # of ten, in a typed number

_NUMBER = re.compile(
    r"\s*(?P<sign>[+-]?)(?P<whole>\d*)(?:\.(?P<part>\d*))?(?:[eE](?P<power>[+-]?\d{1,6}))?(?:\s*/\s*(?P<over>\d+))?\s*",
    re.ASCII,  # other scripts have digits too
)


def to_fmpq(value: Number) -> fmpq:
    """The exact rational a number is.

    Raises
    ------
    BadDevice
        For nan, infinity, a complex number, or text that is not one number.
    """
    if isinstance(value, fmpq):
        return value
    if isinstance(value, fmpz):
        return fmpq(value)
    if isinstance(value, str):
        return _from_text(value)
    if isinstance(value, bool):
        raise BadDevice(f"{value} is not a coefficient; give a number.")
    if isinstance(value, Integral):
        return fmpq(int(value))
    if isinstance(value, RationalNumber):
        return fmpq(int(value.numerator), int(value.denominator))
    if isinstance(value, Real):
        number = float(value)
        if number != number or number in (float("inf"), float("-inf")):
            raise BadDevice(f"{number} is not a coefficient; give finite numbers.")
        return fmpq(*number.as_integer_ratio())
    raise BadDevice(f"{shown(value)} is not a real number; give an integer, a float, a Fraction or text like '2.5e5'.")


def _from_text(text: str) -> fmpq:
    match = _NUMBER.fullmatch(text) if len(text) <= LONGEST_NUMBER else None
    if match is None or not (match["whole"] or match["part"]):
        raise BadDevice(f"{shown(text)} is not a number; write 2.5e5, 0.1 or 5/3.")
    part, power = match["part"] or "", int(match["power"] or 0)
    if abs(power) > LARGEST_EXPONENT:
        raise BadDevice(f"{shown(text)} has an exponent beyond {LARGEST_EXPONENT}; scale the device.")
    power -= len(part)
    over = fmpz(match["over"] or "1")
    if over == 0:
        raise BadDevice(f"{shown(text)} divides by zero.")
    digits = fmpz((match["whole"] or "") + part)
    value = fmpq(digits * fmpz(10) ** max(power, 0), over * fmpz(10) ** max(-power, 0))
    return -value if match["sign"] == "-" else value


def to_fraction(value: fmpq) -> Fraction:
    """A flint rational as a Python one."""
    return Fraction(int(value.p), int(value.q))


def to_float(value: fmpq | Fraction) -> float:
    """The nearest float; ±inf or 0 where it overflows or underflows, never an exception."""
    p, q = (int(value.p), int(value.q)) if isinstance(value, fmpq) else (value.numerator, value.denominator)
    try:
        return p / q
    except OverflowError:
        return float("inf") if p > 0 else float("-inf")


def mantissa(value: fmpq) -> tuple[float, int]:
    """(m, e) with value = m·2^e to float precision and 1/2 < |m| < 2 (or m = 0), whatever the size."""
    p, q = int(value.p), int(value.q)
    if p == 0:
        return 0.0, 0
    e = p.bit_length() - q.bit_length()
    return (p / (q << e) if e >= 0 else (p << -e) / q), e


def to_text(value: fmpq) -> str:
    """An exact, re-readable text: an integer, a short decimal where it terminates, else p/q."""
    p, q = value.p, value.q
    if q == 1:
        return str(p)
    twos = fives = 0
    rest = q
    while rest % 2 == 0 and twos <= 20:
        rest, twos = rest // 2, twos + 1
    while rest % 5 == 0 and fives <= 20:
        rest, fives = rest // 5, fives + 1
    places = max(twos, fives)
    if rest == 1 and places <= 20:
        digits = str(abs(p) * fmpz(10) ** places // q).rjust(places + 1, "0")
        short = f"{'-' if p < 0 else ''}{digits[:-places]}.{digits[-places:]}"
        if len(short) <= 20:
            return short
    return f"{p}/{q}"


def polynomial(coefficients: fmpq_poly | Iterable[Number]) -> fmpq_poly:
    """An exact polynomial from its coefficients in ascending powers."""
    if isinstance(coefficients, fmpq_poly):
        return coefficients
    if isinstance(coefficients, str):
        raise BadDevice("Coefficients are a sequence of numbers; use posreal's parse for text such as 'k/s + c'.")
    return fmpq_poly([to_fmpq(value) for value in coefficients])


def at_minus_s(p: fmpq_poly) -> fmpq_poly:
    """p(−s)."""
    return fmpq_poly([-c if i % 2 else c for i, c in enumerate(p.coeffs())])


def even_part(p: fmpq_poly) -> fmpq_poly:
    """The polynomial e(z) with (p(s) + p(−s))/2 = e(s²)."""
    return fmpq_poly(p.coeffs()[0::2])


def odd_part(p: fmpq_poly) -> fmpq_poly:
    """The polynomial o(z) with (p(s) − p(−s))/2 = s·o(s²)."""
    return fmpq_poly(p.coeffs()[1::2])


def of_square(p: fmpq_poly) -> fmpq_poly:
    """p(s²)."""
    return fmpq_poly([c for pair in ((c, 0) for c in p.coeffs()) for c in pair])


def matrix(entries: Any) -> fmpq_mat:
    """An exact matrix from a two-dimensional array of floats or exact numbers."""
    rows = [[to_fmpq(value) for value in row] for row in np.atleast_2d(np.asarray(entries, dtype=object))]
    return fmpq_mat(len(rows), len(rows[0]), [value for row in rows for value in row])


def transfer_function(a: fmpq_mat, b: fmpq_mat, c: fmpq_mat, d: fmpq) -> tuple[fmpq_poly, fmpq_poly]:
    """Numerator and denominator of D + C (sI − A)⁻¹ B, exactly (not yet coprime).

    det(sI − A + BC) − det(sI − A) = C adj(sI − A) B, the matrix determinant lemma.
    """
    denominator = a.charpoly()
    return (a - b * c).charpoly() - denominator + d * denominator, denominator


def rounded(value: fmpq, digits: int) -> fmpq:
    """The nearest rational with so many significant decimal digits."""
    if value == 0:
        return value
    p, q = abs(value.p), value.q
    power = digits - (len(str(p)) - len(str(q)))  # ten to this, times value, has digits or digits + 1 of them
    scale = fmpq(10) ** power
    while abs(value) * scale >= fmpq(10) ** digits:
        scale, power = scale / 10, power - 1
    scaled = value * scale
    return fmpq((scaled + fmpq(1, 2)).floor()) / scale


def floats(values: Sequence[fmpq]) -> list[float]:
    """Floats of exact numbers."""
    return [to_float(value) for value in values]
