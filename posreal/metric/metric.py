"""What a metric is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from posreal.metric.closed_vehicle import ClosedVehicle
from posreal.metric.measured import Measured


@dataclass(frozen=True)
class Norm:
    """What a metric is in terms of system norms: of one output on one load, times `factor(vehicle)`.

    `stop` is where a root mean square ends, rad/s; inequalities and bounds are over all frequencies.
    """

    kind: Literal["H2", "H∞"]
    load: str
    output: str
    factor: Callable[[Any], float]
    stop: float


class Metric(Protocol):
    """One number by which a device in a vehicle is judged."""

    @property
    def unit(self) -> str:
        """Of the value."""

    @property
    def better(self) -> Literal["less", "more"]:
        """Which way it improves."""

    def measure(self, closed: ClosedVehicle) -> Measured:
        """The value, confirmed by two methods.

        Raises
        ------
        Infeasible
            If the vehicle is not stable, or independent methods do not agree.
        """

    def norm(self) -> Norm | None:
        """The system norm that it is, or at the speed where it is largest; None where it is none."""
