"""The element values of a layout as coordinates of the strut: what :class:`.coordinates.Chart` is to any device.

θ are the logarithms of the free values. Y(s; θ) and ∂Y/∂θ come from the network's own sweep; and as an element is a
term of the port's admittance, an eigenvalue λ of the vehicle closed around it moves by dλ = t v dY(λ), with v the
velocity and t the answer to a force that the mode has at the port (:mod:`.damping`).
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from posreal.admittance.state_space import StateSpace, state_space
from posreal.network import Network
from posreal.network.fraction import form_of, matrices
from posreal.network.topologies import Form
from posreal.specification.layout import Layout
from posreal.specification.problem import Problem

Real = np.ndarray
Complex = np.ndarray


@dataclass(frozen=True)
class Strut:
    """A network with values in place."""

    network: Network
    values: tuple[float, ...]
    form: Form | None = None

    def __call__(self, s: Complex) -> Complex:
        """Y at the points s (N,)."""
        return np.asarray(self.network.response(self.values, s))

    @cached_property
    def _state_space(self) -> StateSpace:
        if self.form is not None:
            return matrices(self.form, self.values)
        named = dict(zip(self.network.names, self.values, strict=True))
        return state_space(self.network.with_values(named).admittance())

    def state_space(self) -> StateSpace:
        """A, B, C, D, a spring and an inerter split off."""
        return self._state_space


class ElementValues:
    """A layout's free element values within their bounds.

    Parameters
    ----------
    problem : Problem
    layout : Layout
    """

    def __init__(self, problem: Problem, layout: Layout) -> None:
        free = layout.free_elements(problem)
        self.names = tuple(free)
        self._network = layout.network
        self._form = form_of(layout.network)
        self._settled: Mapping[str, float] = layout.settled_values(problem)
        limits = np.log(np.array(list(free.values()), dtype=float).reshape(-1, 2))
        self.lower, self.upper = limits[:, 0], limits[:, 1]
        self._factors = np.ones(len(free))
        self._rows = [layout.network.names.index(name) for name in free]

    def at(self, point: Problem, layout: Layout) -> ElementValues:
        """The same at another operating point: what stands for a part of the vehicle has its value there."""
        there = copy(self)
        there._settled = layout.settled_values(point)
        return there

    def scaled(self, factors: Mapping[str, float]) -> ElementValues:
        """The same network with every value multiplied by its factor, at the same coordinates."""
        there = copy(self)
        there._settled = {name: value * factors.get(name, 1.0) for name, value in self._settled.items()}
        there._factors = self._factors * [factors.get(name, 1.0) for name in self.names]
        return there

    def moved(self, strut: Strut) -> Strut:
        """A strut of another operating point, here."""
        values = dict(zip(self._network.names, strut.values, strict=True))
        values |= {name: value for name, value in self._settled.items() if name not in self.names}
        return Strut(self._network, tuple(values[name] for name in self._network.names), self._form)

    @property
    def size(self) -> int:
        """Number of free values."""
        return len(self.names)

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """Least and greatest logarithm of each."""
        return list(zip(self.lower.tolist(), self.upper.tolist(), strict=True))

    def values(self, theta: Real) -> dict[str, float]:
        """Every element's value at `theta`, the settled ones too."""
        inside = (self._factors * np.exp(np.clip(theta, self.lower, self.upper))).tolist()
        return {**self._settled, **dict(zip(self.names, inside, strict=True))}

    def device(self, theta: Real) -> Strut:
        """The strut at `theta`."""
        values = self.values(theta)
        return Strut(self._network, tuple(values[name] for name in self._network.names), self._form)

    def values_and_slopes(self, theta: Real, s: Complex) -> tuple[Complex, Complex]:
        """Y (N,) and ∂Y/∂θ (size, N) at the points s (N,)."""
        Y, dY = self._network.evaluate(self.device(theta).values, s)
        return Y, dY[self._rows]

    def mode_slopes(self, theta: Real, device: Strut, s: Complex, xi: Complex, eta: Complex) -> Complex:
        """Slopes (size, M) of the eigenvalues s (M,) of a vehicle with modes ξ = (…, v), η = (…, t) at the port."""
        return np.asarray(self.values_and_slopes(theta, s)[1] * (xi[-1] * eta[-1]))
