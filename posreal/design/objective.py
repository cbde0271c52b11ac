"""Mean-square metrics as smooth functions of the device's values on a frequency grid.

J = √(S Σₖ wₖ |zₖ|²) with z = z(Y) from the port (:class:`posreal.plant.plant.PortResponses`), so

    dJ = Re Σₖ gₖ dYₖ,      gₖ = (S wₖ/J) z̄ₖ ∂zₖ/∂Yₖ

and any parametrisation of the device chains onto that by dY/dθ: element values, state-space matrices.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from posreal.design.mounting import Mounting
from posreal.design.problem import Problem, Vehicle
from posreal.errors import BadInput
from posreal.plant import hinf_norm, quadrature
from posreal.plant.plant import PortResponses
from posreal.vehicle import PlanView, QuarterCar, SideView, UserPlant

Complex = np.ndarray

_LIGHT = 0.04  # damping ratio of a resonance that 12 panels a decade see to a thousandth of its mean square
_RIPPLE = (
    3000.0  # rad/s, to which delays are followed over the whole band: beyond it is 1e-6 of the side view's mean square
)


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
    squares : tuple of float
        Share of each pair of an output and a process in the weight.
    """

    rule: quadrature.Quadrature
    port: PortResponses
    scale: float
    squares: tuple[float, ...] = (1.0,)

    @cached_property
    def weight(self) -> np.ndarray:
        """Of |z|² in every row of the port."""
        return np.outer(self.squares, self.rule.weight).ravel()

    @property
    def s(self) -> Complex:
        """The points jω."""
        return 1j * self.rule.omega

    def value_and_slopes(self, Y: Mapping[str, Complex]) -> tuple[float, dict[str, Complex]]:
        """J and, for each port group, g with dJ = Re Σ g dY, for admittances `Y` on the grid."""
        z, dz = self.port.closed(Y)
        J = math.sqrt(self.scale * float(self.weight @ np.abs(z) ** 2))
        back = (self.scale / J) * self.weight * z.conj()
        return J, {group: self.port.over_grid(back * slope) for group, slope in dz.items()}

    def of_device(self, Y: Complex, mounting: Mounting) -> tuple[float, Complex]:
        """J and dJ/dY for a device `Y` (values on the grid) in its mounting, with nothing else free."""
        port, inner = mounting.response(Y, self.s)
        J, slopes = self.value_and_slopes({"secondary": port})
        return J, slopes["secondary"] * inner


def mean_square(problem: Problem, *, primary_open: bool = False, panels: int = 12) -> MeanSquare:
    """The problem's mean-square objective (Macc at the vehicle's speed where the objective is gauging).

    ``J1z_…`` to 20 Hz and ``Macc``/``J1y`` on the paper's band by a Gauss rule; the others, ``J1z_…_whole`` among them,
    on the whole axis. The norm of several figures of one vehicle is a mean square too.

    Parameters
    ----------
    problem : Problem
    primary_open : bool
        Leave the primary lateral suspension of the plan view open as port group ``primary``.
    panels : int
        Panels a decade of the Gauss rule; results are always re-measured by the metrics' own quadrature.

    Raises
    ------
    BadInput
        If the objective is no mean square.
    """
    name = problem.objective if problem.objective != "max_yv" else "Macc"
    norm = problem.goal is not None and problem.goal.kind == "norm"
    parts = problem.goal.parts if norm and problem.goal is not None else ((name, 1.0),)
    return _mean_square(problem.vehicle, tuple(parts), primary_open, panels)


@lru_cache(maxsize=128)
def _mean_square(vehicle: Vehicle, parts: tuple[tuple[str, float], ...], primary_open: bool, panels: int) -> MeanSquare:
    match vehicle:
        case PlanView():
            rule = quadrature.gauss(vehicle.axle_delay, start=0.005, per_decade=panels)
            plant = vehicle.random_track(primary_open=primary_open)
            known = dict.fromkeys(("Macc", "J1y"), ("body_acceleration", 1.0))
        case SideView():
            plant, latest = vehicle.track(), vehicle.wheel_delays[-1]
            whole = parts[0][0].endswith("_whole")
            rule = (
                quadrature.whole_line(hinf_norm.middle(plant), longest_delay=latest, ripple=_RIPPLE, per_decade=panels)
                if whole
                else quadrature.gauss(latest, per_decade=panels)
            )
            suffix = "_whole" if whole else ""
            known = {f"J1z_{point}{suffix}": (f"acceleration_{point}", 100 / vehicle.g) for point in "LMT"}
        case QuarterCar():
            rule = quadrature.whole_line(math.sqrt(vehicle.kt / vehicle.mu), per_decade=panels)
            plant = vehicle.road()
            known = {"J1": ("acceleration", 1.0), "J3": ("tyre_force", 1.0)}
        case UserPlant():
            plant = vehicle.shaken
            delay = float(plant.delays.max())
            fine = round(panels * min(4.0, max(1.0, _LIGHT / hinf_norm.least_damping(plant))))
            rule = quadrature.whole_line(hinf_norm.middle(plant), longest_delay=delay, per_decade=fine)
            known = {f"rms_{output}": (output, 1.0) for output in plant.outputs}
    for name, _ in parts:
        if name not in known:
            raise BadInput(f"{name} is not a mean-square figure of the {vehicle.name} vehicle")
    port = plant.responses(rule.omega, *(known[name][0] for name, _ in parts))
    squares = tuple((weight * known[name][1]) ** 2 * share for name, weight in parts for share in plant.shares)
    return MeanSquare(rule, port, plant.density, squares)
