"""A vehicle with devices in its places: what metrics are measured on, so that they share what is costly."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, Self

from posreal.admittance import Rational
from posreal.metric.measured import Measured
from posreal.plant.figures import ClosedPlant
from posreal.plant.plant import Plant


class Cut(Protocol):
    """A vehicle as far as a metric asks: cut open at its places, on each of its load cases, at any speed."""

    @property
    def V(self) -> float:
        """Speed, m/s."""

    def plant(self, load: str) -> Plant:
        """The vehicle on a load case, its places open."""

    def at(self, speed: float) -> Self:
        """The same vehicle at another speed, m/s."""


class Measurable(Protocol):
    """What has a value on a closed vehicle, see :class:`posreal.metric.metric.Metric`."""

    def measure(self, closed: ClosedVehicle) -> Measured:
        """The value."""


class ClosedVehicle:
    """A vehicle with what its places hold, each load case closed once.

    Parameters
    ----------
    vehicle : Cut
    devices : mapping of place to Rational
        The admittance of the whole place, whatever stands beside and behind the device included; of other ports, what
        the vehicle says that they hold.
    confirmed : bool
        Whether figures are confirmed by a second method; without, they are good for looking at many vehicles only.
    """

    def __init__(self, vehicle: Cut, devices: Mapping[str, Rational], *, confirmed: bool = True) -> None:
        self.vehicle, self.devices, self.confirmed = vehicle, {**getattr(vehicle, "held", {}), **devices}, confirmed
        self._closed: dict[str, ClosedPlant] = {}
        self._values: dict[Measurable, Measured] = {}
        self._speeds: dict[float, ClosedVehicle] = {}

    def on(self, load: str) -> ClosedPlant:
        """The closed vehicle on one of its load cases."""
        if load not in self._closed:
            self._closed[load] = ClosedPlant(self.vehicle.plant(load), self.devices, confirmed=self.confirmed)
        return self._closed[load]

    def value(self, metric: Measurable) -> Measured:
        """The value of a metric, measured once: several metrics may be made of it."""
        if metric not in self._values:
            self._values[metric] = metric.measure(self)
        return self._values[metric]

    def at(self, speed: float) -> ClosedVehicle:
        """The same devices at another speed, m/s."""
        if speed == self.vehicle.V:
            return self
        if speed not in self._speeds:
            self._speeds[speed] = ClosedVehicle(self.vehicle.at(speed), self.devices, confirmed=self.confirmed)
        return self._speeds[speed]
