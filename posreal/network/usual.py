"""Element values against what can be bought (:mod:`posreal.ranges`): what lies outside, what stands at an end."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from posreal.network.tree import Network
from posreal.ranges import UNITS, UsualRanges
from posreal.units import engineering

_NAMED = 6  # elements that a sentence names
END = 1e-6  # relative distance from the end of a range at which a value stands there


@dataclass(frozen=True)
class Outside:
    """Something that cannot be bought as it is: an element's value, or the travel of the suspension."""

    name: str
    value: float
    least: float
    greatest: float
    unit: str

    def __str__(self) -> str:
        """``b2 = 16.3 t, above 5 t``."""
        end = f"below {engineering(self.least, self.unit)}"
        if self.value > self.greatest:
            end = f"above {engineering(self.greatest, self.unit)}"
        return f"{self.name} = {engineering(self.value, self.unit)}, {end}"

    def to_dict(self) -> dict[str, Any]:
        """JSON-able, SI units."""
        return {"name": self.name, "value": self.value, "usual": [self.least, self.greatest], "unit": self.unit}


def outside(network: Network, ranges: UsualRanges | None, *, own: Mapping[str, float] | None = None) -> list[Outside]:
    """The elements of a network that cannot be bought, in the order of its names.

    Parameters
    ----------
    network : Network
        With values.
    ranges : UsualRanges or None
    own : mapping of str to float, optional
        Springs of the vehicle itself, by any name; an element of that very stiffness is one of them.
    """
    by_kind = {} if ranges is None else ranges.by_kind
    springs, found = tuple((own or {}).values()), []
    for name, value in network.values().items():
        low, high = by_kind.get(name[0], (value, value))
        if not (_is_one_of(springs, name, value) or low * (1 - END) <= value <= high * (1 + END)):
            found.append(Outside(name, value, low, high, UNITS[name[0]]))
    return found


def at_ends(network: Network, ranges: UsualRanges | None, *, own: Mapping[str, float] | None = None) -> list[str]:
    """Sentences' beginnings: which elements stand at an end of what can be bought; arguments as :func:`outside`."""
    by_kind = {} if ranges is None else ranges.by_kind
    springs, said = tuple((own or {}).values()), []
    for name, value in network.values().items():
        if name[0] not in by_kind or _is_one_of(springs, name, value):
            continue
        for end, called in zip(by_kind[name[0]], ("least", "greatest"), strict=True):
            if abs(value / end - 1) <= END:
                shown = engineering(end, UNITS[name[0]])
                said.append(f"{name} stands at the {called} that can usually be bought, {shown}")
    return said


def _is_one_of(springs: Iterable[float], name: str, value: float) -> bool:
    return name[0] == "k" and any(abs(value / spring - 1) <= END for spring in springs if spring)


def sentence(found: list[Outside], ranges: UsualRanges | None) -> str:
    """What lies outside, as a sentence; empty if nothing does."""
    if not found:
        return ""
    source = "" if ranges is None else f" ({ranges.source})"
    more = f"; and {len(found) - _NAMED} more" if len(found) > _NAMED else ""
    return f"Outside what can usually be bought{source}: {'; '.join(str(one) for one in found[:_NAMED])}{more}."
