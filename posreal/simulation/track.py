"""What shakes the vehicle in time: seeded random track, and ramps, for each channel with its own delay."""

from __future__ import annotations

import math

import numpy as np

from posreal.plant.modes import Corners
from posreal.plant.plant import Plant
from posreal.plant.shaping_filter import ShapingFilter

Real = np.ndarray


def step_for(plant: Plant, longest: float) -> float:
    """A step at most `longest` (s) of which the delays are multiples, as nearly as can be had."""
    positive = plant.delays[plant.delays > 0]
    if len(positive) == 0:
        return longest
    least = float(positive.min())
    first = math.ceil(least / longest)
    steps = least / np.arange(first, 2 * first + 1)
    miss = [np.abs(positive / step - np.round(positive / step)).max() for step in steps]
    return float(steps[int(np.argmin(np.round(miss, 9)))])


def random_track(plant: Plant, step: float, count: int, records: int, seed: int) -> Real:
    """Velocity of the track under every channel, (count, records, channels), the mean over each step.

    The mean of white noise of single-sided density S per rad/s over a step h has the variance π S/h.
    """
    rng = np.random.default_rng(seed)
    late = [round(float(delay) / step) for delay in plant.delays]
    longest = max(late, default=0)
    white = rng.normal(size=(len(plant.shares), count + longest, records))
    white *= np.sqrt(math.pi * plant.density / step * np.array(plant.shares))[:, None, None]
    if plant.shaping is not None:
        white = _shaped(white, plant.shaping.rational, step)
    processes = plant.processes or (0,) * len(late)
    w = np.empty((count, records, len(late)))
    for i, (delay, process) in enumerate(zip(late, processes, strict=True)):
        w[:, :, i] = white[process, longest - delay : longest - delay + count]
    return w


def _shaped(white: Real, shaping: ShapingFilter, step: float) -> Real:
    """What a filter makes of it, by the same midpoint rule as the vehicle (bilinear)."""
    from scipy.signal import bilinear, lfilter, ss2tf  # slow to import, and only this needs them

    top, bottom = ss2tf(shaping.A, shaping.B, shaping.C, shaping.D)
    return np.asarray(lfilter(*bilinear(top[0], bottom, 1 / step), white, axis=1))


def ramps(plant: Plant, step: float, count: int, corners: Corners) -> Real:
    """w(t) = Σ change · max(0, t − instant) under every channel, (count, 1, channels), in the middle of each step."""
    t = (np.arange(count) + 0.5) * step
    w = np.zeros((count, 1, len(plant.delays)))
    for i, delay in enumerate(plant.delays):
        w[:, 0, i] = sum(change * np.maximum(0.0, t - instant - float(delay)) for instant, change in corners)
    return w
