"""The ride figure of a design three ways: by frequency, by covariance, and on a simulated track.

The first is the figure's definition, r.m.s. up to 20 Hz (for the quarter-car over all frequencies). The covariance is
exact over all frequencies, delays included, so it exceeds the first by what lies above 20 Hz (and, for J1y, by the step
of the paper's sum). The simulation draws a random track and has a standard error.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from posreal.design import Design
from posreal.errors import BadInput
from posreal.text_table import table
from posreal.vehicle import ClosedLoop, PlanView, QuarterCar, SideView, UserPlant, covariance, metrics, simulation


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
    port, vehicle = design.port, design.problem.vehicle
    problem = design.problem
    if isinstance(vehicle, UserPlant) or problem.goal is not None or problem.base_objective.startswith("gain_"):
        raise BadInput(f"three ways are there for a ride figure of a vehicle, and {problem.base_objective} is none")
    match vehicle:
        case PlanView():
            return _three("J1y", "m/s^2", metrics.lateral_loop(vehicle, port), "body_acceleration",
                          metrics.lateral_rms(vehicle, port), 1.0, seed, duration)  # fmt: skip
        case SideView():
            position = problem.base_objective[-1]
            return _three(f"J1z_{position}", "%g", metrics.vertical_loop(vehicle, port), f"acceleration_{position}",
                          metrics.vertical_ride(vehicle, port, position), 100 / vehicle.g, seed, duration)  # fmt: skip
        case QuarterCar():
            name = problem.base_objective
            output, unit = ("acceleration", "m/s^2") if name == "J1" else ("tyre_force", "N")
            return _three(name, unit, metrics.quarter_car_loop(vehicle, port), output,
                          metrics.quarter_car_by_frequency(vehicle, port, output), 1.0, seed, duration)  # fmt: skip
    raise AssertionError(vehicle)


def _three(
    metric: str,
    unit: str,
    loop: ClosedLoop,
    output: str,
    by_frequency: float,
    scale: float,
    seed: int,
    duration: float,
) -> ThreeWays:
    value, error = simulation.monte_carlo(loop, output, seed=seed, duration=duration)
    band = "all frequencies" if metric in ("J1", "J3") else "to 20 Hz"
    by_covariance = scale * covariance.rms(loop, output)
    return ThreeWays(metric, unit, band, by_frequency, by_covariance, scale * value, scale * error)
