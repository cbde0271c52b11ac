"""A problem as a function of the values of any network in the device's place.

    θ = (log element values, log free vehicle parameters)   ↦   J(θ), ∂J/∂θ

for many θ in one go. The network gives Y on the frequency grid (:mod:`posreal.topology.batch`), the
mounting puts it behind its bush or beside its static spring, and the port closes the vehicle around it,

    z = Tzw + Σ_p Tzf_p y Pvw_p/(1 + Pvf_pp y),      ∂z/∂y = Σ_p Tzf_p Pvw_p/(1 + Pvf_pp y)²,

summed over the ports p that share the device and do not feel each other. Where primary parameters are free
their places are ports too, which do feel each other, and the ports are closed by a small linear system at
each frequency.

Values are counted in units of the vehicle: c₀ is the single damper that makes J least, ω₀ the frequency about
which the ride figure then lies, and a spring has c₀ω₀ for its unit, a damper c₀, an inerter c₀/ω₀.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from posreal.network.as_made import made
from posreal.network.topologies import Form, letters, valued
from posreal.optimisation.mean_square import MeanSquare, Modes, mean_square, modes
from posreal.plant.mounting import Mounting
from posreal.specification.problem import Problem
from posreal.topology.batch import Array, Grid, admittance

_DAMPERS = np.geomspace(1e-3, 1e1, 5)  # of the port's middle impedance
_LEFT_OUT = 1e-8  # of the mean square: what the lowest points of a coarse grid may hold and still be dropped


@dataclass(frozen=True)
class Units:
    """Units in which values are counted: a damper's c0 in N s/m and the frequency omega0 in rad/s."""

    c0: float
    omega0: float

    def units(self, kinds: str) -> Array:
        """The unit of each element of a form, in N/m, N s/m and kg."""
        unit = {"k": self.c0 * self.omega0, "c": self.c0, "b": self.c0 / self.omega0}
        return np.array([unit[letter] for letter in kinds])


class Ground:
    """One mean-square metric of a problem on one frequency grid; see the module.

    Parameters
    ----------
    problem : Problem
    panels : int
        Panels a decade of the frequency grid.
    trimmed : bool
        Whether the lowest frequencies, which carry nothing of the figure, are left out.
    light : Modes
        Of the closed loop, which the grid has to see.
    """

    def __init__(
        self,
        problem: Problem,
        panels: int,
        *,
        trimmed: bool = False,
        light: Modes = (),
    ) -> None:
        self.problem, self.panels, self.light = problem, panels, light
        self.vehicle_names = tuple(problem.free)
        self._tied = problem.roles.get("static spring") if problem.free else None
        self.primary_open = any(name != self._tied for name in self.vehicle_names)
        figure = mean_square(problem, primary_open=self.primary_open, panels=panels, light=light)
        port = figure.port
        keep = slice(_negligible(figure, problem.mounting) if trimmed else 0, None)
        self._weight = figure.scale * figure.weight[keep]
        self.grid = Grid.at(figure.s[keep], problem.elements)
        self._Tzw, self._Tzf, self._Pvw, self._Pvf = (
            port.Tzw[keep],
            port.Tzf[keep],
            port.Pvw[keep],
            port.Pvf[keep],
        )
        self._groups = port.groups
        self._alone = set(port.groups) == {"secondary"} and _do_not_couple(self._Pvf)
        mounting = problem.mounting
        self._bush = None if mounting.behind is None else np.asarray(mounting.behind(self.grid.s))
        self._beside = None
        if mounting.beside is not None and self._tied not in self.vehicle_names:
            self._beside = np.asarray(mounting.beside(self.grid.s))

    def closer(self, form: Form, theta: Array) -> Ground:
        """The same on a grid that sees the vehicle's modes with the network of one θ (n,) in place."""
        count, values = len(letters(form)), np.exp(theta).tolist()
        tuned = self.problem.with_vehicle(dict(zip(self.vehicle_names, values[count:], strict=True)))
        port = tuned.port(made(valued(form, values[:count]), tuned.elements).admittance())
        return Ground(self.problem, self.panels, light=modes(tuned, port))

    def value_and_gradient(self, form: Form, theta: Array) -> tuple[Array, Array]:
        """J (B,) and ∂J/∂θ (B, n) at θ (B, n): elements in the form's order, then `vehicle_names`."""
        z, pull = self._output(form, theta)
        J = np.sqrt((z.real**2 + z.imag**2) @ self._weight)
        return J, pull((self._weight * z.conj()) / J[:, None])

    def response(self, form: Form, theta: Array) -> Array:
        """z (B, N), the output at each frequency."""
        return self._output(form, theta)[0]

    def _output(self, form: Form, theta: Array) -> tuple[Array, Callable[[Array], Array]]:
        """z, and the map from g with dJ = Re Σ g dz to ∂J/∂θ."""
        count = len(letters(form))
        Y, through_network = admittance(form, theta[:, :count], self.grid)
        inner, slope = self._mounted(Y)
        free: dict[str, Array] = dict(zip(self.vehicle_names, np.exp(theta[:, count:]).T, strict=True))
        shares: dict[str, tuple[str, Array]] = {}  # of a vehicle parameter: the group it stands in, ∂Y/∂ log of it
        for name, value in free.items():
            group, power = self.problem.vehicle.free[name]
            shares[name] = (group, np.multiply.outer(value, self.grid.powers[power + 1]))
        ports: dict[str, Array] = {"secondary": inner}
        for group, share in shares.values():
            ports[group] = ports[group] + share if group in ports else share
        z, dz = self._closed(ports)

        def pull(g: Array) -> Array:
            gradient = np.empty_like(theta)
            device = g * dz["secondary"]
            gradient[:, :count] = through_network(device if slope is None else device * slope)
            for i, (group, share) in enumerate(shares.values(), count):
                gradient[:, i] = (g * dz[group] * share).real.sum(axis=1)
            return gradient

        return z, pull

    def _mounted(self, Y: Array) -> tuple[Array, Array | None]:
        """The device behind its bush and beside its spring, and the slope of that."""
        slope = None
        if self._bush is not None:
            share = self._bush / (self._bush + Y)
            Y, slope = Y * share, share * share
        return (Y if self._beside is None else Y + self._beside), slope

    def _closed(self, ports: dict[str, Array]) -> tuple[Array, dict[str, Array]]:
        """z and ∂z/∂Y of each group of ports."""
        if self._alone:
            y = ports["secondary"]
            z, slope = self._Tzw, np.zeros(1)
            for p in range(len(self._groups)):
                inverse = 1 / (1 + self._Pvf[:, p, p] * y)
                v = self._Pvw[:, p] * inverse
                t = self._Tzf[:, p] * v
                z = z + t * y
                slope = slope + t * inverse  # Tzf Pvw/(1 + Pvf y)²
            return z, {"secondary": slope}
        y = np.stack([ports[group] for group in self._groups], axis=-1)
        unit = np.eye(y.shape[-1])
        v = np.linalg.solve(unit + self._Pvf * y[..., None, :], self._Pvw[..., None])[..., 0]
        back = np.swapaxes(unit + y[..., :, None] * self._Pvf, -1, -2)
        t = np.linalg.solve(back, np.broadcast_to(self._Tzf[..., None], (*y.shape, 1)))[..., 0]
        z = self._Tzw + (self._Tzf * y * v).sum(axis=-1)
        dz: dict[str, Array] = {}
        for p, group in enumerate(self._groups):
            dz[group] = dz.get(group, 0.0) + t[..., p] * v[..., p]
        return z, dz

    @cached_property
    def scale(self) -> Units:
        """The vehicle's own units, see the module."""
        rough = float(np.exp(-np.mean(np.log(np.abs(self._Pvf[:, 0, 0])))))
        dampers = np.log(rough * np.geomspace(1e-5, 1e2, 141))[:, None]
        here = np.log([getattr(self.problem.vehicle, name) for name in self.vehicle_names])
        theta = np.hstack([dampers, np.tile(here, (len(dampers), 1))])
        J, _ = self.value_and_gradient("c", theta)
        best = theta[[int(np.argmin(J))]]
        share = self._weight * np.abs(self.response("c", best)[0]) ** 2
        omega0 = float(np.exp(share @ np.log(self.grid.s.imag) / share.sum()))
        return Units(math.exp(float(best[0, 0])), omega0)


def _negligible(ride: MeanSquare, mounting: Mounting) -> int:
    """How many of the lowest points carry nothing of the ride figure, whichever damper is at the port."""
    middle, ones = math.exp(-float(np.mean(np.log(np.abs(ride.port.Pvf[:, 0, 0]))))), np.ones(len(ride.s), complex)
    fewest = len(ride.s)
    for damper in middle * _DAMPERS:
        ports = dict.fromkeys(ride.port.groups, damper * ones)
        ports["secondary"] = mounting.response(damper * ones, ride.s)[0]
        z, _ = ride.port.closed(ports)
        share = np.cumsum(ride.rule.weight * np.abs(z) ** 2)
        fewest = min(fewest, int(np.searchsorted(share, _LEFT_OUT * share[-1])))
    return fewest


def _do_not_couple(Pvf: Array) -> bool:
    ports = np.arange(Pvf.shape[1])
    off = np.abs(Pvf)
    own = off.max(axis=(1, 2))
    off[:, ports, ports] = 0.0
    return bool(np.all(off.max(axis=(1, 2)) <= 1e-9 * own))
