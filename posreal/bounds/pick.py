"""The device that is best at distinct points, and in one loop the certificate that it leaves behind.

    minimise ‖P_K z‖²   over the values σₖ at the points for which K − D_σ K D_σ* ⪰ 0 [Pick1916]

by Newton's method on the path of t ‖P_K z‖² − log det Φ. The unknown is y = 2σ/(1 − w₀σ), and xᵢ = y/(1 − δᵢy/2),
δᵢ = wᵢ − w₀, and Φ(y) = K ∘ (a a* − y y*), a = 2 + w₀y. With G = Φ⁻¹, L = D_w₀ K D_a* − K D_y* and Q = L G,

    d(−log det Φ) = −2 Re Σ Qₖₖ dyₖ,    d² = 2 Re dyᵀ(Q ∘ Qᵀ)dy + 2 dyᵀ[Gᵀ ∘ (L G L* + K ∘ (1 − w₀w₀*))] dȳ.

*One loop*, w₀ = w: y = x, ‖P_K z‖² is a quadratic form in x and Φ is the matrix of :mod:`value_form`. At a point of the
path d(J² − ⟨Z, Φ⟩) = 0 for Z = Φ⁻¹/t, so c − b*M⁻¹b = J² − ⟨Z, Φ⟩ = J² − m/t wherever M ≻ 0: the best certificate in
closed form, no semidefinite program. For a port that is passive at the points Z ∘ [K̄ ∘ (1 − w̄wᵀ)] is the product, entry
by entry, of positive definite matrices, so M ≻ 0 [Schur1911] and the problem is convex; for others the check decides.
(The path of −log det(K − D_σKD_σ*) leaves a gradient of the order 1/t, as log det D_a moves too.)

*Several loops*, w₀ = 0: not convex, m unknowns however many loops; a guide for points and certificate, no proof.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky, eigh

from posreal.bounds.values import Values

Array = np.ndarray

_CENTRED = 1.0  # squared Newton decrement at which the path goes on before its end


@dataclass(frozen=True)
class PickSolution:
    """A point of the path.

    Attributes
    ----------
    y : (m,)
        Complex, conjugation symmetric.
    t : float
        Weight of J² there.
    value : float
        ‖P_K z‖: J at the points.
    inverse : (m, m)
        Φ(y)⁻¹.
    steps : int
        Newton steps in all.
    centred : bool
        Whether Newton's method came to the path there; otherwise `value` may be far above the least one.
    """

    y: Array
    t: float
    value: float
    inverse: Array
    steps: int
    centred: bool


def solve(seen: Values, *, tolerance: float = 1e-6, growth: float = 10.0) -> PickSolution:
    """Follow the path from the damper c0, y = 0, until m/t is the tolerance relative to J²."""
    r, m = seen.w.shape
    w0 = seen.w[0] if r == 1 else np.zeros(m, dtype=complex)
    delta = seen.w - w0
    whole = np.conj(seen.g)[:, None] * seen.K.conj() * seen.g[None, :]  # K⁻¹
    y = np.zeros(m, dtype=complex)
    J2 = _squares(seen, whole, delta, y)
    t, steps = m / J2, 0
    while True:
        near = 1e-4 if t * J2 * tolerance >= m * (1 - 1e-9) else _CENTRED
        for _ in range(60):
            steps += 1
            gradient, hessian = _objective(seen, whole, delta, y)
            slope, curvature, _ = _barrier(seen.K, w0, y, seen.mirror)
            gradient, hessian = t * gradient + slope, t * hessian + curvature
            step = _newton(gradient, hessian)
            decrement = float(-gradient @ step)
            moved = _descend(seen, whole, delta, w0, y, _complex(step, seen.mirror), decrement, t)
            if moved is None:
                break
            y = moved
            if decrement < near:
                break
        centred = decrement < _CENTRED
        J2 = _squares(seen, whole, delta, y)
        if near < _CENTRED:
            return PickSolution(y, t, math.sqrt(J2), _barrier(seen.K, w0, y, seen.mirror)[2], steps, centred)
        t = min(t * growth, m / (tolerance * J2))


def _residual(seen: Values, delta: Array, y: Array) -> tuple[Array, Array, Array]:
    """z, ∂z/∂y and ∂²z/∂y² at the points, (outputs, m)."""
    a = 1 / (1 - delta * y / 2)
    z = seen.tau + np.einsum("rok,rk->ok", seen.o, y * a)
    return z, np.einsum("rok,rk->ok", seen.o, a**2), np.einsum("rok,rk->ok", seen.o, delta * a**3)


def _squares(seen: Values, whole: Array, delta: Array, y: Array) -> float:
    z = _residual(seen, delta, y)[0]
    return float(np.sum((z.conj() @ whole) * z).real)


def _objective(seen: Values, whole: Array, delta: Array, y: Array) -> tuple[Array, Array]:
    """Gradient and Hessian of ‖P_K z‖² in real coordinates."""
    z, slope, bend = _residual(seen, delta, y)
    back = z.conj() @ whole  # (K⁻¹z)*
    gradient = 2 * _real((back * slope).sum(axis=0), seen.mirror)
    quadratic = whole.conj() * sum(np.outer(part, part.conj()) for part in slope)
    curved = np.diag((back * bend).sum(axis=0))
    return gradient, _quadratic(curved, quadratic, seen.mirror)


def _barrier(K: Array, w0: Array, y: Array, mirror: Array) -> tuple[Array, Array, Array]:
    """Gradient and Hessian of −log det Φ in real coordinates, and Φ⁻¹."""
    a = 2 + w0 * y
    factor = cho_factor(K * (np.outer(a, a.conj()) - np.outer(y, y.conj())), lower=True)
    G = np.asarray(cho_solve(factor, np.eye(len(y))))
    L = w0[:, None] * K * a.conj() - K * y.conj()
    Q = L @ G
    flow = Q @ L.conj().T + K * (1 - np.outer(w0, w0.conj()))
    return -2 * _real(np.diag(Q), mirror), _quadratic(Q * Q.T, G.T * flow, mirror), G


def _quadratic(A: Array, B: Array, mirror: Array) -> Array:
    """The symmetric matrix of 2 Re dyᵀA dy + 2 dyᵀB dȳ in real coordinates."""
    lower = np.arange(len(mirror)) > mirror
    found = _columns(_columns(A, mirror, lower).T, mirror, lower).real
    found += _columns(_columns(B, mirror, lower, conj=True).T, mirror, lower).real.T
    return np.asarray(found + found.T)


def _columns(A: Array, mirror: Array, lower: Array, conj: bool = False) -> Array:
    """A T, or A T̄, for y = T η: a pair's two coordinates p, q stand for p + iq and p − iq."""
    turned = A.astype(complex)
    upper = ~lower & (mirror != np.arange(len(mirror)))
    up, down = A[:, upper], A[:, mirror[upper]]
    turned[:, upper] = up + down
    turned[:, mirror[upper]] = (-1j if conj else 1j) * (up - down)
    return turned


def _real(gradient: Array, mirror: Array) -> Array:
    """Re Σ gₖ dyₖ as a vector in real coordinates."""
    lower = np.arange(len(mirror)) > mirror
    return np.asarray(_columns(gradient[None, :], mirror, lower)[0].real)


def _complex(step: Array, mirror: Array) -> Array:
    """T η."""
    k = np.arange(len(mirror))
    return np.where(mirror == k, step, np.where(mirror > k, step + 1j * step[mirror], step[mirror] - 1j * step))


def _newton(gradient: Array, hessian: Array) -> Array:
    """−H⁻¹g, with |H| for H where it is not positive definite."""
    try:
        return -np.asarray(cho_solve(cho_factor(hessian, lower=True), gradient))
    except np.linalg.LinAlgError:
        scale = 1 / np.sqrt(np.abs(np.diag(hessian)))
        values, vectors = eigh(hessian * scale * scale[:, None])
        values = np.maximum(np.abs(values), 1e-12 * np.abs(values).max())
        return -np.asarray(scale * (vectors @ ((vectors.T @ (scale * gradient)) / values)))


def _descend(
    seen: Values, whole: Array, delta: Array, w0: Array, y: Array, step: Array, decrement: float, t: float
) -> Array | None:
    """Backtrack by Armijo's rule; None where rounding hides any descent."""

    def value(there: Array) -> float:
        a = 2 + w0 * there
        try:
            root = cholesky(seen.K * (np.outer(a, a.conj()) - np.outer(there, there.conj())), lower=True)
        except np.linalg.LinAlgError:
            return math.inf
        return t * _squares(seen, whole, delta, there) - 2 * float(np.log(np.diag(root).real).sum())

    now, length = value(y), 1.0
    while length > 1e-10:
        there = y + length * step
        if value(there) <= now - 0.1 * length * decrement + 1e-14 * abs(now):
            return there
        length /= 2
    return None
