"""The largest of a metric over a range of speeds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import minimize_scalar

from posreal.metric.closed_vehicle import ClosedVehicle
from posreal.metric.measured import Measured
from posreal.metric.metric import Norm
from posreal.metric.root_mean_square import SummedRootMeanSquare


@dataclass(frozen=True)
class LargestOverSpeeds:
    """The largest of `metric` over the range of `speeds` (m/s), with its speed.

    The speeds of the list are looked at first, by the metric's estimate; about the largest the speed is refined within
    its neighbours. The figure at the speed found is the metric's own.
    """

    metric: SummedRootMeanSquare
    speeds: tuple[float, ...]
    better: Literal["less", "more"] = "less"

    @property
    def unit(self) -> str:
        """That of the metric."""
        return self.metric.unit

    def measure(self, closed: ClosedVehicle) -> Measured:
        """The value and the speed of it."""
        return self.metric.measure(closed.at(self.worst_speed(closed)))

    def norm(self) -> Norm:
        """That of the metric."""
        return self.metric.norm()

    def worst_speed(self, closed: ClosedVehicle) -> float:
        """The speed (m/s) at which the metric is largest."""

        def at(speed: float) -> float:
            return self.metric.estimate(closed.at(float(speed)))

        values = [at(speed) for speed in self.speeds]
        top = int(np.argmax(values))
        speed = self.speeds[top]
        low, high = self.speeds[max(top - 1, 0)], self.speeds[min(top + 1, len(self.speeds) - 1)]
        if low == high or (speed == high and at(speed - 1e-3 * (high - low)) < values[top]):
            return speed
        found = minimize_scalar(lambda v: -at(v), bounds=(low, high), method="bounded", options={"xatol": 1e-5})
        return float(found.x) if -found.fun > values[top] * (1 + 1e-9) else speed
