"""The best certificate for one passive port, by following the central path in the device's coefficients alone.

    minimise ‖τ + O x‖²   subject to   Φ(x) = 4I + 2 X W + 2 (X W)ᵀ − X A Xᵀ ⪰ 0,   A = I − W Wᵀ ⪰ 0

with X = Σ xⱼ Fⱼ. A passive port has A ⪰ 0; Φ is then concave, and −log det Φ(x) is, by the Schur complement
[[Φ + X A Xᵀ, X A^½], [A^½ Xᵀ, I]], a self-concordant barrier in x itself [NN1994]: m unknowns and m × m matrices where the
semidefinite program has a block of 2m and as many slack variables as that has entries. On the central path, at

    minimise t ‖τ + O x‖² − log det Φ(x),

Z = Φ(x)⁻¹/t is the multiplier of a certificate that is short of the optimum by at most 2m/t.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky

from posreal.design.bound.sampled import Sampled

Array = np.ndarray


@dataclass(frozen=True)
class PlainSolution:
    """x (m,) near the optimum, the multiplier Z (m, m) that certifies it, and the Newton steps taken."""

    x: Array
    Z: Array
    steps: int


def solve(data: Sampled, *, tolerance: float = 1e-8, growth: float = 30.0) -> PlainSolution:
    """Follow the central path from the damper c0, x = 0.

    Parameters
    ----------
    data : Sampled
        Of one loop.
    tolerance : float
        Gap m/t, relative to ‖τ‖² at the end. The certificate is measured on its own; this only says when to stop.
    growth : float
        Factor by which t grows from one point of the path to the next.
    """
    W, F = data.W[0], data.F
    m = len(W)
    A = np.eye(m) - W @ W.T
    O, r = data.O[0].reshape(-1, m), data.tau.ravel()
    quadratic, linear = O.T @ O, O.T @ r
    size = float(r @ r)
    t, x, steps = m / size, np.zeros(m), 0
    last = m / (tolerance * size)
    while True:
        for _ in range(50):
            steps += 1
            gradient, hessian, G = _derivatives(x, W, A, F)
            gradient = gradient + 2 * t * (linear + quadratic @ x)
            hessian = hessian + 2 * t * quadratic
            step = -np.asarray(cho_solve(cho_factor(hessian, lower=True), gradient))
            decrement = math.sqrt(max(0.0, float(-gradient @ step)))
            if decrement < 1e-2:
                break
            x = _search(x, step, decrement, t, quadratic, linear, W, A, F)
        if t >= last:
            return PlainSolution(x, G / t, steps)
        t = min(t * growth, last)


def _inequality(x: Array, W: Array, A: Array, F: Array) -> Array:
    X = np.tensordot(x, F, axes=1)
    XW = X @ W
    return np.asarray(4 * np.eye(len(x)) + 2 * (XW + XW.T) - X @ A @ X.T)


def _derivatives(x: Array, W: Array, A: Array, F: Array) -> tuple[Array, Array, Array]:
    """Gradient and Hessian of −log det Φ, and Φ⁻¹. With K = 2 W − A Xᵀ, ∂Φ/∂xⱼ = Fⱼ K + (Fⱼ K)ᵀ."""
    m = len(x)
    G = np.asarray(cho_solve(cho_factor(_inequality(x, W, A, F), lower=True), np.eye(m)))
    K = 2 * W - A @ np.tensordot(x, F, axes=1).T
    flat = F.reshape(m, m * m)
    gradient = -2 * flat @ (G @ K.T).ravel()
    B = K @ G
    # 2 ⟨G, Fⱼ (K G Kᵀ + A) Fₖᵀ⟩ + 2 tr(B Fⱼ B Fₖ)
    hessian = 2 * (F @ (B @ K.T + A)).reshape(m, -1) @ (G @ F).reshape(m, -1).T
    hessian += 2 * flat @ np.swapaxes(B @ F @ B, 1, 2).reshape(m, -1).T
    return gradient, (hessian + hessian.T) / 2, G


def _search(
    x: Array,
    step: Array,
    decrement: float,
    t: float,
    quadratic: Array,
    linear: Array,
    W: Array,
    A: Array,
    F: Array,
) -> Array:
    """Backtrack until Φ ≻ 0 and the barrier problem has gone down by Armijo's rule."""

    def value(y: Array) -> float:
        try:
            factor = cholesky(_inequality(y, W, A, F), lower=True)
        except np.linalg.LinAlgError:
            return math.inf
        return t * float(y @ (quadratic @ y) + 2 * linear @ y) - 2 * float(np.log(np.diag(factor)).sum())

    now, length = value(x), 1.0
    while length > 1e-10:
        there = x + length * step
        if value(there) <= now - 0.1 * length * decrement**2 + 1e-12 * abs(now):
            return there
        length /= 2
    return x
