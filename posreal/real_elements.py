"""Elements as they are made: what comes with each spring, damper and inerter that is bought.

    Y(s) → 1/(1/(Y + c_par) + 1/(k_end/s + c_end))

across the element a damping c_par (the oil or the bearings of an inerter), in series with it the rubber of its ends,
k_end with its own damping c_end; :mod:`posreal.network.as_made` puts them into networks.

A catalogue reads, each table and each line optional::

    source = "whose"
    [inerter]
    parallel_damping = "1 kN s/m"
    end_stiffness = "5 MN/m"
    end_damping = "2 kN s/m"
    [damper]
    end_stiffness = "5 MN/m"
    [spring]
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from posreal.errors import BadInput, hint, listed, plain, shown
from posreal.files import read_toml
from posreal.units import engineering, quantity

_KINDS = {"spring": "k", "damper": "c", "inerter": "b"}
_UNITS = {"parallel_damping": "N*s/m", "end_stiffness": "N/m", "end_damping": "N*s/m"}
_LEAST, _MOST = 1e-15, 1e15  # of a value, SI units


@dataclass(frozen=True)
class Parasitics:
    """What comes with one kind of element.

    Attributes
    ----------
    parallel_damping : float
        Across the element, N s/m; 0 for none.
    end_stiffness : float
        In series with it, N/m; infinite for none.
    end_damping : float
        Beside the end's stiffness, N s/m.
    """

    parallel_damping: float = 0.0
    end_stiffness: float = math.inf
    end_damping: float = 0.0

    @property
    def has_end(self) -> bool:
        """Whether the ends give."""
        return math.isfinite(self.end_stiffness)

    @property
    def is_nothing(self) -> bool:
        """Whether the element is ideal."""
        return not (self.has_end or self.parallel_damping)

    def __str__(self) -> str:
        """``1 kN·s/m beside it, ends of 5 MN/m``."""
        said = [f"{engineering(self.parallel_damping, 'N*s/m')} beside it"] if self.parallel_damping else []
        if self.has_end:
            damped = f" with {engineering(self.end_damping, 'N*s/m')}" if self.end_damping else ""
            said.append(f"ends of {engineering(self.end_stiffness, 'N/m')}{damped}")
        return ", ".join(said) or "ideal"


@dataclass(frozen=True)
class RealElements:
    """What comes with springs, dampers and inerters; a kind that is not named is ideal."""

    spring: Parasitics = Parasitics()
    damper: Parasitics = Parasitics()
    inerter: Parasitics = Parasitics()
    source: str = "judgement"

    def of(self, letter: str) -> Parasitics:
        """What comes with an element of the kind k, c or b."""
        return {"k": self.spring, "c": self.damper, "b": self.inerter}[letter]

    def __str__(self) -> str:
        """``damper with ends of 5 MN/m; inerter with 1 kN·s/m beside it, ends of 5 MN/m (judgement)``."""
        kinds = {name: self.of(letter) for name, letter in _KINDS.items()}
        said = [f"{name} with {kind}" for name, kind in kinds.items() if not kind.is_nothing]
        return f"{'; '.join(said) or 'ideal elements'} ({self.source})"

    def to_dict(self) -> dict[str, Any]:
        """JSON-able, SI units; null where an end does not give."""
        kinds = {name: self.of(letter) for name, letter in _KINDS.items()}
        return {
            name: {key: value if math.isfinite(value) else None for key, value in vars(kind).items()}
            for name, kind in kinds.items()
        } | {"source": self.source}


RAIL = RealElements(
    damper=Parasitics(end_stiffness=5e6),
    inerter=Parasitics(parallel_damping=1e3, end_stiffness=5e6),
)
"""Of a rail vehicle: rubber ends as stiff as the bush of [Jiang2012], and the losses of an inerter as a damping."""
ROAD = RealElements(
    damper=Parasitics(end_stiffness=1e6),
    inerter=Parasitics(parallel_damping=50.0, end_stiffness=1e6),
)
"""Of a car."""


def read_elements(given: str | Path | Mapping[str, Any]) -> RealElements:
    """A TOML catalogue, or a mapping that says the same.

    Raises
    ------
    BadInput
        Naming the key and what would be accepted.
    """
    if isinstance(given, Mapping):
        return _read(given, "elements", "elements")
    if not str(given).endswith(".toml"):
        raise BadInput(f"elements {shown(str(given))} are not known; give real, or a path ending in .toml")
    return _read(read_toml(given), plain(given), plain(given))


def _read(document: Mapping[str, Any], where: str, source: str) -> RealElements:
    found: dict[str, Any] = {"source": source}
    for name, table in document.items():
        if name == "source":
            if not isinstance(table, str):
                raise BadInput(f"{where}: source is {shown(table)}; give a text")
            found[name] = table
        elif name in _KINDS:
            found[name] = _kind(table, f"{where}: {name}")
        else:
            raise BadInput(f"{where}: unknown key {shown(name)}; {hint(name, (*_KINDS, 'source'))}")
    return RealElements(**found)


def _kind(table: Any, where: str) -> Parasitics:
    if not isinstance(table, Mapping):
        raise BadInput(f"{where} must be a table with {listed(_UNITS)}")
    found = {}
    for name, value in table.items():
        if name not in _UNITS:
            raise BadInput(f"{where}: unknown key {shown(name)}; {hint(name, _UNITS)}")
        found[name] = _value(value, _UNITS[name], f"{where}.{name}")
    if "end_damping" in found and "end_stiffness" not in found:
        raise BadInput(f"{where}: end_damping goes with an end_stiffness, which is missing")
    return Parasitics(**found)


def _value(given: Any, unit: str, at: str) -> float:
    if isinstance(given, bool) or not isinstance(given, str | int | float):
        raise BadInput(
            f"{at}: {shown(given)} is no value; give a number in {unit.replace('*', ' ')} or text with a unit"
        )
    try:
        value = quantity(given, unit)
    except BadInput as error:
        raise BadInput(f"{at}: {error}") from None
    if not _LEAST <= value <= _MOST:
        raise BadInput(f"{at}: {shown(given)} is no value; give one from {_LEAST:g} to {_MOST:g}, or leave it out")
    return value
