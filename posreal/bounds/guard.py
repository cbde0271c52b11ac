"""No design leaves the program below a proven bound: that would be a bug, and it stops the run.

For each vehicle or plant and each mean-square figure, sum or gain a small certificate (a second at most) is made once
and kept. It holds for any number of points, so a design below it cannot be right, whatever the optimiser said.

A bound is over all devices beside a given static spring, or behind a given bush. A strut that brings a softer one of
its own is no such device, and is held against the bound of a vehicle with the spring that it does have.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from functools import lru_cache

from posreal.admittance import Rational
from posreal.bounds.compute import bound
from posreal.bounds.figure import figure
from posreal.bounds.result import Bound
from posreal.errors import PosrealError, Unsettled
from posreal.plant import hinf_norm
from posreal.plant.mounting import Mounting
from posreal.specification.constraint import ROUNDING
from posreal.specification.design import Design
from posreal.specification.goal import Goal
from posreal.specification.problem import Problem, Vehicle
from posreal.vehicle import gain_output

_POINTS = {"quarter-car": (16, 20.0), "side-view": (8, 10.0), "plan-view": (10, 10.0)}
"""Order of the truncated series and its expansion point (rad/s) for a bound that is quick rather than tight."""
_ORDER, _LARGEST = 8, 16  # order of the series, and states, of another vehicle or plant, whose middle is its point


def guarded(design: Design) -> Design:
    """The design, unchanged.

    Raises
    ------
    BelowBound
        If its objective is below what is proven for its vehicle; of a figure that has no bound of its own, each part
        (Macc, where the objective is a peak in time).
    """
    problem = design.problem
    for metric, goal in _figures(problem):
        floor = _floor(problem.vehicle, metric, goal, held(design))
        if floor is not None:
            with suppress(Unsettled):  # a figure that the bound's own method cannot compute here
                floor.require_not_below(design)
    return design


def held(design: Design) -> Mounting:
    """What the port certainly holds besides a positive-real device: the vehicle's part, or the strut's own softer one.

    A strut Y beside no spring is K/s in parallel with a positive-real device for K up to lim s·Y at 0; in series with a
    spring K it is one for 1/K up to lim 1/(s·Y) at infinity.
    """
    own, brought = design.problem.mounting, design.problem.layout_mounting
    if not design.whole or own == brought:
        return own
    strut = brought.device(design.port)
    if strut.is_zero():
        return brought
    if own.behind is not None:
        softness = strut.inverse().inertance
        softer = softness * own.behind.static_stiffness < 1 - ROUNDING
        return own if not softer else Mounting(own.beside, Rational.spring(1 / softness) if softness > 0 else None)
    assert own.beside is not None
    stiffness = strut.static_stiffness
    if stiffness >= own.beside.static_stiffness * (1 - ROUNDING):
        return own
    return Mounting(Rational.spring(stiffness) if stiffness > 0 else None, None)


def _figures(problem: Problem) -> list[tuple[str, Goal | None]]:
    """What has a bound: the objective, or its parts one by one."""
    goal, objective = problem.goal, problem.base_objective
    if goal is not None and (goal.kind == "worst" or any(problem.gain_output(name) for name, _ in goal.parts)):
        return [(name, None) for name, _ in goal.parts]
    metric = problem.vehicle.metrics.get(objective)
    is_peak = goal is None and metric is not None and metric.norm() is None
    return [(problem.vehicle.ride if is_peak else objective, goal)]


@lru_cache(maxsize=64)
def _floor(vehicle: Vehicle, metric: str, goal: Goal | None, mounting: Mounting) -> Bound | None:
    """A quick bound on a metric over all devices in this vehicle; None where none is known, or none is quick."""
    if vehicle.name in _POINTS:
        order, place = _POINTS[vehicle.name]
    else:
        plant = vehicle.plant(vehicle.random)
        if len(plant.A) > _LARGEST or len(plant.groups) > 1 or gain_output(vehicle, metric):
            return None
        order, place = _ORDER, hinf_norm.middle(plant)
    try:
        about = figure(Problem("guard", "", vehicle, metric, goal=goal))
        return bound(replace(about, mounting=mounting), L=order, omega0=place)
    except (PosrealError, ArithmeticError, ValueError):  # ValueError: of arrays that have overflowed
        return None


__all__ = ["guarded", "held"]
