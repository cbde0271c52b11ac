"""The best certificate where the port is not passive, or where loops share the device: Shor's dual, by its barrier.

    maximise   c − bᵀ M⁻¹ b   over Z ⪰ 0 and μ with M ⪰ 0,        (c, b, M) affine in (Z, μ) as in `certificate`

Its barrier problem, maximise κ (c − bᵀM⁻¹b) + log det M + log det Z, is self-concordant (the last pivot of the bordered
matrix has been maximised out), and every point Newton's method visits is a certificate. With v = −M⁻¹b,

    d(c − bᵀM⁻¹b) = dc + 2 vᵀdb + vᵀ dM v,     second order: −2 (db + dM v)ᵀ M⁻¹ (db + dM v).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular

from posreal.design.bound.sampled import Sampled
from posreal.errors import BadInput

Array = np.ndarray


@dataclass(frozen=True)
class LiftedSolution:
    """Multipliers Z (r m, r m) and μ (pairs, m), and the value c − bᵀM⁻¹b they give in floats."""

    Z: Array
    mu: Array
    value: float
    steps: int


@dataclass(frozen=True)
class Form:
    """(c, b, M) as affine functions of y = (entries p ≤ q of Z, μ): constant part and one row a variable.

    Attributes
    ----------
    c0, b0, M0 : the part of the objective
    c1 : (n,), b1 : (n, N), M1 : (n, N, N)
    pairs : (2, n_Z), the (p, q) of each entry of Z
    """

    c0: float
    b0: Array
    M0: Array
    c1: Array
    b1: Array
    M1: Array
    pairs: Array

    def at(self, y: Array) -> tuple[float, Array, Array]:
        """c, b and M."""
        return (
            self.c0 + float(self.c1 @ y),
            self.b0 + y @ self.b1,
            self.M0 + np.tensordot(y, self.M1, axes=1),
        )

    def Z(self, y: Array) -> Array:
        """The multiplier as a matrix."""
        p, q = self.pairs
        Z = np.zeros((len(self.b0), len(self.b0)))
        Z[p, q] = Z[q, p] = y[: len(p)]
        return Z


def form(data: Sampled) -> Form:
    """The affine form of `certificate`'s formulas."""
    r, m, _ = data.W.shape
    W, F, N = data.W, data.F, r * m
    O = np.hstack([loop.reshape(-1, m) for loop in data.O])
    tau = data.tau.ravel()
    p, q = np.triu_indices(N)
    n = len(p)
    links = list(combinations(range(r), 2))
    total = n + len(links) * m
    c1, b1, M1 = np.zeros(total), np.zeros((total, N)), np.zeros((total, N, N))
    place = np.zeros((N, N), dtype=int)
    place[p, q] = place[q, p] = np.arange(n)
    c1[:n] = np.where(p == q, -4.0, np.where(p % m == q % m, -8.0, 0.0))
    for i in range(r):
        here = slice(i * m, (i + 1) * m)
        FW = F @ W[i]  # [k, a, c]
        for j in range(r):
            there = slice(j * m, (j + 1) * m)
            FA = F - FW @ W[j].T
            entries = np.einsum("kac,lbc->abkl", FA, F, optimize=True)
            rows = place[here, there]
            for a in range(m):
                # within one block of the diagonal, (a, b) and (b, a) are the same entry of Z
                np.add.at(M1[:, here, there], rows[a], entries[a])
                np.add.at(b1[:, here], rows[a], -2 * FW[:, a, :].T)
    for link, (i, j) in enumerate(links):
        # ½ Σₖ μₖ (T_d F_a)_kb
        hankel = 0.5 * np.einsum("kc,acb->kab", W[j] - W[i], F, optimize=True)
        for k in range(m):
            row = n + link * m + k
            b1[row, i * m + k], b1[row, j * m + k] = 1.0, -1.0
            M1[row, i * m : (i + 1) * m, j * m : (j + 1) * m] = hankel[k]
            M1[row, j * m : (j + 1) * m, i * m : (i + 1) * m] = hankel[k].T
    return Form(float(tau @ tau), O.T @ tau, O.T @ O, c1, b1, M1, np.array([p, q]))


def solve(
    data: Sampled,
    *,
    tolerance: float = 1e-5,
    growth: float = 10.0,
    progress: Callable[[str], None] | None = None,
) -> LiftedSolution:
    """Follow the central path of the dual.

    Parameters
    ----------
    data : Sampled
    tolerance : float
        Gap of the path's last point, relative to ‖τ‖².
    growth : float
        Factor by which κ grows from one point of the path to the next.
    progress : function of str, optional

    Raises
    ------
    BadInput
        If no starting point exists: with the device's coefficients free the figure is not a definite form.
    """
    size = float(np.linalg.norm(data.tau))
    Q = form(Sampled(data.tau / size, data.O / size, data.W, data.F))
    y = _start(Q)
    N = len(Q.b0)
    kappa, steps = 10.0 * N, 0
    last = 2 * N / tolerance
    best = (-math.inf, y)
    while True:
        for _ in range(40):
            steps += 1
            gradient, hessian = _derivatives(Q, y, kappa)
            step = _newton(gradient, hessian)
            decrement = math.sqrt(max(0.0, float(gradient @ step)))
            if decrement < 1e-2:
                break
            moved = _search(Q, y, step, decrement, kappa)
            if moved is None:
                break
            y = moved
            best = max(best, (_value(Q, y), y), key=lambda pair: pair[0])
            if decrement < 0.5:
                break
        if progress is not None:
            progress(f"bound {math.sqrt(max(best[0], 0.0)) * size:.6g}, gap of the path {2 * N / kappa:.1e}")
        if kappa >= last:
            break
        kappa = min(kappa * growth, last)
    y = best[1]
    r, m, _ = data.W.shape
    mu = y[len(Q.pairs[0]) :].reshape(r * (r - 1) // 2, m)
    return LiftedSolution(Q.Z(y) * size**2, mu * size**2, best[0] * size**2, steps)


def _start(Q: Form) -> Array:
    """Z = ε I, μ = 0 with ε small enough."""
    y = np.zeros(len(Q.c1))
    diagonal = Q.pairs[0] == Q.pairs[1]
    for exponent in range(0, 16):
        y[: len(diagonal)][diagonal] = 10.0 ** (-exponent / 2) / len(Q.b0)
        if np.linalg.eigvalsh(Q.at(y)[2])[0] > 0:
            return y
    raise BadInput("no certificate to start from at this expansion point; choose another ω0 or a smaller L")


def _value(Q: Form, y: Array) -> float:
    c, b, M = Q.at(y)
    return c - float(b @ cho_solve(cho_factor(M, lower=True), b))


def _barrier(Q: Form, y: Array, kappa: float) -> float:
    c, b, M = Q.at(y)
    try:
        factor, inner = cholesky(M, lower=True), cholesky(Q.Z(y), lower=True)
    except np.linalg.LinAlgError:
        return -math.inf
    half = solve_triangular(factor, b, lower=True)
    logs = float(np.log(np.diag(factor)).sum() + np.log(np.diag(inner)).sum())
    return kappa * (c - float(half @ half)) + 2 * logs


def _derivatives(Q: Form, y: Array, kappa: float) -> tuple[Array, Array]:
    """Gradient and minus the Hessian of the barrier problem."""
    _, b, M = Q.at(y)
    N, p, q = len(b), *Q.pairs
    factor = cholesky(M, lower=True)
    root = solve_triangular(factor, np.eye(N), lower=True)  # M⁻¹ = rootᵀ root
    v = -root.T @ (root @ b)
    pull = Q.b1 + Q.M1 @ v  # db + dM v, one row a variable
    half = (Q.M1.reshape(-1, N) @ root.T).reshape(-1, N, N)  # dM rootᵀ
    moved = (np.swapaxes(half, 1, 2).reshape(-1, N) @ root.T).reshape(-1, N, N)  # root dM rootᵀ, as dM is symmetric
    upper = np.triu_indices(N)
    packed = moved[:, upper[0], upper[1]] * np.where(upper[0] == upper[1], 1.0, math.sqrt(2.0))
    gradient = kappa * (Q.c1 + Q.b1 @ v + pull @ v) + np.trace(moved, axis1=1, axis2=2)
    whitened = math.sqrt(2 * kappa) * (pull @ root.T)
    rows = np.hstack([packed, whitened])
    hessian = rows @ rows.T
    inverse = np.asarray(cho_solve(cho_factor(Q.Z(y), lower=True), np.eye(N)))
    n = len(p)
    twice = np.where(p == q, 1.0, 2.0)
    gradient[:n] += twice * inverse[p, q]
    both = inverse[np.ix_(p, p)] * inverse[np.ix_(q, q)] + inverse[np.ix_(p, q)] * inverse[np.ix_(q, p)]
    hessian[:n, :n] += both * (twice * twice[:, None]) / 2
    return gradient, hessian


def _newton(gradient: Array, hessian: Array) -> Array:
    """The Newton step, with as little added to the scaled diagonal as lets Cholesky through."""
    scale = 1 / np.sqrt(np.diag(hessian))
    scaled = hessian * scale * scale[:, None]
    added = 1e-15
    while True:
        scaled[np.diag_indices(len(scale))] = 1 + added
        try:
            return np.asarray(scale * cho_solve(cho_factor(scaled, lower=True), scale * gradient))
        except np.linalg.LinAlgError:
            added *= 10


def _search(Q: Form, y: Array, step: Array, decrement: float, kappa: float) -> Array | None:
    """Backtrack until the barrier problem has gone up; None where rounding hides any rise."""
    now, length = _barrier(Q, y, kappa), 1.0
    while length > 1e-8:
        there = y + length * step
        if _barrier(Q, there, kappa) >= now + 0.1 * length * decrement**2 - 1e-11 * abs(now):
            return there
        length /= 2
    return None
