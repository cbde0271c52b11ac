"""The best certificate for one passive port, by following the central path in the device's coefficients alone.

    minimise ‖τ + T_o x‖²   subject to   F(x) = 4I + 2 X W + 2 (X W)ᵀ − X A Xᵀ ⪰ 0,   A = I − W Wᵀ ⪰ 0

with X = T_x, W = T_w. A passive port has A ⪰ 0; F is then concave, and −log det F(x) is, by the Schur complement
[[F + X A Xᵀ, X A^½], [A^½ Xᵀ, I]], a self-concordant barrier in x itself, of parameter 2m: m unknowns and m × m matrices
where the semidefinite program has a block of 2m. On the central path, at

    minimise t ‖τ + T_o x‖² − log det F(x),

Z = F(x)⁻¹/t is the multiplier of a certificate that is short of the optimum by at most m/t.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky

from posreal.design.bound.toeplitz import correlation, diagonal_sums, lower

Array = np.ndarray


@dataclass(frozen=True)
class PlainSolution:
    """x (m,) near the optimum, and the multiplier Z (m, m) that certifies it."""

    x: Array
    Z: Array
    steps: int


def solve(tau: Array, o: Array, w: Array, *, tolerance: float = 1e-7, growth: float = 30.0) -> PlainSolution:
    """Follow the central path from the damper c0, x = 0.

    Parameters
    ----------
    tau, o : (rows, m)
        Coefficients of each output with x = 0 and of its sensitivity to x.
    w : (m,)
        Coefficients of the port's reflection, |w| ≤ 1 on the disc.
    tolerance : float
        Gap m/t, relative to ‖τ‖² at the end. The certificate is measured on its own; this only says when to stop.
    growth : float
        Factor by which t grows from one point of the path to the next.
    """
    m = len(w)
    W = lower(w)
    A = np.eye(m) - W @ W.T
    O = np.vstack([lower(row) for row in o])
    r = tau.ravel()
    quadratic, linear = O.T @ O, O.T @ r
    size = float(r @ r)
    t, x, steps = m / size, np.zeros(m), 0
    last = m / (tolerance * size)
    while True:
        for _ in range(50):
            steps += 1
            gradient, hessian, G = _derivatives(x, W, A)
            gradient = gradient + 2 * t * (linear + quadratic @ x)
            hessian = hessian + 2 * t * quadratic
            step = -np.asarray(cho_solve(cho_factor(hessian, lower=True), gradient))
            decrement = math.sqrt(max(0.0, float(-gradient @ step)))
            if decrement < 1e-3:
                break
            x = _search(x, step, decrement, t, quadratic, linear, W, A)
        if t >= last:
            return PlainSolution(x, G / t, steps)
        t = min(t * growth, last)


def _inequality(x: Array, W: Array, A: Array) -> Array:
    X = lower(x)
    XW = X @ W
    return np.asarray(4 * np.eye(len(x)) + 2 * (XW + XW.T) - X @ A @ X.T)


def _derivatives(x: Array, W: Array, A: Array) -> tuple[Array, Array, Array]:
    """Gradient and Hessian of −log det F, and F⁻¹. With K = 2 W − A Xᵀ, ∂F/∂xⱼ = Sⱼ K + (Sⱼ K)ᵀ."""
    G = np.asarray(cho_solve(cho_factor(_inequality(x, W, A), lower=True), np.eye(len(x))))
    K = 2 * W - A @ lower(x).T
    gradient = -2 * diagonal_sums(G @ K.T)
    B = K @ G
    hessian = 2 * correlation(G, B @ K.T + A)
    for j in range(len(x)):  # tr(B Sⱼ B Sₖ) = Σ_b (Bᵀ…)[b + k, b]
        hessian[j] += 2 * diagonal_sums((_shifted(B, j) @ B).T)
    return gradient, (hessian + hessian.T) / 2, G


def _shifted(B: Array, j: int) -> Array:
    """B Sⱼ."""
    out = np.zeros_like(B)
    out[:, : len(B) - j] = B[:, j:]
    return out


def _search(
    x: Array, step: Array, decrement: float, t: float, quadratic: Array, linear: Array, W: Array, A: Array
) -> Array:
    """Backtrack until F ≻ 0 and the barrier problem has gone down by Armijo's rule."""

    def value(y: Array) -> float:
        try:
            factor = cholesky(_inequality(y, W, A), lower=True)
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
