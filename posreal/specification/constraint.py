"""What a design must keep: limits on metrics, and ranges of the parameters left free."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from posreal.metric import Measured

ROUNDING = 1e-9  # of a constraint's value: a miss that is none
BINDING = 1e-4  # of a constraint's value: what is left where it decides the design
_OF_ITS_SLOPE = 1e-3  # the room that a mode is asked for, of what a design's logarithms move it by


@dataclass(frozen=True)
class Constraint:
    """`metric` at least (`sense` ">=") or at most ("<=") `value`, in the metric's own unit.

    A `nominal` one is of the design as it is drawn, and of no vehicle that is built within tolerances.
    At an operating point besides the nominal one `point` is its name, and `metric` ends with it: ``Macc at Crz=40000``.
    """

    metric: str
    sense: str
    value: float
    reason: str = ""
    point: str = ""
    nominal: bool = False

    @property
    def base(self) -> str:
        """The metric without the operating point."""
        return self.metric.removesuffix(f" at {self.point}")

    def margin(self, metrics: Mapping[str, Measured]) -> float:
        """How far inside the constraint, in the metric's unit; negative outside."""
        slack = metrics[self.metric].value - self.value
        return slack if self.sense == ">=" else -slack

    def verdict(self, metrics: Mapping[str, Measured]) -> str:
        """``holds``, ``binds`` (holds with no more than 0.01 % to spare) or ``VIOLATED`` (by more than rounding)."""
        margin, unit = self.margin(metrics), abs(self.value)
        if margin < -ROUNDING * unit:
            return "VIOLATED"
        return "binds" if margin <= BINDING * unit else "holds"

    def __str__(self) -> str:
        return f"{self.metric} {self.sense} {self.value:.6g}" + (f" ({self.reason})" if self.reason else "")


@dataclass(frozen=True)
class Range:
    """Bounds of a vehicle parameter that the problem leaves free."""

    lower: float
    upper: float


def damping_spare(ratio: np.ndarray, slopes: np.ndarray, floor: float, room: float) -> np.ndarray:
    """What modes have above a damping ratio, less the `room` that a search keeps so that rounding leaves it kept.

    A mode that the design hardly moves (a wheelset's, at walking pace) cannot be given any room. It may then stand on
    the floor itself, to half of :data:`ROUNDING`: asked for more, a search would look in vain for a slope.

    Parameters
    ----------
    ratio : (M,) damping ratios
    slopes : (n, M) in the logarithms of what is designed
    floor : float
    room : float
    """
    return (
        ratio - floor - np.minimum(room, _OF_ITS_SLOPE * np.abs(slopes).max(axis=0, initial=0.0) - ROUNDING / 2 * floor)
    )
