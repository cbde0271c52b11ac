"""What breaks positive realness, in a form a person can verify."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from flint import fmpq

from posreal.admittance.exact import to_float, to_text


@dataclass(frozen=True)
class NegativeReal:
    """A rational frequency (rad/s) where Re Y(jω) is negative, and its exact value there."""

    omega: Fraction
    value: Fraction

    def __str__(self) -> str:
        rational = to_text(fmpq(self.omega.numerator, self.omega.denominator))
        size = self.value
        value = f"{to_float(size):.6g}" if abs(size) > Fraction(1, 10**300) else "less than zero by under 1e-300"
        place = f"{rational} ≈ {to_float(self.omega):.17g}" if "/" in rational else rational
        return f"Re Y(jω) = {value} at ω = {place} rad/s"


@dataclass(frozen=True)
class RightHalfPlanePole:
    """A pole with positive real part, which means energy without a source; one of a pair if complex."""

    pole: complex

    def __str__(self) -> str:
        real, imag = self.pole.real, abs(self.pole.imag)
        place = f"{real:.12g}" if imag == 0 else f"{real:.12g} ± {imag:.12g}j"
        return f"pole in the right half plane at s = {place}"


@dataclass(frozen=True)
class AxisPole:
    """A pole on the imaginary axis that no spring, inerter or undamped resonance has.

    Attributes
    ----------
    location : float
        The frequency in rad/s: 0, a positive number, or infinity.
    multiplicity : int
        More than 1 is enough to fail.
    residue : complex or None
        At a simple pole; it would have to be real and positive. At infinity, the coefficient of s.
    """

    location: float
    multiplicity: int
    residue: complex | None

    def __str__(self) -> str:
        place = (
            "s = 0"
            if self.location == 0
            else "infinity"
            if math.isinf(self.location)
            else f"s = ±{self.location:.12g}j"
        )
        if self.residue is None:
            return f"pole of multiplicity {self.multiplicity} at {place}"
        real = self.residue.imag == 0
        residue = f"{self.residue.real:.6g}" if real else f"{self.residue.real:.6g}{self.residue.imag:+.6g}j"
        return f"pole at {place} with residue {residue}, which is not {'positive' if real else 'real'}"


Witness: TypeAlias = "NegativeReal | RightHalfPlanePole | AxisPole"


def as_dict(witness: Witness) -> dict[str, Any]:
    """JSON-able form: the kind, the fields and the sentence."""
    fields: dict[str, Any] = {}
    for name, value in asdict(witness).items():
        if isinstance(value, Fraction):
            fields[name] = to_float(value)
            fields[name + "_exact"] = f"{value.numerator}/{value.denominator}" if _short(value) else None
        elif isinstance(value, complex):
            fields[name] = {"real": value.real, "imag": value.imag}
        else:
            fields[name] = "inf" if value == math.inf else value
    return {"kind": type(witness).__name__, **fields, "text": str(witness)}


def _short(value: Fraction) -> bool:
    return max(value.numerator.bit_length(), value.denominator.bit_length()) < 4000
