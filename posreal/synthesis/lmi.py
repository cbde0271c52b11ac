"""The matrix inequalities of positive-real synthesis [PS2006], each written once, as a matrix that must be ⪰ 0.

    H2        −[[AᵀX + XA, Cᵀ], [C, −I]] ⪰ 0,   ‖·‖² ≤ trace BᵀXB           (A, B, C, D: closed loop)
    H∞        −[[AᵀX + XA, XB, Cᵀ], [BᵀX, −γI, Dᵀ], [C, D, −γI]] ⪰ 0,   ‖·‖ ≤ γ
    sector    −[[sin θ (AᵀX + XA), cos θ (AᵀX − XA)], [·, sin θ (AᵀX + XA)]] ⪰ 0,   damping ratio ≥ cos θ

X ≻ 0 enters only through the products XA and XB, so a block is affine in the unknowns once they are: see
:func:`linearised`. Leading axes broadcast.
"""

from __future__ import annotations

import math

import numpy as np

from posreal.admittance.positive_real_lemma import blocks, transposed

Real = np.ndarray


def h2(M: Real, C: Real) -> Real:
    """−[[M + Mᵀ, Cᵀ], [C, −I]] with M = XA: the observability Gramian inequality."""
    return -blocks([[M + transposed(M), transposed(C)], [C, -np.eye(C.shape[-2])]])


def bounded_real(M: Real, N: Real, C: Real, D: Real, gamma: Real) -> Real:
    """−[[M + Mᵀ, N, Cᵀ], [Nᵀ, −γI, Dᵀ], [C, D, −γI]] with M = XA, N = XB: the bounded-real lemma."""
    inputs, outputs = np.eye(N.shape[-1]), np.eye(C.shape[-2])
    return -blocks(
        [
            [M + transposed(M), N, transposed(C)],
            [transposed(N), -gamma * inputs, transposed(D)],
            [C, D, -gamma * outputs],
        ]
    )


def sector(M: Real, damping: float) -> Real:
    """Every eigenvalue λ of A has −Re λ/|λ| ≥ `damping`, with M = XA and X ≻ 0 [ChilaliGahinet1996]."""
    cos, sin = damping, math.sqrt(1 - damping**2)
    both, difference = sin * (M + transposed(M)), cos * (transposed(M) - M)
    return -blocks([[both, difference], [transposed(difference), both]])


def linearised(X: Real, A: Real, X0: Real, A0: Real) -> Real:
    """XA ≈ X0 A + X A0 − X0 A0: the product at (X0, A0) to first order, A any matrix."""
    return X0 @ A + (X - X0) @ A0
