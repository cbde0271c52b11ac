"""The figure of a scaled device, with exact delays, and its slope: what every method here is judged by.

:class:`.mean_square.MeanSquare` gives J and dJ/dY at the port, :class:`.figure.Inside` what is in it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from posreal.admittance import PortHamiltonian
from posreal.optimisation.coordinates import resolvent
from posreal.optimisation.figure import Inside
from posreal.optimisation.mean_square import MeanSquare, Modes, mean_square, opened
from posreal.optimisation.scaling import Scale
from posreal.specification.problem import Problem

Real = np.ndarray
Complex = np.ndarray


@dataclass(frozen=True)
class Candidate:
    """A scaled device, and the vehicle parameters that the problem leaves free."""

    device: PortHamiltonian
    parameters: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Criterion:
    """The mean-square objective of a problem for scaled devices, on a grid that sees the modes `light`."""

    problem: Problem
    scale: Scale
    panels: int = 12
    light: Modes = ()

    @cached_property
    def figure(self) -> MeanSquare:
        """The objective on its quadrature grid."""
        return mean_square(self.problem, primary_open=opened(self.problem), panels=self.panels, light=self.light)

    @cached_property
    def nominal(self) -> dict[str, float]:
        """The free parameters at the vehicle's own values."""
        return self._inside.nominal

    @cached_property
    def s(self) -> Complex:
        """The grid in scaled time."""
        return self.figure.s / self.scale.omega

    @cached_property
    def _inside(self) -> Inside:
        return Inside(self.problem, self.scale, self.figure.s)

    def value_and_slope(
        self, H: Complex, parameters: Mapping[str, float] | None = None
    ) -> tuple[float, Complex, dict[str, float]]:
        """J, the g with dJ = Re Σ g dH, and ∂J/∂ of the free vehicle parameters.

        Parameters
        ----------
        H : (N,) values on the grid `s`
        parameters : mapping, optional
            Free vehicle parameters in SI units, the vehicle's own by default.
        """
        Y, inner = self._inside.ports(H, parameters)
        J, slopes = self.figure.value_and_slopes(Y)
        extra = {name: float(slope) for name, slope in self._inside.by_parameter(slopes).items()}
        return J, slopes["secondary"] * inner, extra

    def measure(self, candidate: Candidate) -> float:
        """J of a candidate, whatever the constraints."""
        return self.value_and_slope(np.asarray(candidate.device(self.s)), candidate.parameters)[0]

    def slope(self, candidate: Candidate) -> Real:
        """∂J/∂(A, B, C, D) of a device, stacked: dH = yᵀ dA x + yᵀ dB + dC x + dD (see :mod:`.coordinates`)."""
        form = candidate.device.state_space()
        x, y = resolvent(form.A, form.B[:, 0], form.C[0], self.s)
        _, g, _ = self.value_and_slope(np.asarray(form(self.s)), candidate.parameters)
        parts = [(y * g) @ x.T, y @ g, x @ g, g.sum()]
        return np.concatenate([np.ravel(part.real) for part in parts])
