"""The best certificate for one passive port, by following the central path in the device's coefficients alone.

    minimise J(x)   subject to   Φ(x) = 4I + 2 X W + 2 (X W)ᵀ − X A Xᵀ ⪰ 0,   A = I − W Wᵀ ⪰ 0

with X = Σ xⱼ Fⱼ and J one of :mod:`objectives`. A passive port has A ⪰ 0; Φ is then concave, and −log det Φ(x) is, by
the Schur complement [[Φ + X A Xᵀ, X A^½], [A^½ Xᵀ, I]], a self-concordant barrier in x itself [NN1994]: m unknowns and
m × m matrices where the semidefinite program has a block of 2m and as many slack variables as that has entries. At a
point

    minimise t J(x) − log det Φ(x)

of the path, Z = Φ(x)⁻¹/t is the multiplier of a certificate that is short of the optimum by at most 2m/t (and 2m/t more
for a peak, whose own inequality has as many rows).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky

from posreal.bounds.objectives import Objective
from posreal.bounds.sampled import Sampled

Array = np.ndarray


@dataclass(frozen=True)
class PlainSolution:
    """x (m,) near the optimum, what certifies it, and the Newton steps taken.

    Attributes
    ----------
    x : (m,)
        Of the path's last point.
    Z : (m, m)
        Multiplier of the positive-real inequality, at the point of the path that certifies most.
    functional : array
        Multiplier of the objective there, see :mod:`objectives`.
    value : float
        The bound on J that these two promise, in floats.
    steps : int
    """

    x: Array
    Z: Array
    functional: Array
    value: float
    steps: int


def solve(data: Sampled, goal: Objective, *, tolerance: float = 1e-8, growth: float = 30.0) -> PlainSolution:
    """Follow the central path from the damper c0, x = 0.

    Parameters
    ----------
    data : Sampled
        Of one loop.
    goal : Objective
    tolerance : float
        m/t, relative to the objective's size, at the end. The certificate is measured on its own; this only says when
        to stop.
    growth : float
        Factor by which t grows from one point of the path to the next.
    """
    W, F = data.W[0], data.F
    m = len(W)
    A = np.eye(m) - W @ W.T
    y, steps = goal.start(np.zeros(m)), 0
    t, last = m / goal.size, m / (tolerance * goal.size)
    best: PlainSolution | None = None

    def value(there: Array) -> float:
        try:
            factor = cholesky(_inequality(there[:m], W, A, F), lower=True)
        except np.linalg.LinAlgError:
            return math.inf
        return goal.value(there, t) - 2 * float(np.log(np.diag(factor)).sum())

    while True:
        for _ in range(50):
            steps += 1
            gradient, hessian = goal.derivatives(y, t)
            slope, curvature, G = _derivatives(y[:m], W, A, F)
            gradient[:m] += slope
            hessian[:m, :m] += curvature
            step = -np.asarray(cho_solve(cho_factor(hessian, lower=True), gradient))
            decrement = math.sqrt(max(0.0, float(-gradient @ step)))
            if decrement < 1e-2:
                break
            y = _descend(value, y, step, decrement)
        functional = goal.multiplier(y, t)
        found = PlainSolution(y[:m], G / t, functional, _certified(G / t, W, A, F, goal.lower(functional)), steps)
        best = found if best is None or found.value > best.value else best
        if t >= last:
            return replace(best, x=y[:m], steps=steps)
        t = min(t * growth, last)


def _certified(Z: Array, W: Array, A: Array, F: Array, part: tuple[float, Array, Array, bool]) -> float:
    """c − bᵀ M⁻¹ b of :mod:`certificate` for one loop, in floats, as a bound on J; 0 without M ≻ 0."""
    m = len(W)
    c, b, M, squared = part
    b = b - 2 * F.reshape(m, -1) @ (Z @ W.T).ravel()
    M = M + (F @ A).reshape(m, -1) @ (Z @ F).reshape(m, -1).T
    try:
        value = c - 4 * float(np.trace(Z)) - float(b @ cho_solve(cho_factor(M, lower=True), b))
    except np.linalg.LinAlgError:
        return 0.0
    return math.sqrt(max(value, 0.0)) if squared else value


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


def _descend(value: Callable[[Array], float], y: Array, step: Array, decrement: float) -> Array:
    """Backtrack until the barrier problem has gone down by Armijo's rule; y itself where rounding hides any descent."""
    now, length = value(y), 1.0
    while length > 1e-10:
        there = y + length * step
        if value(there) <= now - 0.1 * length * decrement**2 + 1e-12 * abs(now):
            return there
        length /= 2
    return y
