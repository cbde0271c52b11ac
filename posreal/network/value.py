"""Element values: exact rationals that print as short text and read back the same.

A typed decimal is what it says, 0.3 = 3/10, and a float is taken as the shortest decimal that names it, the
one Python prints: ``Spring(0.3)`` and ``parse("k=0.3")`` are one spring, and the float comes back exactly.

A coefficient of a `Rational` is different: there a float is the binary fraction it is, 0.3 = 5404319552844595/2^54,
because on it hangs whether a computed admittance is positive real. Element values have no such edge (any positive ones
do), but are read and written by people, and as binary fractions they would print with fifty digits.
"""

from __future__ import annotations

from fractions import Fraction
from numbers import Integral, Real
from numbers import Rational as RationalNumber
from typing import Any, TypeAlias

from flint import fmpq, fmpz

from posreal.admittance import exact
from posreal.errors import BadDevice, shown

Value: TypeAlias = "int | float | Fraction | str | fmpq"

LONGEST_DECIMAL = 60  # significant digits; a longer or endless decimal prints as p/q


def read_value(value: Any, whose: str = "The value") -> Fraction:
    """The exact rational meant by a number or by text such as ``"2.45e5"`` or ``"1/3"``.

    Raises
    ------
    BadDevice
        If it is no finite real number that a float can hold.
    """
    if isinstance(value, Fraction):
        number = value
    elif isinstance(value, bool):
        raise BadDevice(f"{whose} is {shown(value)}, which is not a number; give one such as 2.45e5.")
    elif isinstance(value, str | fmpq | fmpz | Integral | RationalNumber):
        number = exact.to_fraction(exact.to_fmpq(value))  # type: ignore[arg-type]
    elif isinstance(value, Real) or type(value).__name__ == "Decimal":
        text = repr(float(value)) if isinstance(value, Real) else str(value)
        if not text.lstrip("-")[:1].isdigit():
            raise BadDevice(f"{whose} is {text}; give a finite number.")
        number = exact.to_fraction(exact.to_fmpq(text))
    else:
        raise BadDevice(f"{whose} is {shown(value)}, which is not a number; give one such as 2.45e5.")
    size = abs(exact.to_float(number))
    if number and not 1e-300 <= size <= 1e300:
        raise BadDevice(f"{whose} is out of range; give a number between 1e-300 and 1e300.")
    return number


def write_value(value: Fraction) -> str:
    """The shortest text that `read_value` reads as exactly this number.

    Examples
    --------
    >>> write_value(Fraction(245000)), write_value(Fraction(3, 10)), write_value(Fraction(1, 3))
    ('245000', '0.3', '1/3')
    """
    places, rest = 0, value.denominator
    for prime in (2, 5):
        power = 0
        while rest % prime == 0:
            rest, power = rest // prime, power + 1
        places = max(places, power)
    if rest != 1 or places > 20 * LONGEST_DECIMAL:
        return f"{value.numerator}/{value.denominator}"
    digits = str(abs(value.numerator) * 10**places // value.denominator)
    mantissa = digits.rstrip("0") or "0"
    exponent = len(digits) - len(mantissa) - places  # value = ±mantissa·10^exponent
    if len(mantissa) > LONGEST_DECIMAL:
        return f"{value.numerator}/{value.denominator}"
    sign = "-" if value < 0 else ""
    leading = len(mantissa) + exponent - 1  # power of ten of the first digit
    if not -5 < leading < 16:
        point = f".{mantissa[1:]}" if len(mantissa) > 1 else ""
        return f"{sign}{mantissa[0]}{point}e{leading}"
    if exponent >= 0:
        return sign + mantissa + "0" * exponent
    padded = mantissa.rjust(1 - exponent, "0")
    return f"{sign}{padded[:exponent]}.{padded[exponent:]}"
