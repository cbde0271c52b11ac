"""The best certificate where the port is not passive, or where loops share the device: Shor's dual, by its barrier.

    maximise   c − bᵀ M⁻¹ b   over Z ⪰ 0 and μ with M ⪰ 0,        (c, b, M) affine in (Z, μ) as in `certificate`

Its barrier problem, maximise κ (c − bᵀM⁻¹b) + log det M + log det Z, is self-concordant (the last pivot of the bordered
matrix has been maximised out), and every point Newton's method visits is a certificate. With v = −M⁻¹b,

    d(c − bᵀM⁻¹b) = dc + 2 vᵀdb + vᵀ dM v,     second order: −2 (db + dM v)ᵀ M⁻¹ (db + dM v).

Z has r m (r m + 1)/2 entries for r loops and m dimensions. Where the best device at the points is known
(`device_at_points`), Z = V Λ Vᵀ on the kernel V of its Φ holds the optimum, or nearly, with half as many.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular

from posreal.bounds.sampled import Sampled
from posreal.errors import BadInput

Array = np.ndarray

_CENTRED = 3.0  # Newton decrement at which κ grows: every point is a certificate, so none needs to be exact


@dataclass(frozen=True)
class LiftedSolution:
    """Multipliers Z = C Cᵀ, C (r m, p), and μ (pairs, m), and the value c − bᵀM⁻¹b they give in floats."""

    C: Array
    mu: Array
    value: float
    steps: int


@dataclass(frozen=True)
class Form:
    """(c, b, M) as affine functions of y = (entries p ≤ q of Λ, μ), where Z = V Λ Vᵀ.

    For the columns V_p of V, loop by loop, with sums s_p = Σᵢ V_pᵢ and with

        (P_p)ᵢₖ = V_pᵢᵀ Fₖ,   (Q_p)ᵢₖ = V_pᵢᵀ FₖWᵢ   (rows of length m)

    the formulas of `certificate` are c = c0 − 4 Σ Λ_pq s_pᵀs_q, b = b0 − 2 Σ Λ_pq Q_p s_q and
    M = M0 + Σ Λ_pq (P_p P_qᵀ − Q_p Q_qᵀ), and the part of μ.

    Attributes
    ----------
    c0, b0, M0 : the part of the objective
    V : (N, p), N = r m
    P, Q : (p, N, m)
    s : (p, m)
    b_mu : (n, N), M_mu : (n, N, N)
        One row a multiplier.
    """

    c0: float
    b0: Array
    M0: Array
    V: Array
    P: Array
    Q: Array
    s: Array
    b_mu: Array
    M_mu: Array

    @cached_property
    def pairs(self) -> tuple[Array, Array]:
        """p and q of each entry of Λ in y."""
        return np.triu_indices(self.V.shape[1])

    def Lambda(self, y: Array) -> Array:
        """Λ as a matrix."""
        p, q = self.pairs
        size = self.V.shape[1]
        found = np.zeros((size, size))
        found[p, q] = found[q, p] = y[: len(p)]
        return found

    def at(self, y: Array) -> tuple[float, Array, Array]:
        """c, b and M."""
        Lambda, mu = self.Lambda(y), y[len(self.pairs[0]) :]
        weighted = Lambda @ self.s
        M = self.M0 + np.tensordot(mu, self.M_mu, axes=1)
        for part, sign in ((self.P, 1.0), (self.Q, -1.0)):
            M += sign * np.tensordot(part, np.tensordot(Lambda, part, axes=1), axes=((0, 2), (0, 2)))
        b = self.b0 + mu @ self.b_mu - 2 * np.tensordot(self.Q, weighted, axes=((0, 2), (0, 1)))
        return self.c0 - 4 * float(np.sum(self.s * weighted)), b, (M + M.T) / 2


def form(data: Sampled, V: Array) -> Form:
    """The affine form of `certificate`'s formulas for Z = V Λ Vᵀ."""
    r, m, _ = data.W.shape
    W, F, N = data.W, data.F, r * m
    O = np.hstack([loop.reshape(-1, m) for loop in data.O])
    tau = data.tau.ravel()
    parts = V.T.reshape(-1, r, m)  # [p, i, a]
    P = np.tensordot(parts, F, axes=(2, 1))  # [p, i, k, c]
    Q = np.stack([P[:, i] @ W[i] for i in range(r)], axis=1)
    links = list(combinations(range(r), 2))
    b_mu, M_mu = np.zeros((len(links) * m, N)), np.zeros((len(links) * m, N, N))
    for link, (i, j) in enumerate(links):
        # ½ Σₖ μₖ (T_d F_a)_kb
        hankel = 0.5 * np.einsum("kc,acb->kab", W[j] - W[i], F, optimize=True)
        for k in range(m):
            row = link * m + k
            b_mu[row, i * m + k], b_mu[row, j * m + k] = 1.0, -1.0
            M_mu[row, i * m : (i + 1) * m, j * m : (j + 1) * m] = hankel[k]
            M_mu[row, j * m : (j + 1) * m, i * m : (i + 1) * m] = hankel[k].T
    sums = parts.sum(axis=1)
    return Form(float(tau @ tau), O.T @ tau, O.T @ O, V, P.reshape(-1, N, m), Q.reshape(-1, N, m), sums, b_mu, M_mu)


def solve(
    data: Sampled,
    V: Array | None = None,
    *,
    tolerance: float = 1e-5,
    growth: float = 10.0,
    progress: Callable[[str], None] | None = None,
) -> LiftedSolution:
    """Follow the central path of the dual.

    Parameters
    ----------
    data : Sampled
    V : (r m, p), optional
        Only multipliers Z = V Λ Vᵀ are looked for; all by default.
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
    r, m, _ = data.W.shape
    size = float(np.linalg.norm(data.tau))
    Q = form(Sampled(data.tau / size, data.O / size, data.W, data.F), np.eye(r * m) if V is None else V)
    y = _start(Q)
    degree = len(Q.b0) + Q.V.shape[1]
    kappa, steps = 5.0 * degree, 0
    last = degree / tolerance
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
            if decrement < _CENTRED:
                break
        if progress is not None:
            progress(f"bound {math.sqrt(max(best[0], 0.0)) * size:.6g}, gap of the path {degree / kappa:.1e}")
        if kappa >= last:
            break
        kappa = min(kappa * growth, last)
    y = best[1]
    mu = y[len(Q.pairs[0]) :].reshape(r * (r - 1) // 2, m)
    C = np.transpose(np.linalg.qr((Q.V @ cholesky(Q.Lambda(y), lower=True)).T, mode="r"))  # zero above its diagonal
    return LiftedSolution(C * size, mu * size**2, best[0] * size**2, steps)


def _start(Q: Form) -> Array:
    """Λ = ε I, μ = 0 with ε small enough."""
    y = np.zeros(len(Q.pairs[0]) + len(Q.b_mu))
    diagonal = np.flatnonzero(Q.pairs[0] == Q.pairs[1])
    for exponent in range(0, 16):
        y[diagonal] = 10.0 ** (-exponent / 2) / len(Q.b0)
        if np.linalg.eigvalsh(Q.at(y)[2])[0] > 0:
            return y
    raise BadInput("no certificate to start from at this expansion point; choose another ω0 or a smaller L")


def _value(Q: Form, y: Array) -> float:
    c, b, M = Q.at(y)
    return c - float(b @ cho_solve(cho_factor(M, lower=True), b))


def _barrier(Q: Form, y: Array, kappa: float) -> float:
    c, b, M = Q.at(y)
    try:
        factor, inner = cholesky(M, lower=True), cholesky(Q.Lambda(y), lower=True)
    except np.linalg.LinAlgError:
        return -math.inf
    half = solve_triangular(factor, b, lower=True)
    logs = float(np.log(np.diag(factor)).sum() + np.log(np.diag(inner)).sum())
    return kappa * (c - float(half @ half)) + 2 * logs


def _derivatives(Q: Form, y: Array, kappa: float) -> tuple[Array, Array]:
    """Gradient and minus the Hessian of the barrier problem."""
    _, b, M = Q.at(y)
    N, (p, q) = len(b), Q.pairs
    n, count = len(p), len(p) + len(Q.b_mu)
    root = solve_triangular(cholesky(M, lower=True), np.eye(N), lower=True)  # M⁻¹ = rootᵀ root
    v = -root.T @ (root @ b)
    upper = np.triu_indices(N)
    scale = np.where(upper[0] == upper[1], 1.0, math.sqrt(2.0))
    diagonal = upper[0] == upper[1]
    rows = np.empty((count, len(scale) + N))  # of every variable: root dM rootᵀ packed, root (db + dM v)
    slope = np.empty(count)  # dc + 2 vᵀdb + vᵀdM v
    P, R = root @ Q.P, root @ Q.Q
    Pv, Qv = np.swapaxes(Q.P, 1, 2) @ v, np.swapaxes(Q.Q, 1, 2) @ v
    row = 0
    for first in range(Q.V.shape[1]):
        rest = slice(first, None)
        here = slice(row, row + Q.V.shape[1] - first)
        moved = np.matmul(P[rest], P[first].T) - np.matmul(R[rest], R[first].T)
        moved = moved + np.swapaxes(moved, 1, 2)
        pull = P[rest] @ Pv[first] + Pv[rest] @ P[first].T - R[rest] @ Qv[first] - Qv[rest] @ R[first].T
        pull -= 2 * (R[rest] @ Q.s[first] + Q.s[rest] @ R[first].T)
        turned = 2 * (Pv[rest] @ Pv[first] - Qv[rest] @ Qv[first])
        turned -= 8 * (Q.s[rest] @ Q.s[first]) + 4 * (Qv[rest] @ Q.s[first] + Q.s[rest] @ Qv[first])
        for part in (moved, pull, turned):
            part[0] /= 2  # an entry of the diagonal stands once in Λ
        rows[here, : len(scale)] = moved[:, upper[0], upper[1]] * scale
        rows[here, len(scale) :] = pull
        slope[here] = turned
        row = here.stop
    if len(Q.b_mu):
        moved = root @ Q.M_mu @ root.T
        rows[n:, : len(scale)] = moved[:, upper[0], upper[1]] * scale
        felt = Q.M_mu @ v
        rows[n:, len(scale) :] = (Q.b_mu + felt) @ root.T
        slope[n:] = 2 * Q.b_mu @ v + felt @ v
    gradient = kappa * slope + rows[:, : len(scale)][:, diagonal].sum(axis=1)
    rows[:, len(scale) :] *= math.sqrt(2 * kappa)
    hessian = rows @ rows.T
    inverse = np.asarray(cho_solve(cho_factor(Q.Lambda(y), lower=True), np.eye(Q.V.shape[1])))
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
