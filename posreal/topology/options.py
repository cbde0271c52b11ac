"""What a search may be told, as text: ``springs=2,inerters=1``, ``k=10 kN/m:5 MN/m``, ``deflection_rms_rear=7.5``."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from posreal.errors import BadInput, hint, shown
from posreal.units import quantity

KINDS = {"springs": "k", "dampers": "c", "inerters": "b", "reactive": "kb"}  # reactive: springs and inerters together
_UNITS = {"k": "N/m", "c": "N*s/m", "b": "kg"}


def read_at_most(text: str) -> dict[str, int]:
    """``springs=2,inerters=1``: no more than so many elements of a kind.

    Raises
    ------
    BadInput
    """
    found: dict[str, int] = {}
    for part in text.split(","):
        name, _, count = (piece.strip() for piece in part.partition("="))
        if name not in KINDS:
            raise BadInput(f"unknown kind of element {shown(name)} in {shown(text)}; {hint(name, KINDS)}")
        if not count.isdecimal() or len(count) > 3:
            raise BadInput(f"{shown(part.strip())} is not a number of elements such as {name}=2")
        found[name] = int(count)
    return found


def read_bounds(texts: Iterable[str]) -> dict[str, tuple[float, float]]:
    """``k=10 kN/m:5 MN/m`` for k, c or b: the least and the greatest value of every such element.

    Raises
    ------
    BadInput
    """
    found: dict[str, tuple[float, float]] = {}
    for text in texts:
        kind, _, rest = (piece.strip() for piece in text.partition("="))
        if kind not in _UNITS:
            raise BadInput(f"unknown element {shown(kind)} in {shown(text)}; accepted are k, c or b")
        low, colon, high = rest.partition(":")
        if not colon:
            raise BadInput(f"{shown(text)} is not a range such as {kind}=10:1e6 (least:greatest, in {_UNITS[kind]})")
        found[kind] = (quantity(low.strip(), _UNITS[kind]), quantity(high.strip(), _UNITS[kind]))
    checked_bounds(found)
    return found


def read_limits(texts: Iterable[str]) -> dict[str, float]:
    """``deflection_rms_rear=7.5``: a metric may not exceed this, in its own unit.

    Raises
    ------
    BadInput
    """
    found: dict[str, float] = {}
    for text in texts:
        name, _, value = (piece.strip() for piece in text.partition("="))
        try:
            found[name] = float(value)
        except ValueError:
            raise BadInput(f"{shown(text)} is not a limit such as deflection_rms_rear=7.5") from None
    return found


def checked_at_most(at_most: Mapping[str, int] | None) -> dict[str, int]:
    """Counts by letters, from counts by ``springs``, ``dampers``, ``inerters``, ``reactive``."""
    found: dict[str, int] = {}
    for name, count in (at_most or {}).items():
        if name not in KINDS:
            raise BadInput(f"unknown kind of element {shown(name)}; {hint(name, KINDS)}")
        if isinstance(count, bool) or not isinstance(count, int) or count < 0:
            raise BadInput(f"at most {shown(count)} {name}: give a whole number from 0")
        found[KINDS[name]] = count
    return found


def checked_bounds(bounds: Mapping[str, tuple[float, float]] | None) -> dict[str, tuple[float, float]]:
    """Bounds by letter with the lower one first."""
    found: dict[str, tuple[float, float]] = {}
    for kind, pair in (bounds or {}).items():
        if kind not in _UNITS:
            raise BadInput(f"unknown element {shown(kind)} with bounds; accepted are k, c or b")
        low, high = (float(value) for value in pair)
        if not (math.isfinite(high) and 0 < low < high):
            raise BadInput(f"bounds of {kind} are {low:g} and {high:g}; the first must be above 0 and below the second")
        found[kind] = (low, high)
    return found
