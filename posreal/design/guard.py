"""No design leaves the program below a proven bound: that would be a bug, and it stops the run.

For each vehicle and mean-square metric a small certificate (a tenth of a second) is made once and kept. It holds for
any number of points, so a design below it cannot be right, whatever the optimiser said.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

from posreal.design.problem import Problem
from posreal.design.result import Design
from posreal.errors import BadInput
from posreal.vehicle import PlanView, QuarterCar, SideView

if TYPE_CHECKING:
    from posreal.design.bound import Bound

_POINTS = {"quarter-car": (16, 20.0), "side-view": (8, 10.0), "plan-view": (10, 10.0)}
"""Order of the truncated series and its expansion point (rad/s) for a bound that is quick rather than tight."""


def guarded(design: Design) -> Design:
    """The design, unchanged.

    Raises
    ------
    BelowBound
        If its objective (Macc, where the objective is a peak in time) is below what is proven for its vehicle.
    """
    vehicle = design.problem.vehicle
    objective = design.problem.base_objective
    metric = "Macc" if objective == "max_yv" else objective
    if isinstance(vehicle, PlanView | SideView | QuarterCar) and metric in design.metrics:
        floor = _floor(vehicle, metric)
        if floor is not None:
            floor.require_not_below(design)
    return design


@lru_cache(maxsize=64)
def _floor(vehicle: PlanView | SideView | QuarterCar, metric: str) -> Bound | None:
    """A quick bound on a metric over all devices in this vehicle; None where none is known."""
    from posreal.design.bound import bound

    order, place = _POINTS[vehicle.name]
    try:
        return bound(Problem("guard", "", vehicle, metric), L=order, omega0=place)
    except BadInput:
        return None


__all__ = ["guarded"]
