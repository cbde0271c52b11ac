"""A weighted sum of metrics of one unit, such as a peak and three standard deviations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from posreal.metric.closed_vehicle import ClosedVehicle
from posreal.metric.measured import Measured
from posreal.metric.metric import Metric


@dataclass(frozen=True)
class WeightedSum:
    """Σ weight · metric."""

    parts: tuple[tuple[float, Metric], ...]
    at: str = ""
    better: Literal["less", "more"] = "less"

    @property
    def unit(self) -> str:
        """That of the parts."""
        return self.parts[0][1].unit

    def measure(self, closed: ClosedVehicle) -> Measured:
        """The value."""
        found = [(weight, closed.value(part)) for weight, part in self.parts]
        apart = max(part.apart for _, part in found)
        return Measured(sum(weight * part.value for weight, part in found), self.unit, self.at, apart)

    def norm(self) -> None:
        """None: it is no system norm."""
