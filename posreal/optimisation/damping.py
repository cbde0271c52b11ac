"""Damping ratios of the closed lateral vehicle at many speeds, and their slopes in the device.

For an eigenvalue λ of the closed loop with eigenvectors uᴴ, x (uᴴx = 1) a change of the device moves it by

    dλ = uₖᴴ (dA xₖ + dB v) + t (dC xₖ + dD v) + t v (dk/λ + λ db),    v = Cv x,   t = uᴴBf

with uₖ, xₖ their parts in the device's states: the form that :meth:`Chart.slopes` evaluates. The damping ratio
is ζ = −Re λ/|λ|.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from posreal.admittance import StateSpace
from posreal.optimisation.coordinates import Coordinates
from posreal.optimisation.scaling import Scale
from posreal.plant.plant import Plant
from posreal.vehicle import Vehicle

Real = np.ndarray
Complex = np.ndarray

LEAST = 4  # modes a speed that are watched: the least damped ones
SEARCH_SPEEDS = (1.0, 6.0, 15.0, 28.0, 42.0, 51.0, 55.0)  # m/s, watched from the start
ALL_SPEEDS = tuple(
    np.unique(
        np.concatenate(
            [
                np.arange(1.0, 3.0, 0.1),
                np.arange(3.0, 10.0, 0.25),
                np.arange(10.0, 50.0, 0.5),
                np.arange(50.0, 55.05, 0.1),
            ]
        ).round(9)
    ).tolist()
)
"""Every speed, m/s, at which a result keeps its damping: the integers of [Jiang2012] and between."""


@dataclass(frozen=True)
class Damping:
    """The least damping ratios of a plan-view vehicle over speeds.

    Attributes
    ----------
    vehicle : Vehicle
    scale : Scale
    free : tuple of str
        Which of Ksy, Kpy and Cpy are unknowns too.
    speeds : tuple of float
        m/s.
    """

    vehicle: Vehicle
    scale: Scale
    free: tuple[str, ...] = ()
    speeds: tuple[float, ...] = SEARCH_SPEEDS

    @cached_property
    def plants(self) -> tuple[Plant, ...]:
        """The vehicle at each speed, ports open."""
        return tuple(_at(self.vehicle, self._opened, speed) for speed in self.speeds)

    @cached_property
    def _open(self) -> Real:
        """A of the open vehicle at every speed."""
        return np.array([plant.A for plant in self.plants])

    @property
    def _opened(self) -> bool:
        return any(self.vehicle.free[name][0] != "secondary" for name in self.free)

    def least(self, device: Any, values: Mapping[str, float]) -> Real:
        """The least damping ratio at each of the speeds."""
        poles = np.linalg.eigvals(self._closed(self._secondary(device, values), values))
        size = np.abs(poles)
        return np.asarray((-poles.real / np.where(size > 0, size, 1.0)).min(axis=1))

    def ratios_and_slopes(
        self, chart: Coordinates, theta: Real, values: Mapping[str, float]
    ) -> tuple[Real, Real, Mapping[str, Real]]:
        """ζ (M,) of the watched modes of all speeds, ∂ζ/∂θ (size, M), and ∂ζ/∂ of each free vehicle parameter (M,)."""
        device = chart.device(theta)
        form = self._secondary(device, values)
        ratio, pole, u, x = self._modes(form, values)
        plant, omega = self.plants[0], self.scale.omega  # the speed is in A alone
        n0 = len(plant.A)
        # with an inerter the states' derivatives answer to it: uᴴ(I − b Bf Cv)⁻¹ stands for uᴴ
        own = np.zeros(len(plant.groups))
        own[0] = form.b
        t = np.linalg.solve(np.eye(len(own)) - (plant.Cv @ plant.Bf).T * own, (u[:, :n0] @ plant.Bf).T).T
        v = x[:, :n0] @ plant.Cv.T
        inside = slice(n0, n0 + form.order)
        xi = np.vstack([x[:, inside].T, v[None, :, 0]])
        eta = np.vstack([-omega * u[:, inside].T, self.scale.damper * t[None, :, 0]])
        slope = chart.mode_slopes(theta, device, pole / omega, xi, eta)
        by_theta = _ratio_slope(pole, slope)
        groups = np.array(self.plants[0].groups)
        moves = {}
        for name in self.free:
            group, power = self.vehicle.free[name]
            ports = groups == group
            moves[name] = (t[:, ports] * v[:, ports]).sum(axis=1) * pole**power
        return ratio, by_theta, {name: _ratio_slope(pole, move) for name, move in moves.items()}

    def _modes(self, form: StateSpace, values: Mapping[str, float]) -> tuple[Real, Complex, Complex, Complex]:
        A = self._closed(form, values)
        poles, right = np.linalg.eig(A)
        left = np.linalg.inv(right)  # rows: uᴴ with uᴴx = 1
        size = np.abs(poles)
        ratio = np.where(poles.imag >= 0, -poles.real / np.where(size > 0, size, 1.0), np.inf)
        order = np.argsort(ratio, axis=1)[:, :LEAST]
        row = np.arange(len(A))[:, None]
        return (
            ratio[row, order].ravel(),
            poles[row, order].ravel(),
            left[row, order].reshape(-1, A.shape[1]),
            right.transpose(0, 2, 1)[row, order].reshape(-1, A.shape[1]),
        )

    def _closed(self, form: StateSpace, values: Mapping[str, float]) -> Real:
        """A of the closed vehicle at every speed: :func:`posreal.vehicle.close` for all of them at once."""
        all_values = self._all(values)
        plant, A, n, m = self.plants[0], self._open, len(self.plants[0].A), len(form.A)
        Bf, Cd, Cv = plant.Bf, plant.Cd, plant.Cv  # the speed is in A alone
        k, D, b = np.zeros(len(Cv)), np.zeros(len(Cv)), np.zeros(len(Cv))
        k[0], D[0], b[0] = form.k, form.D[0, 0], form.b
        for name, (group, power) in self.vehicle.free.items():
            if group != "secondary":
                ports = np.array(plant.groups) == group
                (k if power < 0 else D)[ports] += all_values[name]
        F: Real = np.zeros((len(A), len(Cv), n + m))
        F[:, :, :n] = k[:, None] * Cd + D[:, None] * Cv + b[:, None] * (Cv @ A)
        F[:, 0, n:] = form.C[0]
        if form.b:
            F = np.linalg.solve(np.eye(len(Cv)) - b[:, None] * (Cv @ Bf), F)
        closed = np.zeros((len(A), n + m, n + m))
        closed[:, :n, :n] = A
        closed[:, :n] += Bf @ F
        closed[:, n:, :n] = np.outer(form.B[:, 0], Cv[0])
        closed[:, n:, n:] = form.A
        return closed

    def _all(self, values: Mapping[str, float]) -> dict[str, float]:
        """The vehicle parameters that a problem may free, its own where they are not."""
        return {name: float(getattr(self.vehicle, name)) for name in self.vehicle.free} | dict(values)

    def _secondary(self, device: Any, values: Mapping[str, float]) -> StateSpace:
        """What is in the secondary port in SI units: the device with the static spring beside it, or the strut."""
        form, omega, c0 = device.state_space(), self.scale.omega, self.scale.damper
        return StateSpace(
            omega * form.A,
            omega * form.B,
            c0 * form.C,
            c0 * form.D,
            c0 * omega * form.k + (0.0 if self.scale.whole else self._beside(values)),
            c0 * form.b / omega,
        )

    def _beside(self, values: Mapping[str, float]) -> float:
        """The static spring beside the device."""
        around = self.vehicle.places["secondary"].around.beside
        spring = 0.0 if around is None else float(around.static_stiffness)
        own = self._all({})
        return spring + sum(
            value - own[name] for name, value in values.items() if self.vehicle.free[name] == ("secondary", -1)
        )


@lru_cache(maxsize=1024)
def _at(vehicle: Vehicle, opened: bool, speed: float) -> Plant:
    """The vehicle at a speed, its ports open: many devices are tried in it."""
    return vehicle.at(speed).plant(vehicle.random, opened=opened)


def _ratio_slope(pole: Complex, slope: Complex) -> Real:
    """dζ = −Re dλ/|λ| + Re λ Re(λ̄ dλ)/|λ|³."""
    size = np.abs(pole)
    return np.asarray(-slope.real / size + pole.real * (pole.conj() * slope).real / size**3)
