"""ẋ = (J − R) x + (G − P) v,  f = (G + P)ᵀ x + S v,  J = −Jᵀ,  [[R, P], [Pᵀ, S]] = L Lᵀ.

Positive real by construction. Every positive-real function has this form (take coordinates in which the
stored energy is ½xᵀx in the positive-real lemma [Willems1972]); with k/s and b·s beside it, k, b ≥ 0, it is
every spring, damper and inerter network.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import fmpq, fmpq_mat, fmpq_poly
from numpy.typing import ArrayLike, NDArray

from posreal.admittance import exact
from posreal.admittance.rational import Rational
from posreal.admittance.state_space import StateSpace
from posreal.errors import BadDevice

Matrix = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PortHamiltonian:
    """A device that stores and dissipates, and cannot do else.

    Attributes
    ----------
    J : array, shape (n, n)
        Only its skew part (J − Jᵀ)/2 acts.
    G : array, shape (n, 1)
        Port.
    L : array, shape (n + 1, m)
        Factor of the dissipation matrix.
    k, b : float
        Parallel spring (N/m) and inerter (kg), not negative.
    """

    J: Matrix
    G: Matrix
    L: Matrix
    k: float = 0.0
    b: float = 0.0

    def __post_init__(self) -> None:
        n = self.J.shape[0]
        if self.J.shape != (n, n) or self.G.shape != (n, 1) or self.L.ndim != 2 or self.L.shape[0] != n + 1:
            raise BadDevice(
                f"Port-Hamiltonian shapes {self.J.shape}, {self.G.shape}, {self.L.shape} do not fit; "
                "give J (n, n), G (n, 1) and L (n + 1, m)."
            )
        if self.k < 0 or self.b < 0:
            raise BadDevice(f"Parallel spring {self.k} and inerter {self.b} cannot be negative.")

    @property
    def order(self) -> int:
        """Number of states."""
        return int(self.J.shape[0])

    def __call__(self, s: ArrayLike) -> Any:
        """Y(s) in floats."""
        return self.state_space()(s)

    def state_space(self) -> StateSpace:
        """The same device as A, B, C, D in floats."""
        n = self.order
        W = self.L @ self.L.T
        J, R, P = (self.J - self.J.T) / 2, W[:n, :n], W[:n, n:]
        return StateSpace(J - R, self.G - P, (self.G + P).T, W[n:, n:], float(self.k), float(self.b))

    def rational(self) -> Rational:
        """The admittance computed exactly from the floats, so exactly positive real."""
        n = self.order
        L = exact.matrix(self.L) if self.L.size else fmpq_mat(n + 1, 1)
        W = (L * L.transpose()).tolist()
        S, k, b = W[n][n], exact.to_fmpq(float(self.k)), exact.to_fmpq(float(self.b))
        beside = Rational([k, 0, b], [0, 1])
        if n == 0:
            return Rational(fmpq_poly([S])) | beside
        J, G = exact.matrix(self.J).tolist(), exact.matrix(self.G).entries()
        A = fmpq_mat(n, n, [(J[i][j] - J[j][i]) / fmpq(2) - W[i][j] for i in range(n) for j in range(n)])
        B = fmpq_mat(n, 1, [G[i] - W[i][n] for i in range(n)])
        C = fmpq_mat(1, n, [G[i] + W[i][n] for i in range(n)])
        return Rational(*exact.transfer_function(A, B, C, S)) | beside


def random_port_hamiltonian(order: int, rng: np.random.Generator, decades: float = 0.0) -> PortHamiltonian:
    """A device with normally distributed matrices and no spring or inerter beside it.

    Parameters
    ----------
    order : int
        Number of states.
    rng : numpy.random.Generator
        Where the numbers come from.
    decades : float
        Spread the states' time scales over so many powers of ten.
    """
    J = rng.standard_normal((order, order))
    G = rng.standard_normal((order, 1))
    L = np.vstack([np.tril(rng.standard_normal((order, order))), rng.standard_normal((1, order))])
    if order == 0:
        L = rng.standard_normal((1, 1))
    rates = 10.0 ** (decades * (rng.random(order) - 0.5) / 2)
    scale = np.append(rates, 1.0)[:, None]
    return PortHamiltonian(J * rates[:, None] * rates, G * rates[:, None], L * scale)
