"""Exact variance of an output with delays, over the whole band.

For z = Σᵢ gᵢ(t − τᵢ), gᵢ = C e^{At} Bᵢ, driven by one white process, with the observability Gramian
AᵀQ + QA + CᵀC = 0 and Δ = τⱼ − τᵢ ≥ 0,

    ∫ gᵢ(t − τᵢ) gⱼ(t − τⱼ) dt = Bⱼᵀ Q e^{AΔ} Bᵢ

so no Padé approximation is needed. A white process of single-sided density S per rad/s gives
var z = π S ‖G‖₂², with ‖G‖₂² the sum of these terms over all i and j. Of several independent processes the variances
add.
"""

from __future__ import annotations

import itertools
import math
import warnings
from typing import Any

from scipy.linalg import expm, solve_continuous_lyapunov

from posreal.plant.plant import ClosedLoop, channels


def mean_square(loop: ClosedLoop, output: str) -> float:
    """Mean square of an output of a stable loop over all frequencies, in balanced coordinates.

    Where a mode has next to no damping the digits are few, and the result may even be negative; see
    :mod:`posreal.plant.figures` for the figure that is confirmed.

    Raises
    ------
    ArithmeticError
        If a mode has no damping that rounding leaves.
    """
    loop = loop.balanced()
    j = loop.output(output)
    C = loop.C[j : j + 1]
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        try:
            Q = solve_continuous_lyapunov(loop.A.T, -C.T @ C)
        except RuntimeWarning:
            raise ArithmeticError("the Lyapunov equation is singular to rounding") from None
    total, later = 0.0, dict[float, Any]()
    for share, driven in zip(loop.shares, channels(loop), strict=True):
        for i, k in itertools.product(driven, driven):
            early, late = loop.delays[i], loop.delays[k]
            if late < early or (late == early and k < i):
                continue
            lag = float(f"{late - early:.15g}")  # what two pairs share but for rounding
            if lag not in later:
                later[lag] = expm(loop.A * lag)
            term = float(loop.B[:, k] @ Q @ later[lag] @ loop.B[:, i])
            total += share * (term if i == k else 2 * term)
    return math.pi * loop.density * total
