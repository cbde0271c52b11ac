"""What stands in a model's file as text: numbers, linear forms of coordinates, admittances in s.

All three are the algebra of :mod:`posreal.admittance.parse`, with the names of parameters (and π as ``pi``) in it:
exact, limited in size, never evaluated as code. A number may be given with a unit instead, such as ``"150 kN/m"``,
where no parameter has the unit's name.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from fractions import Fraction

from posreal.admittance import Rational
from posreal.admittance.exact import to_float
from posreal.admittance.parse import read
from posreal.errors import BadDevice, BadInput, shown
from posreal.units import si_quantity

Names = Mapping[str, Fraction]
_WORD = re.compile(r"[A-Za-z_]\w*", re.ASCII)
LARGEST = 1e30  # of a number that a model is made of


def number(text: str, names: Names) -> float:
    """The value of an expression in parameters, or of a number with a unit in SI base units.

    Raises
    ------
    BadInput
        If it is neither, or is no finite number.
    """
    known = {name: Rational([value]) for name, value in names.items()} | {"pi": Rational([Fraction(math.pi)])}
    try:
        value = read(text, Rational, known | {"s": _no_s(names)})
    except BadDevice as error:
        try:
            return float(si_quantity(text)[0])
        except BadInput:
            raise BadInput(str(error)) from None
    return _float(value, text)


def _no_s(names: Names) -> Rational:
    """The parameter of that name, or the Laplace variable, which leaves no number."""
    return Rational([names["s"]]) if "s" in names else Rational([0, 1])


def _float(value: Rational, text: str) -> float:
    if value.degree > 0:
        raise BadInput(f"{shown(text)} depends on s, and a number is wanted here")
    found = 0.0 if value.is_zero() else to_float(value.n[0] / value.d[0])
    if not abs(found) <= LARGEST:
        raise BadInput(f"{shown(text)} is out of range; numbers here are up to {LARGEST:g} in size")
    return found


def admittance(text: str, names: Names) -> Rational:
    """A function of s with parameters in it, exactly.

    Raises
    ------
    BadInput
    """
    try:
        return read(text, Rational, {name: Rational([value]) for name, value in names.items()})
    except BadDevice as error:
        raise BadInput(str(error)) from None


def linear(text: str, coordinates: Sequence[str], names: Names) -> list[float]:
    """The coefficients of a linear form such as ``zb1 - zv - lvx*thv``, one a coordinate.

    It is worked out at 0, at each coordinate alone, and at two points that no other form than a linear one passes.

    Raises
    ------
    BadInput
        If it is not linear, has a part without a coordinate, or none with one.
    """
    zero, one = Rational([0]), Rational([1])
    said = set(_WORD.findall(text))
    within = [name for name in coordinates if name in said]
    known = {name: Rational([value]) for name, value in names.items()} | {"pi": Rational([Fraction(math.pi)])}

    def at(values: dict[str, Rational]) -> Fraction:
        try:
            value = read(text, Rational, known | dict.fromkeys(coordinates, zero) | values)
        except BadDevice as error:
            raise BadInput(str(error)) from None
        if value.degree > 0:
            raise BadInput(f"{shown(text)} depends on s, and a linear form of the coordinates is wanted here")
        return value.numerator[0] / value.denominator[0]

    if at({}) != 0:
        raise BadInput(
            f"{shown(text)} has a part without a coordinate; give a linear form such as {_like(coordinates)}"
        )
    weights = {name: at({name: one}) for name in within}
    for step in (Fraction(3, 7), Fraction(-11, 5)):
        point = {name: step * (step + i) for i, name in enumerate(within, 2)}
        if at({n: Rational([v]) for n, v in point.items()}) != sum(weights[n] * v for n, v in point.items()):
            raise BadInput(f"{shown(text)} is not linear in the coordinates; give a form such as {_like(coordinates)}")
    if not any(weights.values()):
        raise BadInput(f"{shown(text)} is nothing but 0; give a linear form such as {_like(coordinates)}")
    return [float(weights.get(name, 0)) for name in coordinates]


def _like(coordinates: Sequence[str]) -> str:
    return f"'{' - '.join(coordinates[:2])}'"
