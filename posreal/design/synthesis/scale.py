"""Units in which a device of any vehicle has numbers near 1: H(s) = Y(s)/c0, or c0/Y(s), with s in units of ω0.

A bush behind the device makes its impedance the natural unknown (the force exists, the velocity is the answer), and
keeps it proper where the best admittance grows like an inerter's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from posreal.admittance import Rational
from posreal.design.objective import mean_square
from posreal.design.problem import Problem


@dataclass(frozen=True)
class Scale:
    """ω0 (rad/s), c0 (N s/m), and whether H is an impedance. Powers of two: no digit is lost in scaling."""

    omega: float
    damper: float
    impedance: bool

    def admittance(self, H: Rational) -> Rational:
        """Y of a scaled H, exactly."""
        slow = H.time_scaled(1 / self.omega)
        return (slow.inverse() if self.impedance else slow).scaled(self.damper)

    def from_admittance(self, Y: Rational) -> Rational:
        """The scaled H of Y, exactly."""
        unit = Y.scaled(1 / self.damper).time_scaled(self.omega)
        return unit.inverse() if self.impedance else unit


def reference(problem: Problem) -> Scale:
    """ω0 from the body on its static spring, c0 the best plain damper, both to a factor of √2."""
    J = mean_square(problem)

    def ride(log_c: float) -> float:
        return J.of_device(np.full(len(J.s), math.exp(log_c), dtype=complex), problem.mounting)[0]

    k, m = _static(problem)
    best = minimize_scalar(ride, bounds=(math.log(math.sqrt(k * m)) - 5, math.log(math.sqrt(k * m)) + 3))
    return Scale(_power_of_two(math.sqrt(k / m)), _power_of_two(math.exp(best.x)), problem.mounting.behind is not None)


def _static(problem: Problem) -> tuple[float, float]:
    """Static stiffness of one port and the sprung mass it carries."""
    vehicle = problem.vehicle
    beside = problem.mounting.beside
    k = float(beside.static_stiffness) if beside is not None else 0.0
    carried = {"plan-view": ("mv", 0.5), "side-view": ("mv", 0.5), "quarter-car": ("ms", 1.0)}[vehicle.name]
    return k, carried[1] * getattr(vehicle, carried[0])


def _power_of_two(value: float) -> float:
    return 2.0 ** round(math.log2(value))
