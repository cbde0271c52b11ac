"""The root mean square of an output on a random load: on a band, over all frequencies, or by an even sum."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from posreal.metric.closed_vehicle import ClosedVehicle
from posreal.metric.measured import Measured, measured
from posreal.metric.metric import Norm
from posreal.plant import quadrature
from posreal.plant.modes import shortest_decay

_ENOUGH = 10 * quadrature.BAND  # rad/s: what an acceleration of a body has above 200 Hz chooses no speed
_GAUSS_SEES = 0.07  # damping ratio of a mode that 8 panels a decade see to a thousandth


def one(vehicle: Any) -> float:
    """The SI unit itself."""
    return 1.0


@dataclass(frozen=True)
class RootMeanSquare:
    """√∫ |z|² S dω from `start` to `stop`, rad/s, in `unit`, of which the SI unit has `factor(vehicle)`.

    `stop` is infinite for all frequencies, where the value may be infinite too. `also` is another unit, and how many of
    it the SI unit has, in which the value is said beside.
    """

    load: str
    output: str
    unit: str
    stop: float = math.inf
    factor: Callable[[Any], float] = one
    at: str = ""
    start: float = 0.0
    also: tuple[str, Callable[[Any], float]] | None = None
    better: Literal["less", "more"] = "less"

    def measure(self, closed: ClosedVehicle) -> Measured:
        """The value."""
        plant = closed.on(self.load)
        plant.require_stable()
        settled = (
            plant.rms(self.output)
            if math.isinf(self.stop)
            else plant.band_rms(self.output, self.stop, start=self.start)
        )
        said = [self.at] if self.at else []
        if self.also is not None:
            unit, factor = self.also
            said.append(f"{settled.value * factor(closed.vehicle):.6g} {unit}")
        return measured(settled, self.unit, ", ".join(said), factor=self.factor(closed.vehicle))

    def norm(self) -> Norm:
        """H2, up to where it ends."""
        return Norm("H2", self.load, self.output, self.factor, self.stop, self.start)

    def estimate(self, closed: ClosedVehicle) -> float:
        """The value by a Gauss rule of all frequencies that matter, in SI units, to choose a speed by."""
        plant = closed.on(self.load)
        stop = min(self.stop, _ENOUGH)
        delay = float(plant.plant.delays.max(initial=0.0))
        zeta = -plant.poles.real / np.maximum(np.abs(plant.poles), 1e-300)
        if float(zeta[plant.poles.imag > 0].min(initial=1.0)) > _GAUSS_SEES:
            return plant.rms_on(quadrature.gauss(delay, start=self.start, stop=stop, per_decade=8), self.output)
        return math.sqrt(max(plant.band_mean_square_by_modes(self.output, stop, start=self.start), 0.0))


@dataclass(frozen=True)
class SummedRootMeanSquare:
    """The same as a paper may have it, √(Δω Σ |z|² S) over ω = Δω, 2Δω, … to 20 Hz.

    A mode whose distance from the axis is below `steps` of Δω is passed over by the sum; where that changes it by more
    than `off` of the integral, the integral is said.
    """

    load: str
    output: str
    unit: str
    steps: float = 10.0
    off: float = 1e-3
    better: Literal["less", "more"] = "less"

    def measure(self, closed: ClosedVehicle) -> Measured:
        """The value at the vehicle's speed."""
        rule = quadrature.lateral_sum()
        plant = closed.on(self.load)
        if not closed.confirmed:
            return Measured(self.estimate(closed), self.unit, f"at {closed.vehicle.V:.6g} m/s", math.inf)
        settled = plant.summed_rms(self.output, rule)
        at = f"at {closed.vehicle.V:.6g} m/s"
        step = float(rule.weight[0])
        if shortest_decay(plant.poles, quadrature.BAND) < self.steps * step:
            integral = plant.band_rms(self.output, quadrature.BAND).value
            if abs(integral - settled.value) > self.off * integral:
                at += f"; the sum passes over a resonance in steps of {step:g} rad/s, the integral is {integral:.6g}"
        return measured(settled, self.unit, at)

    def norm(self) -> Norm:
        """H2, up to 20 Hz."""
        half = float(quadrature.lateral_sum().weight[0]) / 2  # the sum is a midpoint rule that starts at Δω/2
        return Norm("H2", self.load, self.output, one, quadrature.BAND, half)

    def estimate(self, closed: ClosedVehicle) -> float:
        """The value well enough to choose a speed by: a Gauss rule, or by modes where one is too light for that.

        By modes too where it is not to be confirmed: the rule's port map is made for many devices in one vehicle.
        """
        plant = closed.on(self.load)
        poles = plant.loop.poles()
        zeta = -poles.real / np.maximum(np.abs(poles), 1e-300)
        if closed.confirmed and float(zeta[poles.imag > 0].min(initial=1.0)) > _GAUSS_SEES:
            delay = float(plant.plant.delays.max(initial=0.0))
            return plant.rms_on(quadrature.gauss(delay, start=0.005, per_decade=8), self.output)
        rule = quadrature.lateral_sum()
        step = float(rule.weight[0])
        if shortest_decay(poles, quadrature.BAND) > self.steps * step:
            return math.sqrt(max(plant.band_mean_square_by_modes(self.output, quadrature.BAND, step / 2), 0.0))
        return math.sqrt(plant.modes.summed(rule.omega, step, self.output))
