"""Several loops of one device: climb from certificate to certificate.

    maximise  c − b*M⁻¹b + ε log det M   over Z = C C* and μ,      (c, b, M) as in :mod:`value_form`

No semidefinite program: with M ≻ 0 every (C, μ) proves something, and the gradient takes a few products of matrices.
With v = −M⁻¹b, where the Lagrangian is least, and d = wⱼ − wᵢ,

    ∂/∂Z = −Φ(v) + ε H ∘ M⁻¹,  H = K ∘ (1 − w w*),     ∂/∂μᵢⱼ = d vᵢvⱼ − 2vⱼ + 2vᵢ + ε (dₖ (M⁻¹)₍ⱼₖ₎₍ᵢₖ̄₎)ₖ

the inequality and the equality at v, and what keeps M positive definite. Steps are those of limited-memory BFGS
[Nocedal1980], in variables in which the first Z is I.

*Where it starts.* At the best device of the points (:mod:`pick`), with Λ = (K − D_σKD_σ*)⁻¹/t and aᵢ = 2/(1 − wᵢσ), the
multipliers Z = E Λ E*, E = [D_ā₁⁻¹; …; D_āᵣ⁻¹]/r, and μ₁ⱼ = rⱼ/(1 − conj(d x₁)/2), r = b + M x without μ, make the
Lagrangian stationary in all xᵢ up to terms of the order 1/t², with the value J² − m/t. M has a few small negative
eigenvalues there, and Z + αI with the least α that mends them is the first certificate. That M ⪰ 0 can be reached at
next to no cost in J² is seen, not proven; the proof of what comes out needs none of this.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from posreal.bounds import pick
from posreal.bounds.value_form import form
from posreal.bounds.values import Values
from posreal.errors import BadInput

Array = np.ndarray

_STAGES = ((1e-4, 3e-4, 1000), (1e-5, 1e-4, 1500))  # ε relative to J²; gain in a round below which it ends; most steps
_ROUND = 100  # steps
_MEMORY = 30
_PATH = 1e-3  # m/t relative to J² at the start
_MOST_ADDED = 1e4  # α relative to J² at most


@dataclass(frozen=True)
class Climbed:
    """Z (r m, r m) Hermitian and μ (pairs, m), conjugation symmetric; √(c − b*M⁻¹b) in floats, and J at the points."""

    Z: Array
    mu: Array
    value: float
    reach: float


class _Turn:
    """Between values at the points, conjugation symmetric, and real orthonormal coordinates."""

    def __init__(self, mirror: Array) -> None:
        k = np.arange(len(mirror))
        self.up = k[mirror > k]
        self.down = mirror[self.up]

    def real(self, A: Array) -> Array:
        """U* A U."""
        return self._rows(self._rows(A).conj().T).conj().T.real

    def _rows(self, A: Array) -> Array:
        found = A.astype(complex)
        found[self.up] = (A[self.up] + A[self.down]) * np.sqrt(0.5)
        found[self.down] = (A[self.up] - A[self.down]) * -1j * np.sqrt(0.5)
        return found

    def vector(self, x: Array) -> Array:
        """U* x."""
        return self._rows(x).real

    def back(self, x: Array) -> Array:
        """U x."""
        found = x.astype(complex)
        found[self.up] = (x[self.up] + 1j * x[self.down]) * np.sqrt(0.5)
        found[self.down] = (x[self.up] - 1j * x[self.down]) * np.sqrt(0.5)
        return found

    def whole(self, A: Array) -> Array:
        """U A U*."""
        return self.back(self.back(A).conj().T).conj().T


@dataclass(frozen=True)
class _Point:
    """(C, μ) in real coordinates, as one vector beside its shapes."""

    seen: Values
    turn: _Turn
    small: _Turn
    first: Array  # the Cholesky factor of the first Z
    scale: float  # of μ

    def parts(self, u: Array) -> tuple[Array, Array]:
        """C and μ (pairs, m), complex."""
        N = len(self.first)
        mu = u[N * N :].reshape(-1, self.seen.size) * self.scale
        return self.first @ u[: N * N].reshape(N, N), np.array([self.small.back(row) for row in mu])

    def evaluate(self, u: Array, epsilon: float) -> tuple[float, Array, float] | None:
        """Minus the objective, minus its gradient, and c − b*M⁻¹b; None where M is not positive definite."""
        seen, (r, m) = self.seen, self.seen.w.shape
        C, mu = self.parts(u)
        c, b, M = form(seen, self.turn.whole(C @ C.T), mu)
        try:
            root = cholesky(self.turn.real(M), lower=True)
        except np.linalg.LinAlgError:
            return None
        half = solve_triangular(root, np.eye(r * m), lower=True)
        inverse = half.T @ half
        pull = self.turn.vector(b)
        v = -inverse @ pull
        value = float(c + pull @ v)
        x, w = self.turn.back(v), seen.w.ravel()
        a, G = 2 + w * x, epsilon * self.turn.whole(inverse)
        K = np.tile(seen.K, (r, r))
        slope = K * (np.outer(x, x.conj()) - np.outer(a, a.conj()) + G * (1 - np.outer(w, w.conj())))
        first = 2 * self.first.T @ (self.turn.real(slope) @ C)
        rows, k = [], np.arange(m)
        for i, j in combinations(range(r), 2):
            d, one, two = seen.w[j] - seen.w[i], x[i * m : (i + 1) * m], x[j * m : (j + 1) * m]
            pulled = d * one * two - 2 * two + 2 * one + d * G[j * m + k, i * m + seen.mirror]
            rows.append(self.small.vector(pulled) * self.scale)
        gradient = np.concatenate([first.ravel(), *rows])
        return -value - epsilon * 2 * float(np.log(np.diag(root)).sum()), -gradient, value


def climb(seen: Values, progress: Callable[[str], None] = lambda text: None) -> Climbed:
    """The best certificate found at some points.

    Raises
    ------
    BadInput
        If there is none to start from.
    """
    r, m = seen.w.shape
    guide = pick.solve(seen, tolerance=_PATH)
    size = guide.value**2
    k = np.arange(m)
    turn = _Turn(np.concatenate([seen.mirror + i * m for i in range(r)]))
    Z, mu = _start(seen, guide)
    bare, alpha = turn.real(Z), 1e-8 * size
    added = np.eye(r * m)
    while np.linalg.eigvalsh(turn.real(form(seen, turn.whole(bare + alpha * added), mu)[2]))[0] <= 0:
        alpha *= 2
        if alpha > _MOST_ADDED * size:
            raise BadInput("no certificate of the value form to start from at these points")
    scale = float(np.abs(mu).max()) or size
    small = _Turn(seen.mirror[k])
    problem = _Point(seen, turn, small, cholesky(bare + alpha * added, lower=True), scale)
    u = np.concatenate([added.ravel(), *(small.vector(row) / scale for row in mu)])
    best: tuple[float, Array] = (-np.inf, u)
    for epsilon, gain, most in _STAGES:
        u, best = _ascend(problem, u, best, epsilon * size, gain * size, most, progress)
    C, mu = problem.parts(best[1])
    return Climbed(turn.whole(C @ C.T), mu, float(np.sqrt(max(best[0], 0.0))), guide.value)


def _start(seen: Values, guide: pick.PickSolution) -> tuple[Array, Array]:
    """Z and μ that make the Lagrangian stationary at the best device of the points."""
    (r, m), sigma = seen.w.shape, guide.y / 2
    E = np.vstack([np.diag((1 - w * sigma).conj() / (2 * r)) for w in seen.w])
    Z = E @ (4 * guide.inverse / guide.t) @ E.conj().T  # Φ(y) = 4 (K − D_σ K D_σ*)
    x = np.concatenate([2 * sigma / (1 - w * sigma) for w in seen.w])
    links = list(combinations(range(r), 2))
    mu = np.zeros((len(links), m), dtype=complex)
    _, b, M = form(seen, Z, mu)
    rest = (b + M @ x).reshape(r, m)
    for row, (i, j) in enumerate(links):
        if i == 0:
            mu[row] = rest[j] / (1 - np.conj((seen.w[j] - seen.w[0]) * x[:m]) / 2)
    return Z, mu


def _ascend(
    problem: _Point,
    u: Array,
    best: tuple[float, Array],
    epsilon: float,
    gain: float,
    most: int,
    progress: Callable[[str], None],
) -> tuple[Array, tuple[float, Array]]:
    """Steps of limited-memory BFGS with backtracking, M ≻ 0 kept, until a round of them gains too little."""
    found = problem.evaluate(u, epsilon)
    assert found is not None
    now, gradient, value = found
    pairs: list[tuple[Array, Array]] = []
    mark = now
    for step in range(most):
        direction = -_two_loops(gradient, pairs)
        slope, length = float(direction @ gradient), 1.0
        while length > 1e-12:
            tried = problem.evaluate(u + length * direction, epsilon)
            if tried is not None and tried[0] <= now + 1e-4 * length * slope:
                break
            length /= 2.5
        else:
            break
        assert tried is not None
        moved, bent = length * direction, tried[1] - gradient
        if moved @ bent > 1e-12 * np.linalg.norm(moved) * np.linalg.norm(bent):
            pairs = [*pairs[-_MEMORY + 1 :], (moved, bent)]
        u, (now, gradient, value) = u + moved, tried
        if value > best[0]:
            best = (value, u)
        if (step + 1) % _ROUND == 0:
            progress(f"bound: {np.sqrt(max(best[0], 0.0)):.6g} after {step + 1} steps")
            if mark - now < gain:
                break
            mark = now
    return u, best


def _two_loops(gradient: Array, pairs: list[tuple[Array, Array]]) -> Array:
    """H g of the limited-memory BFGS recursion [Nocedal1980]."""
    if not pairs:
        return gradient * (1e-3 / max(float(np.linalg.norm(gradient)), 1e-300))
    found, shares = gradient.copy(), []
    for moved, bent in reversed(pairs):
        shares.append((moved @ found) / (moved @ bent))
        found -= shares[-1] * bent
    moved, bent = pairs[-1]
    found *= (moved @ bent) / (bent @ bent)
    for (moved, bent), share in zip(pairs, reversed(shares), strict=True):
        found += moved * (share - (bent @ found) / (moved @ bent))
    return found
