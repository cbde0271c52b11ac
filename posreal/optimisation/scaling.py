"""Units in which a device of any vehicle has numbers near 1: H(s) = Y(s)/c0, or c0/Y(s), with s in units of ω0.

A bush behind the device makes its impedance the natural unknown (the force exists, the velocity is the answer), and
keeps it proper where the best admittance grows like an inerter's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from posreal.admittance import Rational
from posreal.optimisation.mean_square import mean_square, norms
from posreal.specification.problem import Problem


@dataclass(frozen=True)
class Scale:
    """ω0 (rad/s), c0 (N s/m), and whether H is an impedance. Powers of two: no digit is lost in scaling.

    `whole` says that H is the whole strut, which brings its own static spring or bush, as a layout does.
    """

    omega: float
    damper: float
    impedance: bool
    whole: bool = False

    def admittance(self, H: Rational) -> Rational:
        """Y of a scaled H, exactly."""
        slow = H.time_scaled(1 / self.omega)
        return (slow.inverse() if self.impedance else slow).scaled(self.damper)

    def from_admittance(self, Y: Rational) -> Rational:
        """The scaled H of Y, exactly."""
        unit = Y.scaled(1 / self.damper).time_scaled(self.omega)
        return unit.inverse() if self.impedance else unit


STRUT = Scale(1.0, 1.0, impedance=False, whole=True)
"""A layout in SI units."""


def reference(problem: Problem) -> Scale:
    """ω0 from the body on its static spring, c0 the best plain damper, both to a factor of √2.

    Where the place knows of no mass, ω0 is where the response with that damper is: the mean of log ω under |z|².
    """
    J = mean_square(_ride(problem))

    def ride(log_c: float) -> float:
        return J.of_device(np.full(len(J.s), math.exp(log_c), dtype=complex), problem.mounting)[0]

    impedance = problem.mounting.behind is not None
    k, m = _static(problem)
    if not m:
        port = np.einsum("kpp->kp", J.port.Pvf)
        middle = -float(np.log(np.abs(port)).mean())
        best = min(np.linspace(middle - 9, middle + 9, 37), key=ride)
        best = minimize_scalar(ride, bounds=(best - 0.6, best + 0.6), method="bounded").x
        inside = problem.mounting.response(np.full(len(J.s), math.exp(best), dtype=complex), J.s)[0]
        z, _ = J.port.closed({"secondary": inside})
        weight = J.port.over_grid(J.weight * np.abs(z) ** 2)
        omega = math.exp(float(weight @ np.log(J.rule.omega)) / float(weight.sum()))
        return Scale(_power_of_two(omega), _power_of_two(math.exp(best)), impedance)
    best = minimize_scalar(ride, bounds=(math.log(math.sqrt(k * m)) - 5, math.log(math.sqrt(k * m)) + 3))
    return Scale(_power_of_two(math.sqrt(k / m)), _power_of_two(math.exp(best.x)), impedance)


def _ride(problem: Problem) -> Problem:
    """The problem with a mean-square objective at its nominal vehicle: its own, or the first that it is made of."""
    if problem.goal is not None and problem.goal.kind == "norm":
        return replace(problem, objective=problem.goal.name, points=())
    name = problem.goal.parts[0][0] if problem.goal is not None else problem.base_objective
    output = problem.gain_output(name)
    if output is not None:
        name = next((one for one, norm in norms(problem.vehicle, "H2") if norm.output == output), problem.vehicle.ride)
    return replace(problem, objective=name, goal=None, points=())


def _static(problem: Problem) -> tuple[float, float]:
    """Static stiffness of one port and the sprung mass it carries."""
    beside = problem.mounting.beside
    return (float(beside.static_stiffness) if beside is not None else 0.0), problem.place.carried


def _power_of_two(value: float) -> float:
    return 2.0 ** round(math.log2(value))
