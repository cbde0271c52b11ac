"""The largest gain over all frequencies, the H∞ norm from the load's inputs to an output."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from posreal.metric.closed_vehicle import ClosedVehicle
from posreal.metric.measured import Measured, measured
from posreal.metric.metric import Norm
from posreal.metric.root_mean_square import one


@dataclass(frozen=True)
class LargestGain:
    """maxω |z/w| of an output; of several independent inputs the largest singular value."""

    load: str
    output: str
    unit: str = "1"
    better: Literal["less", "more"] = "less"

    def measure(self, closed: ClosedVehicle) -> Measured:
        """The value, and the frequency of it."""
        top, omega = closed.on(self.load).largest_gain(self.output)
        where = f"at {omega:.4g} rad/s" if math.isfinite(omega) else "towards infinite frequency"
        return measured(top, self.unit, where)

    def norm(self) -> Norm:
        """H∞."""
        return Norm("H∞", self.load, self.output, one, math.inf)
