"""Values that are listed: preferred numbers R5, R10, R20, R40 [ISO1973] and E3 … E24 [IEC2015], or a maker's own steps.

A file of steps reads, each line optional (a kind that is missing keeps its values)::

    k = "R20"                                # a series
    c = ["10 kN s/m", "15 kN s/m", "22 kN s/m"]
    b = { step = "50 kg" }                   # whole multiples
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from posreal.errors import BadInput, hint, listed, plain, shown
from posreal.files import read_toml
from posreal.units import exact_quantity

_R40 = (
    *(100, 106, 112, 118, 125, 132, 140, 150, 160, 170, 180, 190, 200, 212, 224, 236, 250, 265, 280, 300),
    *(315, 335, 355, 375, 400, 425, 450, 475, 500, 530, 560, 600, 630, 670, 710, 750, 800, 850, 900, 950),
)
_E24 = (
    *(100, 110, 120, 130, 150, 160, 180, 200, 220, 240, 270, 300),
    *(330, 360, 390, 430, 470, 510, 560, 620, 680, 750, 820, 910),
)
SERIES = {
    f"{letter}{n}": tuple(Fraction(number, 100) for number in finest[:: len(finest) // n])
    for letter, finest, sizes in (("R", _R40, (5, 10, 20, 40)), ("E", _E24, (3, 6, 12, 24)))
    for n in sizes
}
"""The numbers from 1 to below 10 of each series."""

_UNITS = {"k": "N/m", "c": "N*s/m", "b": "kg"}
_MOST = 10_000  # values of a list


@dataclass(frozen=True)
class Steps:
    """The values that are listed for one kind of element: a series, a list, or whole multiples of a step.

    Attributes
    ----------
    decade : tuple of Fraction
        Numbers from 1 to below 10, times every power of ten.
    values : tuple of Fraction
        In ascending order, SI units.
    step : Fraction or None
    """

    decade: tuple[Fraction, ...] = ()
    values: tuple[Fraction, ...] = ()
    step: Fraction | None = None

    def around(self, value: float, reach: int) -> list[Fraction]:
        """The listed values nearest to one: `reach` to either side, ascending; fewer at the end of a list."""
        exact = Fraction(value)
        if self.step is not None:
            first = math.floor(exact / self.step)
            near = [self.step * n for n in range(max(1, first - reach + 1), first + reach + 1)] or [self.step]
        elif self.decade:
            power = math.floor(math.log10(value))
            span = range(power - reach - 1, power + reach + 2)
            near = [number * Fraction(10) ** n for n in span for number in self.decade]
        else:
            near = list(self.values)
        below = [one for one in near if one <= exact][-reach:]
        above = [one for one in near if one > exact][:reach]
        return below + above


Listed = Mapping[str, Steps]
"""Steps by kind, k, c or b."""


def read_steps(given: str | Path | Mapping[str, Any]) -> dict[str, Steps]:
    """A series of all kinds by its name, a TOML file, or a mapping that says the same.

    Raises
    ------
    BadInput
        Naming the key and what would be accepted.
    """
    if isinstance(given, Mapping):
        return _read(given, "steps")
    if str(given).endswith(".toml"):
        return _read(read_toml(given), plain(given))
    return dict.fromkeys(_UNITS, _series(str(given), "series"))


def _read(document: Mapping[str, Any], where: str) -> dict[str, Steps]:
    found = {}
    for kind, value in document.items():
        if kind not in _UNITS:
            raise BadInput(f"{where}: unknown key {shown(kind)}; accepted are {listed(_UNITS)}")
        found[kind] = _steps(value, _UNITS[kind], f"{where}: {kind}")
    if not found:
        raise BadInput(f"{where}: no values are listed; give some of {listed(_UNITS)}")
    return found


def _steps(given: Any, unit: str, at: str) -> Steps:
    if isinstance(given, str):
        return _series(given, at)
    if isinstance(given, Mapping):
        if set(given) != {"step"}:
            raise BadInput(f"{at} must have a step and nothing else")
        return Steps(step=_value(given["step"], unit, at))
    if not isinstance(given, list | tuple) or not 0 < len(given) <= _MOST:
        raise BadInput(f'{at} must be a series such as "R20", a list of values, or a table with a step')
    return Steps(values=tuple(sorted({_value(one, unit, at) for one in given})))


def _series(name: str, at: str) -> Steps:
    if name not in SERIES:
        raise BadInput(f"{at}: unknown series {shown(name)}; {hint(name, (*SERIES, 'a path ending in .toml'))}")
    return Steps(decade=SERIES[name])


def _value(given: Any, unit: str, at: str) -> Fraction:
    if isinstance(given, bool) or not isinstance(given, str | int | float):
        raise BadInput(f"{at}: {shown(given)} is no value; give a number or text with a unit")
    try:
        value = exact_quantity(given, unit)
    except BadInput as error:
        raise BadInput(f"{at}: {error}") from None
    if value <= 0:
        raise BadInput(f"{at}: {shown(given)} is no value; give one above 0")
    return value
