"""Lower-triangular Toeplitz matrices and sums over their shifts, in floats.

T_x = Σⱼ xⱼ Sⱼ with Sⱼ the j-step shift: power series multiply as these matrices do. Everything a barrier method needs
of an inequality in T_x is a correlation over shifts, ⟨Z, Sⱼ R Sₖᵀ⟩, and costs m products of m × m matrices.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import toeplitz

Array = np.ndarray


def lower(x: Array) -> Array:
    """T_x, shape (m, m), from the coefficients x (m,)."""
    return np.asarray(toeplitz(x, np.zeros_like(x)))


def diagonal_sums(Y: Array) -> Array:
    """s[..., k] = Σ_b Y[..., b + k, b], k = 0 … m − 1: sums along the subdiagonals."""
    m = Y.shape[-1]
    wide = np.zeros((*Y.shape[:-1], 2 * m))
    wide[..., :m] = Y[..., ::-1]
    slanted = wide.reshape(*Y.shape[:-2], 2 * m * m)[..., : m * (2 * m - 1)].reshape(*Y.shape[:-2], m, 2 * m - 1)
    return np.asarray(slanted.sum(axis=-2)[..., m - 1 :])


def correlation(Z: Array, R: Array) -> Array:
    """H[j, k] = ⟨Z, Sⱼ R Sₖᵀ⟩ = Σ_ab Z[a + j, b + k] R[a, b]."""
    m = len(Z)
    H = np.empty((m, m))
    for j in range(m):
        H[j] = diagonal_sums(Z[j:].T @ R[: m - j])
    return H
