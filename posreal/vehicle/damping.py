"""Least damping ratio: the smallest −Re p/|p| over the poles of the closed vehicle, over a range of speeds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from posreal.plant.plant import Complex, Real


@dataclass(frozen=True)
class LeastDamping:
    """The least damped mode: its damping `ratio`, `speed` (m/s) and natural `frequency` (Hz)."""

    ratio: float
    speed: float
    frequency: float


def ratios(poles: Complex) -> Real:
    """−Re p/|p| of every pole, shape kept; a pole at 0 counts as undamped."""
    size = np.abs(poles)
    safe = np.where(size > 0, size, 1.0)
    return np.asarray(np.where(size > 0, -poles.real / safe, 0.0))


def least(poles: Complex, speeds: Real) -> LeastDamping:
    """The least damped of `poles` (speeds × modes)."""
    zeta = ratios(poles)
    row, column = np.unravel_index(int(np.argmin(zeta)), zeta.shape)
    return LeastDamping(float(zeta[row, column]), float(speeds[row]), float(np.abs(poles[row, column]) / (2 * np.pi)))
