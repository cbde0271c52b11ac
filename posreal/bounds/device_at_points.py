"""The device that is best at the points, as far as Newton's method finds it: a guide, which proves nothing.

    minimise ‖τ + Σ Oᵢxᵢ‖²   over the column of Σ = σ(S) with I − ΣΣᵀ ⪰ 0,   Xᵢ = 2Σ (I − WᵢΣ)⁻¹

No certificate at these points proves more than the least value. That is not a convex problem, but it is a small one (m
unknowns, however many loops), so that places for the points can be compared in a tenth of a second. At a solution
Φ(x) is singular, and a multiplier Z with ⟨Z, Φ(x)⟩ = 0 lives on its kernel: there the certificate is looked for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from posreal.bounds.sampled import Sampled

Array = np.ndarray

_ACTIVE = 0.5  # eigenvalues of I − ΣΣᵀ below this count as the inequality's kernel


@dataclass(frozen=True)
class LocalSolution:
    """What was found.

    Attributes
    ----------
    value : float
        J at the points: what a certificate there may prove at most, if this is the global optimum.
    kernel : (r m, p)
        Orthonormal basis of what Φ(x) nearly annihilates.
    """

    value: float
    kernel: Array


def solve(data: Sampled, *, tolerance: float = 1e-5, growth: float = 5.0) -> LocalSolution:
    """Follow the barrier t ‖τ + Σ Oᵢxᵢ‖² − log det(I − ΣΣᵀ) from the damper c0, Σ = 0, by Gauss–Newton steps."""
    m = data.F.shape[0]
    size = float(np.sum(data.tau**2))
    sigma, t, last = np.zeros(m), m / size, m / (tolerance * size)
    while True:
        for _ in range(100):
            residual, slope = _residual(data, sigma)
            gradient, hessian = _barrier(data.F, sigma)
            gradient += 2 * t * slope.T @ residual
            hessian += 2 * t * slope.T @ slope
            step = -np.asarray(cho_solve(cho_factor(hessian, lower=True), gradient))
            decrement = float(-gradient @ step)
            if decrement < 1e-4:
                break
            moved = _descend(data, sigma, step, decrement, t)
            if moved is None:
                break
            sigma = moved
        if t >= last:
            break
        t = min(t * growth, last)
    return LocalSolution(float(np.linalg.norm(_residual(data, sigma)[0])), _kernel(data, sigma))


def _residual(data: Sampled, sigma: Array) -> tuple[Array, Array]:
    """τ + Σ Oᵢxᵢ over all outputs, and its derivative by σ: ∂Xᵢ = 2 (I − WᵢΣ)⁻² ∂Σ."""
    m = len(sigma)
    Sigma = np.tensordot(sigma, data.F, axes=1)
    residual, slope = data.tau.copy(), np.zeros((len(data.tau), m, m))
    for W, O in zip(data.W, data.O, strict=True):
        a = np.linalg.inv(np.eye(m) - W @ Sigma)
        residual += 2 * (O @ (Sigma @ a[:, 0]))
        slope += 2 * (O @ (a @ a))
    return residual.ravel(), slope.reshape(-1, m)


def _barrier(F: Array, sigma: Array) -> tuple[Array, Array]:
    """Gradient and Hessian of −log det(I − ΣΣᵀ)."""
    m = len(sigma)
    Sigma = np.tensordot(sigma, F, axes=1)
    G = np.linalg.inv(np.eye(m) - Sigma @ Sigma.T)
    flat = F.reshape(m, -1)
    B = Sigma.T @ G
    gradient = 2 * flat @ (G @ Sigma).ravel()
    hessian = 2 * (F @ (B @ Sigma + np.eye(m))).reshape(m, -1) @ (G @ F).reshape(m, -1).T
    hessian += 2 * flat @ np.swapaxes(B @ F @ B, 1, 2).reshape(m, -1).T
    return gradient, (hessian + hessian.T) / 2


def _descend(data: Sampled, sigma: Array, step: Array, decrement: float, t: float) -> Array | None:
    """Backtrack by Armijo's rule; None where rounding hides any descent."""

    def value(there: Array) -> float:
        Sigma = np.tensordot(there, data.F, axes=1)
        inside = np.linalg.eigvalsh(np.eye(len(there)) - Sigma @ Sigma.T)
        if inside[0] <= 0:
            return math.inf
        return t * float(np.sum(_residual(data, there)[0] ** 2)) - float(np.log(inside).sum())

    now, length = value(sigma), 1.0
    while length > 1e-10:
        if value(sigma + length * step) <= now - 0.1 * length * decrement:
            return sigma + length * step
        length /= 2
    return None


def _kernel(data: Sampled, sigma: Array) -> Array:
    """Vectors z with aᵀz in the kernel of I − ΣΣᵀ, a = [aᵢ(S)]ᵢ: those that aᵀ annihilates among them."""
    m = len(sigma)
    Sigma = np.tensordot(sigma, data.F, axes=1)
    values, vectors = np.linalg.eigh(np.eye(m) - Sigma @ Sigma.T)
    inactive = vectors[:, values >= _ACTIVE]
    a = np.vstack([np.linalg.inv(np.eye(m) - W @ Sigma) for W in data.W])
    full, _ = np.linalg.qr(a @ inactive, mode="complete")
    return np.asarray(full[:, inactive.shape[1] :])
