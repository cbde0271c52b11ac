"""The ride figure of a design three ways: by frequency, by covariance, and on a simulated track.

The first is the figure's definition, r.m.s. up to 20 Hz (for the quarter-car over all frequencies). The covariance is
exact over all frequencies, delays included, so it exceeds the first by what lies above 20 Hz (and, for J1y, by the step
of the paper's sum). The simulation draws a random track and has a standard error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from posreal.errors import BadInput
from posreal.metric import ClosedVehicle, LargestOverSpeeds
from posreal.plant import time_response
from posreal.specification.design import Design
from posreal.text_table import table


@dataclass(frozen=True)
class ThreeWays:
    """One figure: `by_frequency` to `band`, `by_covariance` over all frequencies, `simulated` ± `error`."""

    metric: str
    unit: str
    band: str
    by_frequency: float
    by_covariance: float
    simulated: float
    error: float

    def __str__(self) -> str:
        rows = [
            [f"by frequency, {self.band}", f"{self.by_frequency:.6g}", ""],
            ["by covariance, all frequencies, delays exact", f"{self.by_covariance:.6g}", ""],
            ["on a simulated random track", f"{self.simulated:.6g}", f"± {self.error:.2g} (standard error)"],
        ]
        return table([f"{self.metric} [{self.unit}]", "", ""], rows, "lrl")

    def to_dict(self) -> dict[str, Any]:
        """JSON-able form."""
        return dict(vars(self))


def three_ways(design: Design, *, seed: int = 0, duration: float = 1200.0) -> ThreeWays:
    """Compute the ride figure of `design` three ways; `duration` is seconds of simulated track.

    Raises
    ------
    BadInput
        If the objective is no ride figure of one vehicle.

    Notes
    -----
    The covariance is infinite where white noise reaches the acceleration directly (an inerter straight between
    wheel and body without a bush).
    """
    vehicle, name = design.problem.vehicle, design.problem.base_objective
    metric = vehicle.metrics.get(name)
    if isinstance(metric, LargestOverSpeeds):  # at the vehicle's own speed instead
        name, metric = next((one, inner) for one, inner in vehicle.metrics.items() if inner is metric.metric)
    norm = None if metric is None else metric.norm()
    if metric is None or norm is None or norm.kind != "H2":
        raise BadInput(f"three ways are there for a ride figure of a vehicle, and {name} is none")
    inside = ClosedVehicle(vehicle, {"secondary": design.port})
    closed, factor = inside.on(norm.load), norm.factor(vehicle)
    whole = math.isinf(norm.stop)
    if whole and closed.plant.delays.any():
        raise BadInput(f"three ways are there for a figure that ends at 20 Hz, and {name} does not")
    by_frequency = factor * closed.rms_by_frequency(norm.output) if whole else metric.measure(inside).value
    value, error = time_response.monte_carlo(closed.shaped_loop(), norm.output, seed=seed, duration=duration)
    return ThreeWays(
        name,
        metric.unit,
        "all frequencies" if whole else f"to {norm.stop / (2 * math.pi):g} Hz",
        by_frequency,
        factor * closed.rms(norm.output).value,
        factor * value,
        factor * error,
    )
