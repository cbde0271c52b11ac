"""Largest gain of a closed vehicle over all frequencies: the H∞ norm from its inputs to an output.

Of several independent inputs it is the largest singular value, for one output the root of the sum of squares; densities
do not enter.

The response is sampled on a logarithmic grid with the frequencies of all poles in it, and refined around every local
maximum that comes near the largest; delays are exact, which a Hamiltonian test could not take.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import minimize_scalar

from posreal.plant.plant import ClosedLoop, Plant, channels

POINTS = 2000  # on the logarithmic grid
DECADES = (1e-2, 1e2)  # of the middle frequency of the poles
_SLOW = np.array([1e-2, 1e-4, 1e-6])  # of the lowest frequency otherwise looked at: the gain's limit at 0
_NEAR = 0.9  # of the largest sample: a local maximum that may be the largest


def grid(plant: Plant, points: int = POINTS) -> np.ndarray:
    """Frequencies, rad/s, on which a gain of the open plant's size and speed is seen."""
    return middle(plant) * np.geomspace(*DECADES, points)


def middle(plant: Plant) -> float:
    """The frequency, rad/s, in the middle of the open plant's poles (those at 0 left out)."""
    size = np.abs(np.linalg.eigvals(plant.A))
    size = size[size > 1e-6 * max(float(size.max()), 1e-300)]
    return float(np.exp(np.log(size).mean())) if len(size) else 1.0


def least_damping(plant: Plant) -> float:
    """The least damping ratio of the open plant's poles (those at 0 left out), no less than 1e-6."""
    poles = np.linalg.eigvals(plant.A)
    poles = poles[np.abs(poles) > 1e-6 * max(float(np.abs(poles).max(initial=0.0)), 1e-300)]
    return max(1e-6, float((-poles.real / np.abs(poles)).min(initial=1.0)))


def largest(loop: ClosedLoop, output: str, omega: np.ndarray) -> tuple[float, float]:
    """The largest gain and the frequency (rad/s) of it."""

    def size(at: np.ndarray) -> np.ndarray:
        each = [loop.response(at, output, process) for process in range(len(loop.shares))]
        return np.asarray(np.linalg.norm(each, axis=0))

    poles = loop.poles()
    own = np.abs(poles[np.abs(poles) > 0])
    slowest = _SLOW * min(float(omega.min()), float(own.min(initial=np.inf)))
    omega = np.unique(np.concatenate([omega, own, own * 0.999, own * 1.001, slowest]))
    gain = size(omega)
    best = (float(gain.max()), float(omega[int(np.argmax(gain))]))
    inner = np.concatenate([[-np.inf], gain, [-np.inf]])
    for i in map(int, np.flatnonzero((gain >= inner[:-2]) & (gain >= inner[2:]) & (gain >= _NEAR * best[0]))):
        low, high = np.log(omega[max(i - 1, 0)]), np.log(omega[min(i + 1, len(omega) - 1)])
        found = minimize_scalar(
            lambda x: -float(size(np.exp([x]))[0]),
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-10},
        )
        best = max(best, (-float(found.fun), float(np.exp(found.x))))
    return max(best, (_at_infinity(loop, output), math.inf))


def _at_infinity(loop: ClosedLoop, output: str) -> float:
    """The least upper bound of the gain as ω → ∞; 0 where more than one delay against another makes it."""
    row, squares, free = loop.D[loop.output(output)], [], 0
    for driven in channels(loop):
        late: dict[float, float] = {}
        for i in driven:
            late[float(loop.delays[i])] = late.get(float(loop.delays[i]), 0.0) + float(row[i])
        free += len(late) - 1 if len(late) > 1 else 0
        squares.append(sum(abs(part) for part in late.values()) ** 2)
    return math.sqrt(sum(squares)) if free <= 1 else 0.0
