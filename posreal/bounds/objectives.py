"""What the plain form minimises over the device's coefficients x: smooth enough for Newton, with its own multiplier.

With f = τ + O x (:mod:`.figure`), the three figures and the functionals that bound them from below are

    squares   ‖f‖²                          is quadratic itself
    sum       Σ ‖f_o‖ over outputs          ≥ Σ ⟨u_o, f_o⟩        for unit vectors u_o
    peak      ‖T_f‖ ≤ ‖z‖_∞, T_f = Σ f_l F_l  ≥ ⟨P Qᵀ, T_f⟩         for ‖P‖² + ‖Q‖² ≤ 2 (nuclear norm at most 1)

so that the last two are linear in x once u, or P and Q, are known [Pick1916 in its bounded-real form]. ‖T_f‖ ≤ g is the
matrix inequality [[gI, T_f], [T_fᵀ, gI]] ⪰ 0 with g a variable beside x.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky

from posreal.bounds.figure import PEAK, SQUARES
from posreal.bounds.sampled import Sampled

Array = np.ndarray


class Objective(Protocol):
    """A convex function of x on the central path; `y` is x and, after it, variables of its own."""

    @property
    def size(self) -> float:
        """A typical value, which sets the path's scale."""
        ...

    def start(self, x: Array) -> Array:
        """A y strictly inside."""
        ...

    def value(self, y: Array, t: float) -> float:
        """t J plus the barrier of its own variables; inf outside."""
        ...

    def derivatives(self, y: Array, t: float) -> tuple[Array, Array]:
        """Gradient and Hessian of `value`."""
        ...

    def multiplier(self, y: Array, t: float) -> Array:
        """u (outputs, m), or P over Q (2m, q); empty for squares."""
        ...

    def lower(self, functional: Array) -> tuple[float, Array, Array, bool]:
        """Its part of c, b and M in :mod:`certificate` for that multiplier, and whether these bound J²."""
        ...


@dataclass(frozen=True)
class Squares:
    """‖τ + O x‖²."""

    data: Sampled

    @cached_property
    def _parts(self) -> tuple[Array, Array]:
        O = self.data.O[0].reshape(-1, self.data.F.shape[0])
        return O.T @ O, O.T @ self.data.tau.ravel()

    @cached_property
    def size(self) -> float:
        """‖τ‖²."""
        return float(np.sum(self.data.tau**2))

    def start(self, x: Array) -> Array:
        """x itself."""
        return x

    def value(self, y: Array, t: float) -> float:
        """t (‖τ + O x‖² − ‖τ‖²)."""
        quadratic, linear = self._parts
        return t * float(y @ (quadratic @ y) + 2 * linear @ y)

    def derivatives(self, y: Array, t: float) -> tuple[Array, Array]:
        """Gradient and Hessian."""
        quadratic, linear = self._parts
        return 2 * t * (linear + quadratic @ y), 2 * t * quadratic

    def multiplier(self, y: Array, t: float) -> Array:
        """Nothing: the certificate keeps the squares."""
        return np.zeros((0, 0))

    def lower(self, functional: Array) -> tuple[float, Array, Array, bool]:
        """‖τ‖², Oᵀτ and OᵀO."""
        quadratic, linear = self._parts
        return self.size, linear, quadratic, True


@dataclass(frozen=True)
class Sum:
    """Σ ‖τ_o + O_o x‖."""

    data: Sampled

    @cached_property
    def size(self) -> float:
        """Σ ‖τ_o‖."""
        return float(np.linalg.norm(self.data.tau, axis=1).sum())

    def _f(self, y: Array) -> tuple[Array, Array]:
        f = self.data.tau + self.data.O[0] @ y
        return f, np.linalg.norm(f, axis=1)

    def start(self, x: Array) -> Array:
        """x itself."""
        return x

    def value(self, y: Array, t: float) -> float:
        """t Σ ‖f_o‖."""
        return t * float(self._f(y)[1].sum())

    def derivatives(self, y: Array, t: float) -> tuple[Array, Array]:
        """Gradient and Hessian."""
        f, length = self._f(y)
        slopes = np.einsum("okl,ok->ol", self.data.O[0], f / length[:, None])
        hessian = sum(
            (O.T @ O - np.outer(slope, slope)) / size
            for O, slope, size in zip(self.data.O[0], slopes, length, strict=True)
        )
        return t * slopes.sum(axis=0), np.asarray(t * hessian)

    def multiplier(self, y: Array, t: float) -> Array:
        """f_o/‖f_o‖."""
        f, length = self._f(y)
        return np.asarray(f / length[:, None])

    def lower(self, functional: Array) -> tuple[float, Array, Array, bool]:
        """⟨u, τ⟩ and ½ Oᵀu."""
        return _linear(self.data, functional)


@dataclass(frozen=True)
class Peak:
    """g with [[gI, T_f], [T_fᵀ, gI]] ⪰ 0, the norm of T_f."""

    data: Sampled

    @cached_property
    def _columns(self) -> Array:
        """∂T_f/∂xₖ: Σ_l O_lk F_l, (m, m, m)."""
        return np.asarray(np.tensordot(self.data.O[0, 0].T, self.data.F, axes=1))

    @cached_property
    def size(self) -> float:
        """‖T_τ‖."""
        return float(np.linalg.norm(self._operator(np.zeros(self.data.F.shape[0])), 2))

    def _operator(self, x: Array) -> Array:
        return np.asarray(np.tensordot(self.data.tau[0] + self.data.O[0, 0] @ x, self.data.F, axes=1))

    def _block(self, y: Array) -> Array:
        T, m = self._operator(y[:-1]), self.data.F.shape[0]
        return np.block([[y[-1] * np.eye(m), T], [T.T, y[-1] * np.eye(m)]])

    def start(self, x: Array) -> Array:
        """x, and twice the norm there."""
        return np.append(x, 2 * np.linalg.norm(self._operator(x), 2))

    def value(self, y: Array, t: float) -> float:
        """t g − log det of the block."""
        try:
            factor = cholesky(self._block(y), lower=True)
        except np.linalg.LinAlgError:
            return math.inf
        return t * float(y[-1]) - 2 * float(np.log(np.diag(factor)).sum())

    def _inverse(self, y: Array) -> Array:
        block = self._block(y)
        return np.asarray(cho_solve(cho_factor(block, lower=True), np.eye(len(block))))

    def derivatives(self, y: Array, t: float) -> tuple[Array, Array]:
        """Gradient and Hessian; with B⁻¹ = [[p, q], [qᵀ, r]] and D = ∂T, tr(B⁻¹ dB B⁻¹ dB') in its blocks."""
        B, m, D = self._inverse(y), self.data.F.shape[0], self._columns
        p, q, r = B[:m, :m], B[:m, m:], B[m:, m:]
        flat = D.reshape(m, -1)
        gradient = np.append(-2 * flat @ q.ravel(), t - np.trace(B))
        hessian = np.empty((m + 1, m + 1))
        moved = p @ D @ r + q @ np.swapaxes(D, 1, 2) @ q
        hessian[:m, :m] = 2 * flat @ moved.reshape(m, -1).T
        hessian[m, :m] = hessian[:m, m] = 2 * flat @ (p @ q + q @ r).ravel()
        hessian[m, m] = float(np.sum(B * B))
        return gradient, (hessian + hessian.T) / 2

    def multiplier(self, y: Array, t: float) -> Array:
        """P over Q with P Qᵀ = −2 × the off-diagonal block of B⁻¹/t, whose trace is 1 on the path."""
        root = cholesky(self._inverse(y) / t, lower=True) * math.sqrt(2)
        m = self.data.F.shape[0]
        return np.vstack([-root[:m], root[m:]])

    def lower(self, functional: Array) -> tuple[float, Array, Array, bool]:
        """⟨u, τ⟩ and ½ Oᵀu with u_l = ⟨P Qᵀ, F_l⟩, brought to norm 1."""
        m = self.data.F.shape[0]
        P, Q = functional[:m], functional[m:]
        u = self.data.F.reshape(m, -1) @ (P @ Q.T).ravel() * (2 / float(np.sum(functional**2)))
        return _linear(self.data, u[None, :])


def _linear(data: Sampled, u: Array) -> tuple[float, Array, Array, bool]:
    m = data.F.shape[0]
    return float(np.sum(u * data.tau)), np.einsum("okl,ok->l", data.O[0], u) / 2, np.zeros((m, m)), False


def objective(combine: str, data: Sampled) -> Objective:
    """The objective for a way in which a figure combines its outputs."""
    return Squares(data) if combine == SQUARES else Peak(data) if combine == PEAK else Sum(data)
