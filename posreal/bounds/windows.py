"""Where points lie: a time window for every frequency.

The Blaschke product of the points has the group delay T(ω) = Σ 2 Re sₖ/|jω − sₖ|², whose integral over all frequencies
is 2πm: the space K sees the response at ω for about T(ω) seconds, and m says how much of that there is to share out. A
shape of T, log-linear between a few frequencies and falling by ω⁻² above them, becomes points at the quantiles of T,
one for every 2π of phase, with real part α·2π/T there. The shape is what is searched: coordinate by coordinate for the
largest J at the points (:mod:`pick`, hundredths of a second a trial), with few points first. Nothing is proven here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from flint import fmpq

from posreal.admittance.exact import to_fmpq
from posreal.bounds import pick
from posreal.bounds.figure import BoundedFigure
from posreal.bounds.interpolation_space import Point
from posreal.bounds.values import sampled_values
from posreal.errors import BadInput, PosrealError

Array = np.ndarray

_KNOTS = 8
_ROOM = (1.0, 3.0)  # how far below and above the band the outermost knots lie
_DENSE = 4000  # frequencies of the quantiles' table
_ALPHA = (0.15, 1.6)  # beyond it points crowd, and K is ill conditioned
_CONDITION = 1e-7  # least eigenvalue of K that floats can work with
_STEP, _GROWTH = 1.0, 1.3  # first step of a coordinate's logarithm, and its factor after a success
_WORTHWHILE = 2e-5  # relative gain
_STAGES = ((51, 3), (101, 2), (141, 1))  # most points, sweeps
_QUICK = ((41, 2),)


@dataclass(frozen=True)
class Windows:
    """A shape of T.

    Attributes
    ----------
    knots : (k,)
        Frequencies, rad/s.
    log_T : (k,)
        Logarithms of T there; only their differences count.
    log_alpha : float
    """

    knots: Array
    log_T: Array
    log_alpha: float

    def points(self, size: int) -> tuple[Point, ...]:
        """Points for a space of dimension `size`: pairs, and a real one if that is odd."""
        omega = np.geomspace(self.knots[0] * 1e-3, self.knots[-1] * 1e3, _DENSE)
        log_T = np.interp(np.log(omega), np.log(self.knots), self.log_T)
        log_T -= 2 * np.log(np.maximum(omega / self.knots[-1], 1.0))
        T = np.exp(log_T - log_T.max())
        mass = np.concatenate([[omega[0] * T[0]], (T[1:] + T[:-1]) / 2 * np.diff(omega)]).cumsum()
        shares = (np.arange(size // 2 + size % 2) * 2 + (1 - size % 2)) / size  # of the upper half, symmetric about 0
        at = np.interp(shares * mass[-1], mass, omega)
        real = np.exp(self.log_alpha) * 2 * mass[-1] / (size * np.exp(np.interp(np.log(at), np.log(omega), np.log(T))))
        if size % 2:
            at[0] = 0.0
            real[0] = np.exp(self.log_alpha) * 2 * mass[-1] / (size * T[0])
        sizes = np.hypot(at, real)
        return tuple(
            (_short(w), _short(part / w)) if f else _short(w) for f, w, part in zip(at, sizes, real, strict=True)
        )


def best_windows(
    figure: BoundedFigure,
    size: int,
    band: tuple[float, float],
    c0: fmpq,
    progress: Callable[[str], None] = lambda text: None,
    *,
    quick: bool = False,
) -> Windows:
    """The shape at which `size` points show most.

    Raises
    ------
    BadInput
        If nothing is shown by any.
    """
    knots = np.geomspace(band[0] * _ROOM[0], band[1] * _ROOM[1], _KNOTS)
    best = Windows(knots, -np.log(knots / knots[0]), 0.0)
    steps = np.full(_KNOTS + 1, _STEP)
    value, shapes = 0.0, [best]
    for most, sweeps in _QUICK if quick else _STAGES:
        count = min(size, most)
        value = _worth(figure, best, count, c0)
        for _ in range(sweeps):
            progress(f"bound: windows for {count} points show {value:.6g} {figure.unit}")
            for k in range(_KNOTS + 1):
                for step in (steps[k], -steps[k]):
                    other = _moved(best, k, step)
                    there = _worth(figure, other, count, c0)
                    if there > value * (1 + _WORTHWHILE):
                        best, value, steps[k] = other, there, step * _GROWTH
                        break
                else:
                    steps[k] /= 2
        shapes.append(best)
        if count == size:
            return _known(best, value)
    values = [_worth(figure, shape, size, c0) for shape in shapes]
    return _known(shapes[int(np.argmax(values))], max(values))


def _known(shape: Windows, value: float) -> Windows:
    if value == 0:
        raise BadInput("nothing is proven at any points, so no bound is known for this figure")
    return shape


def _moved(shape: Windows, k: int, step: float) -> Windows:
    if k == len(shape.log_T):
        return replace(shape, log_alpha=shape.log_alpha + step)
    log_T = shape.log_T.copy()
    log_T[k] += step
    return replace(shape, log_T=log_T)


def _worth(figure: BoundedFigure, shape: Windows, size: int, c0: fmpq) -> float:
    """J at the points, nearly; 0 where floats fail."""
    if not _ALPHA[0] <= np.exp(shape.log_alpha) <= _ALPHA[1]:
        return 0.0
    points = shape.points(size)
    if len(set(points)) < len(points):
        return 0.0
    try:
        seen = sampled_values(figure, points, c0)
        if not np.linalg.eigvalsh(seen.K)[0] > _CONDITION:
            return 0.0
        found = pick.solve(seen, tolerance=1e-2, growth=30.0)
        return found.value if found.centred else 0.0
    except (PosrealError, np.linalg.LinAlgError, ValueError):
        return 0.0


def _short(value: float) -> fmpq:
    return to_fmpq(f"{value:.6g}")
