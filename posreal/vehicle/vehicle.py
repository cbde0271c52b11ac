"""What a vehicle is: parameters, cut open at its places, on its load cases, with the metrics it is judged by."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import ClassVar, Protocol, Self

from posreal.admittance import Rational
from posreal.errors import BadInput, hint
from posreal.metric import ClosedVehicle, Measured, Metric
from posreal.plant.plant import Plant


class Vehicle(Protocol):
    """A model that devices are designed for. A solver asks no more than this, and never which vehicle it has.

    Attributes
    ----------
    name : str
    metrics : mapping of name to Metric
        Everything that can be evaluated on this vehicle.
    headline : tuple of str
        The metrics that are always shown.
    """

    name: ClassVar[str]

    @property
    def metrics(self) -> Mapping[str, Metric]: ...

    @property
    def headline(self) -> tuple[str, ...]: ...

    @property
    def V(self) -> float:
        """Speed, m/s."""

    def at(self, speed: float) -> Self:
        """The same vehicle at another speed, m/s."""

    def plant(self, load: str) -> Plant:
        """The vehicle on a load case, its places open."""

    def require_stable(self, closed: ClosedVehicle) -> None:
        """Do nothing if the vehicle is stable with the devices in place.

        Raises
        ------
        Infeasible
        """


def measure(vehicle: Vehicle, devices: Mapping[str, Rational], *more: str) -> dict[str, Measured]:
    """The headline metrics of a vehicle, and `more` by name, with an admittance in every place.

    Raises
    ------
    BadInput
        For a metric that the vehicle does not have.
    Infeasible
        If the vehicle is not stable.
    """
    closed = ClosedVehicle(vehicle, devices)
    vehicle.require_stable(closed)
    return {name: closed.value(metric) for name, metric in chosen(vehicle, (*vehicle.headline, *more)).items()}


def chosen(vehicle: Vehicle, names: Iterable[str]) -> dict[str, Metric]:
    """Metrics of a vehicle by name.

    Raises
    ------
    BadInput
        For one that it does not have.
    """
    found = {}
    for name in names:
        if name not in vehicle.metrics:
            raise BadInput(f"the {vehicle.name} vehicle has no metric {name!r}; {hint(name, vehicle.metrics)}")
        found[name] = vehicle.metrics[name]
    return found
