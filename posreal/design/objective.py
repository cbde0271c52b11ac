"""Mean-square metrics as smooth functions of the device's values on a frequency grid.

J = √(S Σₖ wₖ |zₖ|²) with z = z(Y) from the port (:class:`posreal.vehicle.PortResponses`), so

    dJ = Re Σₖ gₖ dYₖ,      gₖ = (S wₖ/J) z̄ₖ ∂zₖ/∂Yₖ

and any parametrisation of the device chains onto that by dY/dθ: element values, state-space matrices.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from posreal.design.mounting import Mounting
from posreal.design.problem import Problem, Vehicle
from posreal.errors import BadInput
from posreal.vehicle import PlanView, PortResponses, QuarterCar, SideView, UserPlant, frequency, gain

Complex = np.ndarray


@dataclass(frozen=True)
class MeanSquare:
    """One mean-square metric of one vehicle.

    Attributes
    ----------
    rule : Quadrature
        The grid, `rule.omega` in rad/s.
    port : PortResponses
        The vehicle on that grid.
    scale : float
        J² = scale · Σ weight |z|², in the metric's unit squared.
    """

    rule: frequency.Quadrature
    port: PortResponses
    scale: float

    @property
    def s(self) -> Complex:
        """The points jω."""
        return 1j * self.rule.omega

    def value_and_slopes(self, Y: Mapping[str, Complex]) -> tuple[float, dict[str, Complex]]:
        """J and, for each port group, g with dJ = Re Σ g dY, for admittances `Y` on the grid."""
        z, dz = self.port.closed(Y)
        J = math.sqrt(self.scale * float(self.rule.weight @ np.abs(z) ** 2))
        back = (self.scale / J) * self.rule.weight * z.conj()
        return J, {group: back * slope for group, slope in dz.items()}

    def of_device(self, Y: Complex, mounting: Mounting) -> tuple[float, Complex]:
        """J and dJ/dY for a device `Y` (values on the grid) in its mounting, with nothing else free."""
        port, inner = mounting.response(Y, self.s)
        J, slopes = self.value_and_slopes({"secondary": port})
        return J, slopes["secondary"] * inner


def mean_square(problem: Problem, *, primary_open: bool = False, panels: int = 12) -> MeanSquare:
    """The problem's ride metric (its objective, or Macc at the vehicle's speed where the objective is gauging).

    ``J1z_…`` to 20 Hz and ``Macc``/``J1y`` on the paper's band by a Gauss rule; ``J1``, ``J3`` on the whole axis.

    Parameters
    ----------
    problem : Problem
    primary_open : bool
        Leave the primary lateral suspension of the plan view open as port group ``primary``.
    panels : int
        Panels a decade of the Gauss rule; results are always re-measured by the metrics' own quadrature.
    """
    name = problem.objective if problem.objective != "max_yv" else "Macc"
    return _mean_square(problem.vehicle, name, primary_open, panels)


@lru_cache(maxsize=128)
def _mean_square(vehicle: Vehicle, metric: str, primary_open: bool, panels: int) -> MeanSquare:
    match vehicle:
        case PlanView() if metric in ("Macc", "J1y"):
            rule = frequency.gauss(vehicle.axle_delay, start=0.005, per_decade=panels)
            plant = vehicle.random_track(primary_open=primary_open)
            return MeanSquare(rule, plant.responses(rule.omega, "body_acceleration"), plant.density)
        case SideView() if metric.startswith("J1z_"):
            rule = frequency.gauss(vehicle.wheel_delays[-1], per_decade=panels)
            plant = vehicle.track()
            port = plant.responses(rule.omega, f"acceleration_{metric[-1]}")
            return MeanSquare(rule, port, plant.density * (100 / vehicle.g) ** 2)
        case QuarterCar() if metric in ("J1", "J3"):
            rule = frequency.whole_line(math.sqrt(vehicle.kt / vehicle.mu), per_decade=panels)
            plant = vehicle.road()
            port = plant.responses(rule.omega, "acceleration" if metric == "J1" else "tyre_force")
            return MeanSquare(rule, port, plant.density)
        case UserPlant() if metric.startswith("rms_") and metric.removeprefix("rms_") in vehicle.plant.outputs:
            own = vehicle.plant
            rule = frequency.whole_line(gain.middle(own), longest_delay=float(own.delays.max()), per_decade=panels)
            return MeanSquare(rule, own.responses(rule.omega, metric.removeprefix("rms_")), own.density)
    raise BadInput(f"{metric} is not a mean-square figure of the {vehicle.name} vehicle")
