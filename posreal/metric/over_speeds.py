"""The largest of a metric over a range of speeds."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from scipy.optimize import minimize_scalar

from posreal.metric.closed_vehicle import ClosedVehicle
from posreal.metric.measured import Measured
from posreal.metric.metric import Norm
from posreal.metric.root_mean_square import RootMeanSquare, SummedRootMeanSquare

EVERY = 9  # speeds of the list, where the figure is not to be confirmed


@dataclass(frozen=True)
class LargestOverSpeeds:
    """The largest of `metric` over the range of `speeds` (m/s), with its speed.

    The speeds of the list are looked at first, by the metric's estimate; about the largest the speed is refined within
    its neighbours. The figure at the speed found is the metric's own. Where it is not to be confirmed, every ninth
    speed is looked at, and from the largest on those beside it as long as it rises.
    """

    metric: SummedRootMeanSquare | RootMeanSquare
    speeds: tuple[float, ...]
    better: Literal["less", "more"] = "less"

    @property
    def unit(self) -> str:
        """That of the metric."""
        return self.metric.unit

    def measure(self, closed: ClosedVehicle) -> Measured:
        """The value and the speed of it."""
        speed = self.worst_speed(closed)
        found, at = self.metric.measure(closed.at(speed)), f"at {speed:.6g} m/s"
        return found if found.at.startswith(at) else replace(found, at=", ".join(filter(None, (at, found.at))))

    def norm(self) -> Norm:
        """That of the metric, at the highest speed."""
        return replace(self.metric.norm(), speed=max(self.speeds))

    def worst_speed(self, closed: ClosedVehicle) -> float:
        """The speed (m/s) at which the metric is largest."""

        def at(speed: float) -> float:
            return self.metric.estimate(closed.at(float(speed)))

        last = len(self.speeds) - 1
        looked_at = range(last + 1) if closed.confirmed else sorted({*range(0, last, EVERY), last})
        values = {i: at(self.speeds[i]) for i in looked_at}
        while True:
            top = max(values, key=values.__getitem__)
            beside = [i for i in (top - 1, top + 1) if 0 <= i <= last and i not in values]
            if not beside:
                break
            values |= {i: at(self.speeds[i]) for i in beside}
        speed = self.speeds[top]
        low, high = self.speeds[max(top - 1, 0)], self.speeds[min(top + 1, last)]
        if low == high or (speed == high and at(speed - 1e-3 * (high - low)) < values[top]):
            return speed
        found = minimize_scalar(lambda v: -at(v), bounds=(low, high), method="bounded", options={"xatol": 1e-5})
        return float(found.x) if -found.fun > values[top] * (1 + 1e-9) else speed
