"""A body that bends: vertical bending modes of a uniform free–free beam, or measured ones.

With nothing but the first frequency and damping ratio, the beam has the body's own mass m and pitch inertia I, so that
L = √(12 I/m), and its other frequencies follow from the first by (β_n/β_1)². For h = β_n L and ξ = x/L from the middle,

    n odd, symmetric:         X_n = cos(hξ)/cos(h/2) + cosh(hξ)/cosh(h/2),        cos h cosh h = 1
    n even, antisymmetric:    X_n = sin(hξ)/sin(h/2) + sinh(hξ)/sinh(h/2)

is 2 at the ends, and its modal mass is m. The body's displacement is w(x) = zv + x θv + Σ X_n(x) q_n with

    m (q̈ + 2ζω q̇ + ω² q) = X(l) F1 + X(−l) F2,

so symmetric modes enter bounce alone, antisymmetric ones pitch alone, and the two loops stay two [Rao2007].
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from scipy.optimize import brentq

from posreal.errors import BadInput, hint, listed, shown
from posreal.units import quantity

BEAM_ENDS = 25.0  # Hz: above, a coach is no beam any more
_MOST = 6  # modes
_LOWEST, _HIGHEST = 0.1, 1000.0  # Hz


@dataclass(frozen=True)
class BodyMode:
    """One mode as the equations need it: rad/s, damping ratio, modal mass in kg, and the shape where it counts."""

    omega: float
    damping: float
    mass: float
    front: float
    rear: float
    middle: float


@dataclass(frozen=True)
class MeasuredMode:
    """A mode of one's own.

    Attributes
    ----------
    frequency : Hz
    damping : ratio
    symmetric : bool
        Whether both bogies see the same of it; otherwise they see opposite amounts.
    at_bogie, at_middle : float or None
        Shape over the leading bogie and in the middle, for a modal mass that is the body's; None: the beam's.
    """

    frequency: float
    damping: float = 0.015
    symmetric: bool = True
    at_bogie: float | None = None
    at_middle: float | None = None

    def __post_init__(self) -> None:
        _checked(self.frequency, self.damping)
        for value in (self.at_bogie, self.at_middle):
            if value is not None and not math.isfinite(value):
                raise BadInput(f"the shape of a body mode is {value:g}; it must be finite")
        if not self.symmetric and self.at_middle not in (None, 0):
            raise BadInput("an antisymmetric mode of the body has nothing in the middle; leave at_middle out")


@dataclass(frozen=True)
class FlexibleBody:
    """Bending of the body: `count` modes of a beam whose first has `frequency` (Hz) and `damping`, or measured ones.

    Raises
    ------
    BadInput
        For a frequency, a damping ratio or a number of modes that is none.
    """

    frequency: float = 8.5
    damping: float = 0.015
    count: int = 1
    measured: tuple[MeasuredMode, ...] = ()

    def __post_init__(self) -> None:
        _checked(self.frequency, self.damping)
        if not 1 <= max(self.count, len(self.measured)) <= _MOST:
            raise BadInput(f"a flexible body has from 1 to {_MOST} modes, not {max(self.count, len(self.measured))}")

    def __str__(self) -> str:
        if self.measured:
            return "flexible, measured at " + ", ".join(f"{mode.frequency:g}" for mode in self.measured) + " Hz"
        modes = "" if self.count == 1 else f", {self.count} modes"
        return f"flexible, {self.frequency:g} Hz, {100 * self.damping:g} %{modes}"

    @property
    def text(self) -> str | None:
        """What :func:`read_body` makes it of again, to the last digit; None for measured modes."""
        return None if self.measured else f"{self.frequency!r},{self.damping!r},{self.count}"

    @property
    def highest(self) -> float:
        """The highest frequency, Hz."""
        if self.measured:
            return max(mode.frequency for mode in self.measured)
        return self.frequency * (beam_root(self.count) / beam_root(1)) ** 2

    def modes(self, mass: float, inertia: float, arm: float) -> tuple[BodyMode, ...]:
        """The modes of a body of so much mass (kg) and pitch inertia (kg m²), bogies at ± `arm` (m).

        Raises
        ------
        BadInput
            If the bogies stand beyond the ends of the beam.
        """
        length = math.sqrt(12 * inertia / mass)
        if arm > length / 2 and any(mode.at_bogie is None for mode in self.measured or (MeasuredMode(1.0),)):
            raise BadInput(
                f"a uniform body of this mass and pitch inertia is {length:.4g} m long, and the bogies stand "
                f"{2 * arm:g} m apart; give measured modes"
            )
        found = []
        for n in range(1, 1 + (len(self.measured) or self.count)):
            own = self.measured[n - 1] if self.measured else None
            number = n if own is None else _like(self.measured, n)
            frequency = self.frequency * (beam_root(n) / beam_root(1)) ** 2 if own is None else own.frequency
            symmetric = number % 2 == 1
            at_bogie = None if own is None else own.at_bogie
            at_middle = None if own is None else own.at_middle
            bogie = beam_shape(number, arm / length) if at_bogie is None else at_bogie
            middle = (beam_shape(number, 0.0) if at_middle is None else at_middle) if symmetric else 0.0
            found.append(
                BodyMode(
                    2 * math.pi * frequency,
                    self.damping if own is None else own.damping,
                    mass,
                    bogie,
                    bogie if symmetric else -bogie,
                    middle,
                )
            )
        return tuple(found)


def _like(modes: Sequence[MeasuredMode], n: int) -> int:
    """The number of the beam's mode whose shape the n-th measured one has by default: the next of its symmetry."""
    same = sum(one.symmetric == modes[n - 1].symmetric for one in modes[:n])
    return 2 * same - 1 if modes[n - 1].symmetric else 2 * same


def _checked(frequency: float, damping: float) -> None:
    if not _LOWEST <= frequency <= _HIGHEST:
        raise BadInput(f"a body mode at {frequency:g} Hz; give from {_LOWEST:g} to {_HIGHEST:g} Hz")
    if not 0 < damping < 1:
        raise BadInput(f"a body mode of damping ratio {damping:g}; it must be above 0 and below 1")


@lru_cache
def beam_root(n: int) -> float:
    """β_n L of a free–free beam, the n-th positive root of cos h cosh h = 1."""
    near = (2 * n + 1) * math.pi / 2
    return float(brentq(lambda h: math.cos(h) - 1 / math.cosh(h), near - 0.1, near + 0.1, xtol=1e-14))


def beam_shape(n: int, place: float) -> float:
    """X_n at a place x/L from the middle, 2 at the end."""
    h = beam_root(n)
    if n % 2 == 1:
        return math.cos(h * place) / math.cos(h / 2) + math.cosh(h * place) / math.cosh(h / 2)
    return math.sin(h * place) / math.sin(h / 2) + math.sinh(h * place) / math.sinh(h / 2)


def read_modes(tables: Any, where: str) -> FlexibleBody:
    """``[[side-view.modes]]`` of a vehicle file: f, zeta, and if wanted symmetric, at_bogie, at_middle.

    Raises
    ------
    BadInput
        Naming the key.
    """
    if not isinstance(tables, list) or not tables or not all(isinstance(one, dict) for one in tables):
        raise BadInput(f"{where}: modes are tables of their own, such as [[side-view.modes]] with f and zeta")
    return FlexibleBody(measured=tuple(_read_mode(one, where) for one in tables))


_KEYS = ("f", "zeta", "symmetric", "at_bogie", "at_middle")


def _read_mode(table: Mapping[str, Any], where: str) -> MeasuredMode:
    for key in table:
        if key not in _KEYS:
            raise BadInput(f"{where}: a body mode has no {shown(key)}; {hint(key, _KEYS)}")
    if "f" not in table:
        raise BadInput(f'{where}: a body mode needs its frequency f, such as "8.5 Hz"')
    symmetric = table.get("symmetric", True)
    if not isinstance(symmetric, bool):
        raise BadInput(f"{where}: symmetric is {shown(symmetric)}; accepted are {listed(('true', 'false'))}")
    numbers = {key: _number(table[key], key, where) for key in ("zeta", "at_bogie", "at_middle") if key in table}
    return MeasuredMode(
        hertz(table["f"], where),
        numbers.get("zeta", 0.015),
        symmetric,
        numbers.get("at_bogie"),
        numbers.get("at_middle"),
    )


def _number(value: Any, key: str, where: str) -> float:
    if isinstance(value, str):
        return quantity(value, "1")
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise BadInput(f"{where}: {key} of a body mode is {shown(value)}, not a number")
    return float(value)


def hertz(value: Any, where: str) -> float:
    """A frequency in Hz from a number or a text with a unit."""
    if isinstance(value, str):
        return quantity(value, "rad/s") / (2 * math.pi)
    return _number(value, "f", where)


def read_body(text: str) -> FlexibleBody | None:
    """``rigid``, ``flexible``, or the first mode as in ``8.5 Hz``, ``8.5 Hz,1.5%`` or ``8.5 Hz,1.5%,2`` (modes).

    Raises
    ------
    BadInput
    """
    if text == "rigid":
        return None
    if text == "flexible":
        return FlexibleBody()
    parts = [part.strip() for part in text.split(",")]
    try:
        if not 1 <= len(parts) <= 3:
            raise ValueError
        try:
            frequency = float(parts[0])
        except ValueError:
            frequency = hertz(parts[0], "body")
        damping = quantity(parts[1], "1") if len(parts) > 1 else FlexibleBody.damping
        count = int(parts[2]) if len(parts) > 2 else 1
    except (ValueError, BadInput):
        raise BadInput(
            f"body {shown(text)} is none; give rigid, flexible, or its first mode, damping and number of modes as in "
            "'8.5 Hz,1.5%,2'"
        ) from None
    return FlexibleBody(frequency, damping, count)
