"""Damping ratios of the closed lateral vehicle at many speeds, and their slopes in the device.

For an eigenvalue λ of the closed loop with eigenvectors uᴴ, x (uᴴx = 1) a change of the device moves it by

    dλ = uₖᴴ (dA xₖ + dB v) + t (dC xₖ + dD v) + t v (dk/λ + λ db),    v = Cv x,   t = uᴴBf

with uₖ, xₖ their parts in the device's states: the form that :meth:`Chart.slopes` evaluates. The damping ratio
is ζ = −Re λ/|λ|.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from posreal.admittance import PortHamiltonian, StateSpace
from posreal.design.synthesis.chart import Chart
from posreal.design.synthesis.scale import Scale
from posreal.vehicle import Plant, PlanView, close

Real = np.ndarray
Complex = np.ndarray

LEAST = 4  # modes a speed that are watched: the least damped ones
SEARCH_SPEEDS = (
    1.0,
    2.0,
    3.0,
    5.0,
    8.0,
    12.0,
    17.0,
    22.0,
    27.0,
    32.0,
    37.0,
    42.0,
    46.0,
    49.0,
    51.0,
    53.0,
    54.0,
    55.0,
)


@dataclass(frozen=True)
class Damping:
    """The least damping ratios of a plan-view vehicle over speeds.

    Attributes
    ----------
    vehicle : PlanView
    scale : Scale
    primary : bool
        Whether Kpy and Cpy are unknowns too.
    speeds : tuple of float
        m/s.
    """

    vehicle: PlanView
    scale: Scale
    primary: bool = False
    speeds: tuple[float, ...] = SEARCH_SPEEDS

    @cached_property
    def plants(self) -> tuple[Plant, ...]:
        """The vehicle at each speed, ports open."""
        return tuple(self.vehicle.at(v).random_track(primary_open=self.primary) for v in self.speeds)

    def least(self, device: PortHamiltonian, values: Mapping[str, float]) -> float:
        """The least damping ratio over all speeds and modes."""
        return float(self._modes(device, values)[0].min())

    def ratios_and_slopes(
        self, chart: Chart, theta: Real, values: Mapping[str, float]
    ) -> tuple[Real, Real, Mapping[str, Real]]:
        """ζ (M,) of the watched modes of all speeds, ∂ζ/∂θ (size, M), and ∂ζ/∂ of Kpy and Cpy (M,)."""
        device = chart.device(theta)
        ratio, pole, u, x, plants = self._modes(device, values)
        n0, n, omega = len(self.plants[0].A), chart.order, self.scale.omega
        # with an inerter the states' derivatives answer to it: uᴴ(I − b Bf Cv)⁻¹ stands for uᴴ
        t = np.array([self._answer(plant, device, row[:n0]) for plant, row in zip(plants, u, strict=True)])
        v = np.array([plant.Cv @ row[:n0] for plant, row in zip(plants, x, strict=True)])
        inside = slice(n0, n0 + n)
        xi = np.vstack([x[:, inside].T, v[None, :, 0]])
        eta = np.vstack([-omega * u[:, inside].T, self.scale.damper * t[None, :, 0]])
        slope = chart.slopes(theta, device.L, pole / omega, xi, eta)
        by_theta = _ratio_slope(pole, slope)
        if not self.primary:
            return ratio, by_theta, {}
        answer = (t[:, 1:] * v[:, 1:]).sum(axis=1)
        return ratio, by_theta, {"Kpy": _ratio_slope(pole, answer / pole), "Cpy": _ratio_slope(pole, answer)}

    def _modes(
        self, device: PortHamiltonian, values: Mapping[str, float]
    ) -> tuple[Real, Complex, Complex, Complex, list[Plant]]:
        inside = {"secondary": self._secondary(device), "primary": _static(values)}
        A = np.array([close(plant, inside, shaped=False).A for plant in self.plants])
        poles, right = np.linalg.eig(A)
        left = np.linalg.inv(right)  # rows: uᴴ with uᴴx = 1
        size = np.abs(poles)
        ratio = np.where(poles.imag >= 0, -poles.real / np.where(size > 0, size, 1.0), np.inf)
        order = np.argsort(ratio, axis=1)[:, :LEAST]
        row = np.arange(len(A))[:, None]
        watched = [self.plants[i] for i in range(len(A)) for _ in range(order.shape[1])]
        return (
            ratio[row, order].ravel(),
            poles[row, order].ravel(),
            left[row, order].reshape(-1, A.shape[1]),
            right.transpose(0, 2, 1)[row, order].reshape(-1, A.shape[1]),
            watched,
        )

    def _secondary(self, device: PortHamiltonian) -> StateSpace:
        """The device in SI units, with the vehicle's static spring beside it."""
        form, omega, c0 = device.state_space(), self.scale.omega, self.scale.damper
        return StateSpace(
            omega * form.A,
            omega * form.B,
            c0 * form.C,
            c0 * form.D,
            c0 * omega * form.k + self.vehicle.Ksy,
            c0 * form.b / omega,
        )

    def _answer(self, plant: Plant, device: PortHamiltonian, u: Complex) -> Complex:
        b = np.zeros(len(plant.groups))
        b[0] = self.scale.damper * device.b / self.scale.omega
        return np.linalg.solve(np.eye(len(b)) - (plant.Cv @ plant.Bf).T * b, u @ plant.Bf)


def _static(values: Mapping[str, float]) -> StateSpace:
    """Kpy/s + Cpy."""
    none = np.zeros((0, 0))
    D = np.array([[values.get("Cpy", 0.0)]])
    return StateSpace(none, np.zeros((0, 1)), np.zeros((1, 0)), D, values.get("Kpy", 0.0), 0.0)


def _ratio_slope(pole: Complex, slope: Complex) -> Real:
    """dζ = −Re dλ/|λ| + Re λ Re(λ̄ dλ)/|λ|³."""
    size = np.abs(pole)
    return np.asarray(-slope.real / size + pole.real * (pole.conj() * slope).real / size**3)
