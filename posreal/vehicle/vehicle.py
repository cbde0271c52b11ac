"""What a vehicle is: parameters, cut open at its places, on its load cases, with the metrics it is judged by."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import ClassVar, Protocol, Self

from posreal.admittance import Rational
from posreal.errors import BadInput, hint
from posreal.metric import ClosedVehicle, Measured, Metric
from posreal.plant.plant import Plant
from posreal.vehicle.flexible_body import FlexibleBody
from posreal.vehicle.place import Place
from posreal.vehicle.track import Direction, Track
from posreal.vehicle.weighting import Weighting

RAIL_BAND = 15.0
"""rad/s, up to which Padé delays keep their phase on a rail vehicle."""

WHOLE = "_whole"
"""Ends the name of a metric over all frequencies whose twin ends at 20 Hz."""


class Vehicle(Protocol):
    """A model that devices are designed for. A solver asks no more than this, and never which vehicle it has.

    Attributes
    ----------
    name : str
    metrics : mapping of name to Metric
        Everything that can be evaluated on this vehicle.
    headline : tuple of str
        The metrics that are always shown.
    columns : tuple of str
        Those that have a column where designs stand side by side, and `compared` those whose improvement has one.
    ride : str
        The mean square by which a search takes its units, on the load case `random`.
    passive : bool
        Whether the vehicle is stable with every passive device.
    body : FlexibleBody or None
        How its body bends; None: not at all.
    direction : {"vertical", "lateral"} or None
        Which irregularity of a track shakes it; None for a vehicle that runs on none.
    irregularity : Track or None
        What it runs on; None: the track of its own source.
    weighting : Weighting or None
        By which the metrics `comfort` are weighted; None: by the standard one, and they are shown only where asked for.
    weighted : mapping of metric to metric
        The weighted twin of a ride figure.
    comfort : tuple of str
        The metrics of the weighted acceleration.
    free : mapping of vehicle parameter to (group of ports, power of s)
        Parameters that may be free in a search, as what they add to a port's admittance.
    pade_band : float or None
        Frequency (rad/s) up to which the delays of the matrix inequalities keep their phase; None: the device's own.
    """

    name: ClassVar[str]

    def __hash__(self) -> int: ...

    @property
    def metrics(self) -> Mapping[str, Metric]: ...

    @property
    def headline(self) -> tuple[str, ...]: ...

    @property
    def columns(self) -> tuple[str, ...]: ...

    @property
    def compared(self) -> tuple[str, ...]: ...

    @property
    def ride(self) -> str: ...

    @property
    def random(self) -> str: ...

    @property
    def body(self) -> FlexibleBody | None: ...

    @property
    def direction(self) -> Direction | None: ...

    @property
    def irregularity(self) -> Track | None: ...

    @property
    def weighting(self) -> Weighting | None: ...

    @property
    def weighted(self) -> Mapping[str, str]: ...

    @property
    def comfort(self) -> tuple[str, ...]: ...

    @property
    def passive(self) -> bool: ...

    @property
    def free(self) -> Mapping[str, tuple[str, int]]: ...

    @property
    def pade_band(self) -> float | None: ...

    @property
    def places(self) -> Mapping[str, Place]:
        """Where devices go, by name."""

    @property
    def V(self) -> float:
        """Speed, m/s."""

    def at(self, speed: float) -> Self:
        """The same vehicle at another speed, m/s."""

    def plant(self, load: str, *, opened: bool = False) -> Plant:
        """The vehicle on a load case, its places open; `opened`: the ports of its free parameters as well."""

    def require_stable(self, closed: ClosedVehicle) -> None:
        """Do nothing if the vehicle is stable with the devices in place.

        Raises
        ------
        Infeasible
        """


def measure(
    vehicle: Vehicle, devices: Mapping[str, Rational], *more: str, confirmed: bool = True
) -> dict[str, Measured]:
    """The headline metrics of a vehicle, and `more` by name, with an admittance in every place.

    Without `confirmed` each is computed one way only.

    Raises
    ------
    BadInput
        For a metric that the vehicle does not have.
    Infeasible
        If the vehicle is not stable.
    """
    closed = ClosedVehicle(vehicle, devices, confirmed=confirmed)
    vehicle.require_stable(closed)
    return {name: closed.value(metric) for name, metric in chosen(vehicle, (*vehicle.headline, *more)).items()}


def gain_output(vehicle: Vehicle, metric: str) -> str | None:
    """The output whose largest gain a metric of a vehicle is; None if it is none."""
    norm = vehicle.metrics[metric].norm() if metric in vehicle.metrics else None
    return norm.output if norm is not None and norm.kind == "H∞" else None


def whole_band_twin(vehicle: Vehicle, metric: str) -> str | None:
    """The metric that is the same figure over all frequencies; None where there is none, or it is that already."""
    return metric + WHOLE if metric + WHOLE in vehicle.metrics else None


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
