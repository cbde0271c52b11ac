"""Figures of a run: root mean squares on a band, their ratio to another run on the same track, peaks."""

from __future__ import annotations

import math

import numpy as np

Real = np.ndarray


def mean_squares(z: Real, step: float, start: float, stop: float) -> Real:
    """Mean square of each record of `z` (N, R) from `start` to `stop` rad/s."""
    spectrum = np.abs(np.fft.rfft(z, axis=0) / len(z)) ** 2
    omega = 2 * math.pi * np.fft.rfftfreq(len(z), step)
    inside = (omega > start) & (omega <= stop)
    return np.asarray(2 * spectrum[inside].sum(axis=0))


def ratio(over: Real, under: Real) -> tuple[float, float]:
    """√(Σ over/Σ under) of paired mean squares, and its standard error (jackknife over the records)."""
    value = math.sqrt(float(over.sum() / under.sum()))
    if len(over) < 2:
        return value, math.nan
    left_out = np.sqrt((over.sum() - over) / (under.sum() - under))
    n = len(over)
    return value, float(math.sqrt((n - 1) / n * ((left_out - left_out.mean()) ** 2).sum()))
