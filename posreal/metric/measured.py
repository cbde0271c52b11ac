"""A metric's value as it is printed: a number, its unit, where it is attained, and how well it is confirmed."""

from __future__ import annotations

from dataclasses import dataclass, field

from posreal.plant.figures import Settled


@dataclass(frozen=True)
class Measured:
    """A value with its unit; `at` says where it is attained, if that is part of the answer.

    `apart` is the relative difference of the two independent methods that agree on it (see
    :mod:`posreal.plant.figures`); it is below 5e-7, so that six digits may be printed.
    """

    value: float
    unit: str
    at: str = ""
    apart: float = field(default=0.0, compare=False)

    def __str__(self) -> str:
        text = f"{self.value:.6g} {'' if self.unit == '1' else self.unit}".strip()
        return f"{text} ({self.at})" if self.at else text


def measured(settled: Settled, unit: str, at: str = "", *, factor: float = 1.0) -> Measured:
    """A confirmed figure in `unit`, of which the SI unit has `factor`."""
    return Measured(factor * settled.value, unit, at, settled.apart)
