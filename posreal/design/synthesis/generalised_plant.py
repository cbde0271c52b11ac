"""The vehicle as the matrix inequalities see it: everything but the device, scaled, delays by Padé, reduced.

    ẋ = A x + Bw w + Bu u,   z = Cz x + Dzu u,   y = Cy x,   u = H y at every port

The static spring or airspring beside the device is part of A. Where a bush of stiffness kb stands behind the device,
the bush's deflection e is a state, ė = v − u, and the device answers the bush force y = kb e with a velocity u: H is
then its *impedance*; otherwise y = v, u = f and H is its admittance. Either is positive real if the other is.

Units: time in 1/ω0, device in c0 (see :class:`Scale`), and w and z such that the figure J is the H2 norm of w → z.
Delays are chains of Padé all-passes; what the criterion cannot feel (the bogies' pitch, most of a long chain) is
removed by balanced truncation with a damper c0 in place [Moore1981].
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, cholesky, solve_continuous_lyapunov, svd

from posreal.admittance import Rational, StateSpace, state_space
from posreal.design.problem import Problem
from posreal.design.synthesis.scale import Scale
from posreal.errors import BadInput
from posreal.vehicle.plant import Plant, ShapingFilter

Real = NDArray[np.float64]


@dataclass(frozen=True)
class GeneralisedPlant:
    """The matrices of the module's equations."""

    A: Real
    Bw: Real
    Bu: Real
    Cz: Real
    Dzu: Real
    Cy: Real

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.A)

    @property
    def ports(self) -> int:
        """How many copies of the device it holds."""
        return self.Bu.shape[1]

    def closed(self, Ak: Real, Bk: Real, Ck: Real, Dk: Real) -> tuple[Real, Real]:
        """Acl and Ccl with the device in every port: affine in the device; leading axes broadcast.

            Acl = [[A + Bu D Cy, Bu C], [B Cy, A_k]],   Ccl = [Cz + Dzu D Cy, Dzu C],

        with A_k, B, C, D the device's matrices repeated block-diagonally, one copy a port.
        """
        p = self.ports
        a, b, c, d = (_repeated(part, p) for part in (Ak, Bk, Ck, Dk))
        upper = np.concatenate([self.A + self.Bu @ d @ self.Cy, self.Bu @ c], axis=-1)
        lower = np.concatenate([b @ self.Cy, a], axis=-1)
        Ccl = np.concatenate([self.Cz + self.Dzu @ d @ self.Cy, self.Dzu @ c], axis=-1)
        return np.concatenate([upper, lower], axis=-2), Ccl

    def reduced(self, tolerance: float) -> GeneralisedPlant:
        """Balanced truncation of (w, u) → (z, y), closed by the unit damper u = y and opened again afterwards.

        Parameters
        ----------
        tolerance : float
            States with Hankel singular values below `tolerance` times the largest are dropped.
        """
        A = self.A + self.Bu @ self.Cy
        Cz = self.Cz + self.Dzu @ self.Cy
        # z and y each count by their own size, as do w and u
        B = [_unit(part, A, side="in") for part in (self.Bw, self.Bu)]
        C = [_unit(part, A, side="out") for part in (Cz, self.Cy)]
        controllable = _factor(solve_continuous_lyapunov(A, -sum(b @ b.T for b in B)))
        observable = _factor(solve_continuous_lyapunov(A.T, -sum(c.T @ c for c in C)))
        U, sigma, Vt = svd(observable.T @ controllable)
        kept = sigma > tolerance * sigma[0]
        root = np.sqrt(sigma[kept])
        left = (U[:, kept] / root).T @ observable.T
        right = controllable @ (Vt[kept].T / root)
        Bu, Cy = left @ self.Bu, self.Cy @ right
        return GeneralisedPlant(
            left @ A @ right - Bu @ Cy, left @ self.Bw, Bu, Cz @ right - self.Dzu @ Cy, self.Dzu, Cy
        )


def generalised_plant(
    problem: Problem, scale: Scale, *, band: float = 60.0, tolerance: float = 1e-3
) -> GeneralisedPlant:
    """The generalised plant of a problem's mean-square objective.

    Parameters
    ----------
    problem : Problem
    scale : Scale
    band : float
        Frequency, rad/s, up to which the Padé delays keep their phase.
    tolerance : float
        Of the balanced truncation.
    """
    plant, output, unit = problem_plant(problem)
    gain = unit * math.sqrt(math.pi * plant.density * scale.omega)
    opened = mounted(plant, output, problem.mounting.beside, problem.mounting.behind, scale)
    late = _delayed(opened.Bw, plant.delays, band)
    opened = _driven(opened, late, scale)
    if plant.shaping is not None:
        opened = _driven(opened, plant.shaping, scale)
    scaled = GeneralisedPlant(
        opened.A, opened.Bw, opened.Bu, gain * opened.Cz, gain * opened.Dzu, opened.Cy
    )
    return scaled.reduced(tolerance)
