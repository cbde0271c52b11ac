"""What a design must keep: limits on metrics, and ranges of the parameters left free."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from posreal.vehicle import Metric


@dataclass(frozen=True)
class Constraint:
    """`metric` at least (`sense` ">=") or at most ("<=") `value`, in the metric's own unit."""

    metric: str
    sense: str
    value: float
    reason: str = ""

    def margin(self, metrics: Mapping[str, Metric]) -> float:
        """How far inside the constraint, in the metric's unit; negative outside."""
        slack = metrics[self.metric].value - self.value
        return slack if self.sense == ">=" else -slack

    def __str__(self) -> str:
        return f"{self.metric} {self.sense} {self.value:.6g}" + (f" ({self.reason})" if self.reason else "")


@dataclass(frozen=True)
class Range:
    """Bounds of a vehicle parameter that the problem leaves free."""

    lower: float
    upper: float
