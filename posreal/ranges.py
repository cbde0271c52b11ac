"""What can be bought for a place: the usual ranges of element values, stroke and force.

A file of a user's own reads, each line optional::

    k = ["10 kN/m", "5 MN/m"]       # springs, dampers, inerters: the least and the greatest value
    c = ["0.5 kN s/m", "200 kN s/m"]
    b = ["50 kg", "5 t"]
    stroke = "80 mm"                # greatest, to either side
    force = "30 kN"                 # greatest
    source = "a maker's list"
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from posreal.errors import BadInput, hint, plain, shown
from posreal.files import read_toml
from posreal.units import engineering, quantity

UNITS = {"k": "N/m", "c": "N*s/m", "b": "kg"}
_GREATEST = {"stroke": "m", "force": "N"}
_LEAST, _MOST = 1e-15, 1e15  # of a value, SI units

Pair = tuple[float, float]


@dataclass(frozen=True)
class UsualRanges:
    """Values that can be bought, SI units; None where nothing is said.

    Attributes
    ----------
    k, c, b : (float, float) or None
        The least and the greatest spring, damper and inerter, N/m, N s/m and kg.
    stroke : float or None
        The greatest travel to either side, m.
    force : float or None
        The greatest force, N.
    source : str
        Where the numbers come from, ``judgement`` where nobody published them.
    """

    k: Pair | None = None
    c: Pair | None = None
    b: Pair | None = None
    stroke: float | None = None
    force: float | None = None
    source: str = "judgement"

    @classmethod
    def of_kinds(cls, by_kind: Mapping[str, Pair], source: str = "judgement") -> UsualRanges:
        """Ranges of k, c and b alone."""
        return cls(by_kind.get("k"), by_kind.get("c"), by_kind.get("b"), source=source)

    @property
    def by_kind(self) -> dict[str, Pair]:
        """The ranges of k, c and b that there are."""
        pairs = {"k": self.k, "c": self.c, "b": self.b}
        return {kind: pair for kind, pair in pairs.items() if pair is not None}

    def __str__(self) -> str:
        """``k 10 kN/m to 5 MN/m, …; judgement``."""
        said = [written(self.by_kind)] if self.by_kind else []
        said += [f"stroke ±{engineering(self.stroke, 'm')}"] if self.stroke is not None else []
        said += [f"force {engineering(self.force, 'N')}"] if self.force is not None else []
        return ", ".join(said) + f"; {self.source}"

    def to_toml(self) -> str:
        """The file that says the same."""
        lines = [f'source = "{self.source}"']
        for kind, pair in self.by_kind.items():
            ends = [engineering(end, UNITS[kind], 6, ascii=True).replace("*", " ") for end in pair]
            lines.append(f'{kind} = ["{ends[0]}", "{ends[1]}"]')
        for name, unit in _GREATEST.items():
            if (value := getattr(self, name)) is not None:
                lines.append(f'{name} = "{engineering(value, unit, 6, ascii=True)}"')
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """JSON-able, SI units."""
        pairs = {kind: list(pair) for kind, pair in self.by_kind.items()}
        return pairs | {"stroke": self.stroke, "force": self.force, "source": self.source}


def written(by_kind: Mapping[str, Pair]) -> str:
    """``k 10 kN/m to 5 MN/m, b 50 kg to 5000 kg``."""
    ends = {kind: [engineering(end, UNITS[kind]) for end in pair] for kind, pair in by_kind.items()}
    return ", ".join(f"{kind} {low} to {high}" for kind, (low, high) in ends.items())


def read_ranges(path: str | Path, base: UsualRanges | None = None) -> UsualRanges:
    """A user's own ranges from a TOML file; what it leaves out is as in `base`.

    Raises
    ------
    BadInput
        Naming the file, the key and what would be accepted.
    """
    return ranges_from(read_toml(path), base, plain(path))


def ranges_from(given: Mapping[str, Any], base: UsualRanges | None = None, where: str = "ranges") -> UsualRanges:
    """As :func:`read_ranges`, from a mapping; numbers are in SI units.

    Raises
    ------
    BadInput
    """
    accepted = (*UNITS, *_GREATEST, "source")
    found: dict[str, Any] = {}
    for name, value in given.items():
        at = f"{where}: {plain(name, 40)}"
        if name in UNITS:
            found[name] = _pair(value, UNITS[name], at)
        elif name in _GREATEST:
            found[name] = _value(value, _GREATEST[name], at)
        elif name == "source":
            if not isinstance(value, str):
                raise BadInput(f"{at} is {shown(value)}; give a text")
            found[name] = value
        else:
            raise BadInput(f"{where}: unknown key {shown(name)}; {hint(name, accepted)}")
    found.setdefault("source", where)
    return dataclasses.replace(base or UsualRanges(), **found)


def _pair(given: Any, unit: str, at: str) -> Pair:
    if not isinstance(given, list | tuple) or len(given) != 2:
        raise BadInput(f"{at} must be a list of two, the least and the greatest, such as [1, 2] in {_shown(unit)}")
    low, high = (_value(end, unit, at) for end in given)
    if not low < high:
        raise BadInput(f"{at}: the least, {shown(given[0])}, is not below the greatest, {shown(given[1])}")
    return low, high


def _value(given: Any, unit: str, at: str) -> float:
    if not isinstance(given, str | int | float) or isinstance(given, bool):
        raise BadInput(f"{at}: {shown(given)} is no value; give a number in {_shown(unit)} or text with a unit")
    if isinstance(given, float) and not math.isfinite(given):
        raise BadInput(f"{at}: {given} is no value; give a finite number in {_shown(unit)} or text with a unit")
    try:
        value = quantity(given, unit)
    except BadInput as error:
        raise BadInput(f"{at}: {error}") from None
    if not _LEAST <= value <= _MOST:
        raise BadInput(f"{at}: {shown(given)} is no value; give one from {_LEAST:g} to {_MOST:g} {_shown(unit)}")
    return value


def _shown(unit: str) -> str:
    return unit.replace("*", " ")


JUDGED = "judgement"
SECONDARY = UsualRanges(k=(10e3, 5e6), c=(0.5e3, 200e3), b=(50.0, 5000.0), stroke=0.08, force=30e3, source=JUDGED)
"""A device in a rail vehicle's secondary suspension. Springs no stiffer than the rubber of its ends; dampers from a
lateral one's share to a yaw damper's; inerters of 5 t weigh 55 kg at the inertance of 90 times their mass that
prototypes have reached [MadhamshettyManimala2018]."""
PRIMARY = dataclasses.replace(SECONDARY, c=(0.5e3, 150e3), b=(10.0, 500.0), stroke=0.03)
"""The same at an axle box, where there is less room."""
ROAD = UsualRanges(k=(1e3, 1e6), c=(100.0, 20e3), b=(1.0, 500.0), stroke=0.1, force=10e3, source=JUDGED)
"""A wheel of a car."""
WIDEST = UsualRanges.of_kinds(
    {
        kind: (min(low for low, _ in pairs), max(high for _, high in pairs))
        for kind in UNITS
        for pairs in [[usual.by_kind[kind] for usual in (SECONDARY, PRIMARY, ROAD)]]
    },
    f"for any vehicle here; {JUDGED}",
)
"""What can be bought for some place or other."""
