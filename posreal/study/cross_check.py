"""The ride figure of a design three ways: by frequency, by covariance, and in time.

The first is the figure's definition, r.m.s. up to 20 Hz (for the quarter-car over all frequencies). The covariance is
exact over all frequencies, delays included, so it exceeds the first by what lies above 20 Hz (and, for J1y, by the step
of the paper's sum). The simulation draws a random track and has a standard error. A measured track is run through as it
is, whole; its density has no covariance, so the second figure is by frequency too, over all that it has.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from posreal.errors import BadInput
from posreal.metric import ClosedVehicle, LargestOverSpeeds
from posreal.plant import time_response
from posreal.plant.figures import ClosedPlant
from posreal.plant.sampled import SampledDensity
from posreal.specification.design import Design
from posreal.text_table import table
from posreal.vehicle import Vehicle
from posreal.vehicle.track_file import Profile

_FAR = 1000.0  # Hz, beyond which an acceleration of a body has nothing


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
    second: str = "by covariance, all frequencies, delays exact"
    third: str = "on a simulated random track"

    def __str__(self) -> str:
        rows = [
            [f"by frequency, {self.band}", f"{self.by_frequency:.6g}", ""],
            [self.second, f"{self.by_covariance:.6g}", ""],
            [self.third, f"{self.simulated:.6g}", f"± {self.error:.2g} (standard error)"],
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
    labels, band = {}, "all frequencies" if whole else f"to {norm.stop / (2 * math.pi):g} Hz"
    if not whole or isinstance(closed.plant.shaping, SampledDensity):
        by_frequency = metric.measure(inside).value
    elif closed.plant.delays.any():
        by_frequency, band = factor * closed.band_rms(norm.output, 2 * math.pi * _FAR).value, f"to {_FAR:g} Hz"
    else:
        by_frequency = factor * closed.rms_by_frequency(norm.output)
    track = vehicle.irregularity
    if track is not None and track.measured is not None and vehicle.direction in track.measured.profiles:
        assert vehicle.direction is not None
        value, error = _run_through(closed, norm.output, track.measured.profiles[vehicle.direction], vehicle)
        labels = {"second": "by frequency, all that was measured", "third": "the measured track, run through in time"}
    elif isinstance(closed.plant.shaping, SampledDensity):
        raise BadInput(f"three ways are there for a track that a filter has, or a measured one, and {track} is neither")
    else:
        value, error = time_response.monte_carlo(closed.shaped_loop(), norm.output, seed=seed, duration=duration)
    return ThreeWays(
        name,
        metric.unit,
        band,
        by_frequency,
        factor * closed.rms(norm.output).value,
        factor * value,
        factor * error,
        **labels,
    )


def _run_through(closed: ClosedPlant, output: str, profile: Profile, vehicle: Vehicle) -> tuple[float, float]:
    """Root mean square of an output over a measured profile, and its standard error."""
    shaping = closed.plant.shaping
    assert isinstance(shaping, SampledDensity)
    derivative = getattr(shaping.density, "derivative", 1)
    return time_response.run_through(closed.modes, output, profile.pieces, profile.step, vehicle.V, derivative)
