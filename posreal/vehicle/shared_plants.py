"""Vehicles that differ in nothing but what stands in their ports, on the same plants.

Which primary springs a plan view has need not be known to cut it open: with its free parameters as ports, thousands of
vehicles that are built within tolerances share the plant of each speed, and whatever has been computed on it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

from posreal.admittance import Rational
from posreal.plant.plant import Plant
from posreal.vehicle.vehicle import Vehicle

_POWERS = {-1: Rational.spring, 0: Rational.damper, 1: Rational.inerter}


@dataclass(frozen=True)
class SharedPlants:
    """`vehicle` on the plants of `base`, from which it differs in free parameters only."""

    vehicle: Vehicle
    base: Vehicle

    def __getattr__(self, name: str) -> Any:
        """Whatever the vehicle has."""
        if name.startswith("__") or name in ("vehicle", "base"):
            raise AttributeError(name)
        return getattr(self.vehicle, name)

    @cached_property
    def held(self) -> Mapping[str, Rational]:
        """What stands in the ports besides the device's."""
        found: dict[str, Rational] = {}
        for name, (group, power) in self.vehicle.free.items():
            value = getattr(self.vehicle, name)
            if group != "secondary" and value:
                part = _POWERS[power](value)
                found[group] = found[group] | part if group in found else part
        return found

    def at(self, speed: float) -> SharedPlants:
        """The same at another speed, m/s."""
        return SharedPlants(self.vehicle.at(speed), self.base.at(speed))

    def plant(self, load: str, *, opened: bool = False) -> Plant:
        """The vehicle on a load case, the ports of its free parameters open; another place of it keeps its default."""
        return self.base.plant(load, opened=bool(self.vehicle.free))


def on_plants_of(base: Vehicle, vehicle: Vehicle) -> Vehicle:
    """The vehicle on the plants of another that differs in its free parameters only."""
    return cast(Vehicle, SharedPlants(vehicle, base))
