"""A vehicle seen from another of its places: what stands in the others is their default, and belongs to the plant.

Whoever asks sees a vehicle with one place, as all are seen from their first.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, cast

from posreal.admittance import state_space
from posreal.errors import BadInput, listed, shown
from posreal.metric import ClosedVehicle, Metric
from posreal.plant.plant import Plant, absorbed
from posreal.vehicle.flexible_body import FlexibleBody
from posreal.vehicle.place import Place
from posreal.vehicle.track import Direction, Track
from posreal.vehicle.vehicle import Vehicle
from posreal.vehicle.weighting import Weighting

FIRST = "secondary"
"""The place that every vehicle has."""


@dataclass(frozen=True)
class SeenFrom:
    """`vehicle` with its device at `at_place`."""

    vehicle: Vehicle
    at_place: str

    passive: ClassVar[bool] = False  # of what is left when the others are in place, nothing is known
    free: ClassVar[Mapping[str, tuple[str, int]]] = {}

    def __getattr__(self, name: str) -> Any:
        """A parameter of the vehicle."""
        if name.startswith("__") or name == "vehicle":
            raise AttributeError(name)
        return getattr(self.vehicle, name)

    @property
    def name(self) -> str:
        """Of the vehicle, and the place."""
        return f"{self.vehicle.name} at {self.at_place}"

    @property
    def metrics(self) -> Mapping[str, Metric]:
        """The vehicle's."""
        return self.vehicle.metrics

    @property
    def headline(self) -> tuple[str, ...]:
        """The vehicle's."""
        return self.vehicle.headline

    @property
    def columns(self) -> tuple[str, ...]:
        """The vehicle's."""
        return self.vehicle.columns

    @property
    def compared(self) -> tuple[str, ...]:
        """The vehicle's."""
        return self.vehicle.compared

    @property
    def ride(self) -> str:
        """The vehicle's."""
        return self.vehicle.ride

    @property
    def random(self) -> str:
        """The vehicle's."""
        return self.vehicle.random

    @property
    def body(self) -> FlexibleBody | None:
        """The vehicle's."""
        return self.vehicle.body

    @property
    def direction(self) -> Direction | None:
        """The vehicle's."""
        return self.vehicle.direction

    @property
    def irregularity(self) -> Track | None:
        """The vehicle's."""
        return self.vehicle.irregularity

    @property
    def weighting(self) -> Weighting | None:
        """The vehicle's."""
        return self.vehicle.weighting

    @property
    def weighted(self) -> Mapping[str, str]:
        """The vehicle's."""
        return self.vehicle.weighted

    @property
    def comfort(self) -> tuple[str, ...]:
        """The vehicle's."""
        return self.vehicle.comfort

    @property
    def pade_band(self) -> float | None:
        """The vehicle's."""
        return self.vehicle.pade_band

    @property
    def V(self) -> float:
        """Speed, m/s."""
        return self.vehicle.V

    @property
    def places(self) -> Mapping[str, Place]:
        """The one place."""
        return {FIRST: self.vehicle.places[self.at_place]}

    def at(self, speed: float) -> SeenFrom:
        """The same at another speed, m/s."""
        return SeenFrom(self.vehicle.at(speed), self.at_place)

    def plant(self, load: str, *, opened: bool = False) -> Plant:
        """The vehicle on a load case, cut open at the one place."""
        others = {name: place for name, place in self.vehicle.places.items() if name != self.at_place}
        inside = {name: state_space(place.around.port(place.default)) for name, place in others.items()}
        return absorbed(self.vehicle.plant(load, opened=True), inside, group=FIRST)

    def require_stable(self, closed: ClosedVehicle) -> None:
        """As the vehicle does."""
        self.vehicle.require_stable(closed)


def seen_from(vehicle: Vehicle, place: str) -> Vehicle:
    """The vehicle, cut open at one of its places.

    Raises
    ------
    BadInput
        If it has no such place.
    """
    place = getattr(vehicle, "called", {}).get(place, place)
    if place not in vehicle.places:
        raise BadInput(f"the {vehicle.name} vehicle has no place {shown(place)}; it has {listed(vehicle.places)}")
    return vehicle if place == FIRST else cast(Vehicle, SeenFrom(vehicle, place))
