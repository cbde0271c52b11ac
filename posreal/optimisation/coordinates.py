"""Every positive-real function of an order, from one unconstrained vector.

    ẋ = (J − R) x + (G − P) v,   f = (G + P)ᵀ x + S v,   [[R, P], [Pᵀ, S]] = L Lᵀ,   J = −Jᵀ

with k/s and b·s beside it where they are wanted, k = κ², b = β² [Willems1972]. The chart's vector holds the
strict lower triangle of J, G, the lower triangle of L, and κ, β. With x = (sI − A)⁻¹B, yᵀ = C(sI − A)⁻¹,
ξ = (x, 1) and η = (−y, 1), the device's value moves by

    dY = yᵀ dJ x + (x + y)ᵀ dG + ηᵀ (dL Lᵀ + L dLᵀ) ξ + 2κ dκ/s + 2β s dβ.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Protocol

import numpy as np
from scipy.linalg import schur

from posreal.admittance import PortHamiltonian

Real = np.ndarray
Complex = np.ndarray


def resolvent(A: Real, B: Real, C: Real, s: Complex) -> tuple[Complex, Complex]:
    """x = (sI − A)⁻¹B and y with yᵀ = C(sI − A)⁻¹, each (n, N), for all s (N,) at once.

    A = U T Uᴴ in Schur's form, so each is a back-substitution, every operation along all frequencies.
    """
    T, U = schur(A, output="complex")
    n = len(A)
    b, c = U.conj().T @ B, C @ U
    x, y = np.empty((n, len(s)), dtype=complex), np.empty((n, len(s)), dtype=complex)
    for i in reversed(range(n)):
        x[i] = (b[i] + T[i, i + 1 :] @ x[i + 1 :]) / (s - T[i, i])
    for j in range(n):
        y[j] = (c[j] + T[:j, j] @ y[:j]) / (s - T[j, j])
    return U @ x, U.conj() @ y


@lru_cache(maxsize=64)
def _lower(n: int, diagonal: int = 0) -> tuple[np.ndarray, np.ndarray]:
    return np.tril_indices(n, diagonal)


class Coordinates(Protocol):
    """A family of devices with a vector of numbers each: this module's, or a layout's element values."""

    @property
    def size(self) -> int:
        """Length of the vector."""

    @property
    def bounds(self) -> Any:
        """Least and greatest value of each number, None where there is none."""

    def device(self, theta: Real) -> Any:
        """The device at `theta`: callable on points s, with `state_space()`."""

    def values_and_slopes(self, theta: Real, s: Complex) -> tuple[Complex, Complex]:
        """Y (N,) and ∂Y/∂θ (size, N) at the points s (N,)."""

    def mode_slopes(self, theta: Real, device: Any, s: Complex, xi: Complex, eta: Complex) -> Complex:
        """Slopes (size, M) of eigenvalues s (M,) of a closed loop with ξ = (x, v) and η = (−y, t) at the port."""


@dataclass(frozen=True)
class Chart:
    """Positive-real functions with `order` states, and optionally a spring and an inerter beside them."""

    order: int
    spring: bool = False
    inerter: bool = False

    @property
    def size(self) -> int:
        """Length of the vector."""
        n = self.order
        return n * (n - 1) // 2 + n + (n + 1) * (n + 2) // 2 + self.spring + self.inerter

    @property
    def bounds(self) -> list[tuple[None, None]]:
        """None for every number."""
        return [(None, None)] * self.size

    def device(self, theta: Real) -> PortHamiltonian:
        """The device at `theta`."""
        n = self.order
        skew, lower = _lower(n, -1), _lower(n + 1)
        cuts = np.cumsum([len(skew[0]), n, len(lower[0])])
        J, L = np.zeros((n, n)), np.zeros((n + 1, n + 1))
        J[skew] = theta[: cuts[0]]
        L[lower] = theta[cuts[1] : cuts[2]]
        beside = list(theta[cuts[2] :] ** 2)
        k = beside.pop(0) if self.spring else 0.0
        b = beside.pop(0) if self.inerter else 0.0
        return PortHamiltonian(J - J.T, theta[cuts[0] : cuts[1], None], L, float(k), float(b))

    def vector(self, device: PortHamiltonian) -> Real:
        """A `theta` of a device of at most this order; missing states are added uncoupled, damped at unit rate."""
        n, m = self.order, device.order
        # An orthogonal change of the columns of L makes it lower triangular and leaves L Lᵀ alone.
        wide = np.hstack([device.L, np.zeros((m + 1, max(0, m + 1 - device.L.shape[1])))])
        inner = np.asarray(np.linalg.qr(wide.T)[1])[: m + 1].T
        J, G, L = np.zeros((n, n)), np.zeros(n), np.zeros((n + 1, n + 1))
        J[:m, :m] = (device.J - device.J.T) / 2
        G[:m] = device.G[:, 0]
        L[:m, :m] = inner[:m, :m]
        L[range(m, n), range(m, n)] = 1.0
        L[n, :m], L[n, n] = inner[m, :m], inner[m, m]
        beside = [np.sqrt(device.k)] * self.spring + [np.sqrt(device.b)] * self.inerter
        return np.concatenate([J[_lower(n, -1)], G, L[_lower(n + 1)], beside])

    def values(self, theta: Real, s: Complex) -> Complex:
        """Y(s) at every s."""
        return self._states(theta, s)[0]

    def values_and_slopes(self, theta: Real, s: Complex) -> tuple[Complex, Complex]:
        """Y (N,) and ∂Y/∂θ (size, N) at the points s (N,)."""
        Y, x, y, L = self._states(theta, s)
        one = np.ones((1, len(s)))
        return Y, self.slopes(theta, L, s, np.vstack([x, one]), np.vstack([-y, one]))

    def slopes(self, theta: Real, L: Real, s: Complex, xi: Complex, eta: Complex) -> Complex:
        """The module's form of dY for given ξ = (x, v) and η = (−y, t), each (n + 1, N): (size, N).

        With v = t = 1 and the resolvents x, y it is ∂Y/∂θ; with the device's parts of a closed loop's
        eigenvectors, its port velocity v and the force t to which the mode answers, it is the slope of the
        eigenvalue s.
        """
        n = self.order
        x, y, v, t = xi[:n], -eta[:n], xi[n], eta[n]
        i, j = _lower(n, -1)
        p, q = _lower(n + 1)
        forward, back = L.T @ xi, L.T @ eta
        rows = [y[i] * x[j] - y[j] * x[i], t * x + v * y, eta[p] * forward[q] + xi[p] * back[q]]
        if self.spring:
            rows.append((2 * theta[-1 - self.inerter] * t * v / s)[None, :])
        if self.inerter:
            rows.append((2 * theta[-1] * t * v * s)[None, :])
        return np.vstack(rows)

    def mode_slopes(self, theta: Real, device: PortHamiltonian, s: Complex, xi: Complex, eta: Complex) -> Complex:
        """As :meth:`slopes`, for the device at `theta`."""
        return self.slopes(theta, device.L, s, xi, eta)

    def _states(self, theta: Real, s: Complex) -> tuple[Complex, Complex, Complex, Real]:
        device = self.device(theta)
        form, n = device.state_space(), self.order
        if n == 0:
            nothing = np.zeros((0, len(s)), dtype=complex)
            x = y = nothing
        else:
            x, y = resolvent(form.A, form.B[:, 0], form.C[0], s)
        Y = (form.C @ x)[0] + form.D[0, 0] + form.b * s
        return (Y + form.k / s if form.k else Y), x, y, device.L
