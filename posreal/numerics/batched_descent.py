"""Minimise one function from many starts at once, in a box.

    min f(θ),  lower ≤ θ ≤ upper:      (B_F + μ I) d_F = −∇_F f

B is the damped BFGS approximation of the Hessian, F the coordinates that are not held by a bound, and μ ≥ 0
grows when a step fails and shrinks when it succeeds, as in Levenberg and Marquardt's method. Each iteration
costs one evaluation of all starts that are still moving and a few calls of small dense algebra, whatever the
number of starts.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Function = Callable[[Array], tuple[Array, Array]]  # (B, n) ↦ (B,), (B, n)

_FIRST = 0.3  # curvature along each logarithm to begin with
_STIFFEST = 1e8  # an approximate Hessian beyond this has lost its digits and is begun anew
_LONGEST = 1.5  # a step's largest entry: θ are logarithms, and e^1.5 is far enough in one go


def descend(
    function: Function,
    starts: Array,
    lower: Array,
    upper: Array,
    *,
    iterations: int = 100,
    tolerance: float = 1e-6,
) -> tuple[Array, Array]:
    """Local minima from each start.

    Parameters
    ----------
    function : maps (B, n) to values (B,) and gradients (B, n), for any B
    starts : (B, n)
    lower, upper : (n,)
    iterations : int
    tolerance : float
        A start is done when no entry of its gradient (of bounds' free directions) exceeds this.

    Returns
    -------
    (B, n) points, (B,) values, in the order of `starts`
    """
    theta = np.clip(starts, lower, upper)
    f, g = _finite(*function(theta))
    found, least = theta.copy(), f.copy()
    n = theta.shape[1]
    which = np.arange(len(theta))
    B = np.tile(_FIRST * np.eye(n), (len(theta), 1, 1))
    mu = np.full(len(theta), 0.1)
    unit = np.eye(n)
    for _ in range(iterations):
        held = ((theta <= lower) & (g > 0)) | ((theta >= upper) & (g < 0))
        slope = np.where(held, 0.0, g)
        moving = (np.abs(slope).max(axis=1) > tolerance) & (mu < 1e8)
        if not moving.all():
            found[which], least[which] = theta, f
            if not moving.any():
                break
            theta, f, g, B, mu, which = (
                theta[moving],
                f[moving],
                g[moving],
                B[moving],
                mu[moving],
                which[moving],
            )
            held, slope = held[moving], slope[moving]
        free = ~held
        damped = np.maximum(mu, 1e-13 * np.abs(B).max(axis=(1, 2)))
        kept = np.where(free[:, :, None] & free[:, None, :], B, 0.0)
        matrix = kept + (damped[:, None, None] + held[:, :, None]) * unit
        d = -np.linalg.solve(matrix, slope[:, :, None])[:, :, 0]
        d *= np.minimum(1.0, _LONGEST / np.maximum(np.abs(d).max(axis=1), 1e-300))[:, None]
        trial = np.clip(theta + d, lower, upper)
        d = trial - theta
        f_new, g_new = _finite(*function(trial))
        Bd = np.einsum("bij,bj->bi", B, d)
        foreseen = -(np.einsum("bi,bi->b", g, d) + 0.5 * np.einsum("bi,bi->b", d, Bd))
        better = f - f_new
        good = better > 1e-4 * np.maximum(foreseen, 0.0)
        mu = np.where(good, mu * np.where(better > 0.5 * foreseen, 0.2, 1.0), np.maximum(mu, 1e-3) * 4.0)
        mu = np.maximum(mu, 1e-6)
        B = _updated(B, d, Bd, np.where(np.isfinite(f_new)[:, None], g_new - g, Bd))
        accept = good[:, None]
        theta, f, g = np.where(accept, trial, theta), np.where(good, f_new, f), np.where(accept, g_new, g)
    found[which], least[which] = theta, f
    return found, least


def _finite(f: Array, g: Array) -> tuple[Array, Array]:
    """Infinitely bad, and flat, where the function has no value."""
    good = np.isfinite(f) & np.isfinite(g).all(axis=1)
    return np.where(good, f, np.inf), np.where(good[:, None], g, 0.0)


def _updated(B: Array, d: Array, Bd: Array, y: Array) -> Array:
    """Powell's damped BFGS update, which keeps B positive definite whatever the curvature met."""
    dBd = np.einsum("bi,bi->b", d, Bd)
    dy = np.einsum("bi,bi->b", d, y)
    usable = dBd > 1e-300
    mix = np.where(dy >= 0.2 * dBd, 1.0, 0.8 * dBd / np.where(dBd == dy, 1.0, dBd - dy))
    r = mix[:, None] * y + (1 - mix)[:, None] * Bd
    dr = np.einsum("bi,bi->b", d, r)
    safe, safe_r = np.where(usable, dBd, 1.0), np.where(usable, dr, 1.0)
    change = r[:, :, None] * (r / safe_r[:, None])[:, None, :] - Bd[:, :, None] * (Bd / safe[:, None])[:, None, :]
    new = B + np.where(usable[:, None, None], change, 0.0)
    size = np.abs(new).max(axis=(1, 2))
    sound = (size < _STIFFEST)[:, None, None]  # False for nan too
    return np.where(sound, new, _FIRST * np.eye(B.shape[1]))
