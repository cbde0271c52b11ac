"""Limits of the port's admittance: s·Y at 0, the static stiffness, and Y/s at infinity, the inertance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from posreal.metric.closed_vehicle import ClosedVehicle
from posreal.metric.measured import Measured


@dataclass(frozen=True)
class StaticStiffness:
    """lim s·Y(s) at 0 of what a place holds, N/m: exact."""

    place: str = "secondary"
    unit: str = "N/m"
    better: Literal["less", "more"] = "less"

    def measure(self, closed: ClosedVehicle) -> Measured:
        """The value."""
        return Measured(float(closed.devices[self.place].static_stiffness), self.unit)

    def norm(self) -> None:
        """None: it is no system norm."""


@dataclass(frozen=True)
class Inertance:
    """lim Y(s)/s at infinity of what a place holds, kg: exact. An inerter behind a spring does not show in it."""

    place: str = "secondary"
    unit: str = "kg"
    better: Literal["less", "more"] = "less"

    def measure(self, closed: ClosedVehicle) -> Measured:
        """The value."""
        return Measured(float(closed.devices[self.place].inertance), self.unit)

    def norm(self) -> None:
        """None: it is no system norm."""
