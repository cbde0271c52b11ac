"""The largest value in time of an output after a load made of ramps: into a curve, onto a slope."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from posreal.metric.closed_vehicle import ClosedVehicle
from posreal.metric.measured import Measured, measured
from posreal.plant.modes import Corners


@dataclass(frozen=True)
class PeakInTime:
    """max |z(t)| over t ≥ 0 after w(t) = Σ change · max(0, t − instant); `factor` of the `unit` make the SI unit."""

    load: str
    output: str
    corners: Corners
    unit: str
    factor: float = 1.0
    at: str = ""
    better: Literal["less", "more"] = "less"

    def measure(self, closed: ClosedVehicle) -> Measured:
        """The value."""
        top, _ = closed.on(self.load).peak(self.output, self.corners)
        return measured(top, self.unit, self.at, factor=self.factor)

    def norm(self) -> None:
        """None: it is no system norm."""
