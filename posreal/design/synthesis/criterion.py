"""The figure of a scaled device, with exact delays, and its slope: what every method here is judged by.

With H the scaled device (:class:`Scale`), the port holds Y_beside + c0 H, or Y_beside + 1/(s/kb + H/c0) behind
a bush kb; :class:`posreal.design.objective.MeanSquare` gives J and dJ/dY there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from posreal.admittance import PortHamiltonian
from posreal.design.objective import MeanSquare, mean_square
from posreal.design.problem import Problem
from posreal.design.synthesis.chart import resolvent
from posreal.design.synthesis.scale import Scale

Real = np.ndarray
Complex = np.ndarray


@dataclass(frozen=True)
class Candidate:
    """A scaled device, and the vehicle parameters that the problem leaves free."""

    device: PortHamiltonian
    parameters: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Criterion:
    """The mean-square objective of a problem for scaled devices."""

    problem: Problem
    scale: Scale

    @cached_property
    def figure(self) -> MeanSquare:
        """The objective on its quadrature grid."""
        return mean_square(self.problem, primary_open="Kpy" in self.problem.free)

    @cached_property
    def nominal(self) -> dict[str, float]:
        """The free parameters at the vehicle's own values."""
        return {name: float(getattr(self.problem.vehicle, name)) for name in self.problem.free}

    @cached_property
    def s(self) -> Complex:
        """The grid in scaled time."""
        return self.figure.s / self.scale.omega

    @cached_property
    def _beside(self) -> Complex:
        beside = self.problem.mounting.beside
        return np.zeros_like(self.figure.s) if beside is None else np.asarray(beside(self.figure.s))

    @cached_property
    def _give(self) -> Complex:
        """Mobility of the bush."""
        behind = self.problem.mounting.behind
        return np.zeros_like(self.figure.s) if behind is None else 1 / np.asarray(behind(self.figure.s))

    def value_and_slope(
        self, H: Complex, primary: Mapping[str, float] | None = None
    ) -> tuple[float, Complex, dict[str, float]]:
        """J, the g with dJ = Re Σ g dH, and ∂J/∂ of the primary's Kpy and Cpy where these are free.

        Parameters
        ----------
        H : (N,) values on the grid `s`
        primary : mapping, optional
            Kpy (N/m) and Cpy (N s/m), the vehicle's by default.
        """
        c0 = self.scale.damper
        if self.scale.impedance:
            inner = 1 / (self._give + H / c0)
            slope = -(inner**2) / c0
        else:
            inner, slope = c0 * H, np.full_like(H, c0)
        port = {"secondary": self._beside + inner}
        if "Kpy" in self.problem.free:
            values = primary or self.nominal
            port["primary"] = values["Kpy"] / self.figure.s + values["Cpy"]
        J, slopes = self.figure.value_and_slopes(port)
        extra = {}
        if "primary" in slopes:
            g = slopes["primary"]
            extra = {"Kpy": float((g / self.figure.s).real.sum()), "Cpy": float(g.real.sum())}
        return J, slopes["secondary"] * slope, extra

    def measure(self, candidate: Candidate) -> float:
        """J of a candidate, whatever the constraints."""
        return self.value_and_slope(np.asarray(candidate.device(self.s)), candidate.parameters)[0]

    def slope(self, candidate: Candidate) -> Real:
        """∂J/∂(A, B, C, D) of a device, stacked: dH = yᵀ dA x + yᵀ dB + dC x + dD (see :mod:`.chart`)."""
        form = candidate.device.state_space()
        x, y = resolvent(form.A, form.B[:, 0], form.C[0], self.s)
        _, g, _ = self.value_and_slope(np.asarray(form(self.s)), candidate.parameters)
        parts = [(y * g) @ x.T, y @ g, x @ g, g.sum()]
        return np.concatenate([np.ravel(part.real) for part in parts])
