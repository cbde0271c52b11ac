"""The least damping ratio: the smallest −Re p/|p| over the poles of the closed vehicle, over a range of speeds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import minimize_scalar

from posreal.errors import Infeasible
from posreal.metric.closed_vehicle import ClosedVehicle
from posreal.metric.measured import Measured, measured
from posreal.plant import exact_loop
from posreal.plant.figures import settled
from posreal.plant.plant import Complex, Real

BETWEEN = 1e-4  # of the least damping over the list of speeds: a lower one between them that is said


@dataclass(frozen=True)
class LeastDamping:
    """The least damped mode: its damping `ratio`, `speed` (m/s, 0 where there is none) and natural `frequency` (Hz)."""

    ratio: float
    speed: float
    frequency: float

    def require_positive(self) -> None:
        """Do nothing if the mode decays.

        Raises
        ------
        Infeasible
        """
        if self.ratio <= 0:
            raise Infeasible(
                f"the vehicle is not stable with this device: "
                f"{'' if self.speed == 0 else f'at {self.speed:g} m/s '}a mode of {self.frequency:.3g} Hz "
                f"has damping ratio {self.ratio:.3g}"
            )


def ratios(poles: Complex) -> Real:
    """−Re p/|p| of every pole, shape kept; a pole at 0 counts as undamped."""
    size = np.abs(poles)
    safe = np.where(size > 0, size, 1.0)
    return np.asarray(np.where(size > 0, -poles.real / safe, 0.0))


def poles(closed: ClosedVehicle, load: str, speeds: Sequence[float]) -> Complex:
    """Poles of the closed vehicle without the track's filter, speeds × modes, rad/s."""
    matrices = [closed.at(float(speed)).on(load).loop.A for speed in speeds]
    return np.linalg.eigvals(np.array(matrices)).astype(complex)


def least_damping(closed: ClosedVehicle, load: str, speeds: Sequence[float]) -> LeastDamping:
    """The least damped of all modes at all `speeds`, m/s."""
    found = poles(closed, load, speeds)
    zeta = ratios(found)
    row, column = np.unravel_index(int(np.argmin(zeta)), zeta.shape)
    frequency = float(np.abs(found[row, column]) / (2 * np.pi))
    return LeastDamping(float(zeta[row, column]), float(speeds[int(row)]), frequency)


@dataclass(frozen=True)
class DampingRatio:
    """The least damping ratio over `speeds`, in %; a lower one between two of them is said."""

    load: str
    speeds: tuple[float, ...]
    unit: str = "%"
    better: Literal["less", "more"] = "more"

    def least(self, closed: ClosedVehicle) -> LeastDamping:
        """The least damped mode over the speeds of the list."""
        return least_damping(closed, self.load, self.speeds)

    def measure(self, closed: ClosedVehicle) -> Measured:
        """The value and where it is."""
        mode = self.least(closed)
        mode.require_positive()
        if not closed.confirmed:
            return Measured(100 * mode.ratio, self.unit, f"at {mode.speed:g} m/s", math.inf)
        between = self._between(closed, mode)
        between.require_positive()
        plant = closed.at(mode.speed).on(self.load)
        ratio = settled(
            "the least damping ratio",
            (lambda: mode.ratio, lambda: exact_loop.least_damping(plant.plant, plant.devices)),
        )
        at = f"at {'' if mode.speed == 0 else f'{mode.speed:g} m/s, '}{mode.frequency:.3g} Hz"
        if between.ratio < mode.ratio * (1 - BETWEEN):
            at += f"; between the speeds it falls to {100 * between.ratio:.6g} at {between.speed:.6g} m/s"
        return measured(ratio, self.unit, at, factor=100)

    def norm(self) -> None:
        """None: it is no system norm."""

    def _between(self, closed: ClosedVehicle, mode: LeastDamping) -> LeastDamping:
        """The least damping between the neighbours of the speed of `mode`."""
        i = self.speeds.index(mode.speed)
        bounds = self.speeds[max(i - 1, 0)], self.speeds[min(i + 1, len(self.speeds) - 1)]
        if bounds[0] == bounds[1]:
            return mode
        found = minimize_scalar(
            lambda v: least_damping(closed, self.load, (v,)).ratio,
            bounds=bounds,
            method="bounded",
            options={"xatol": 1e-3},
        )
        return least_damping(closed, self.load, (float(found.x),))
