"""Which figure a metric's name stands for, as the searches compute it: see :mod:`.figure` for the kinds.

Searches use smooth quadratures; a design is always measured again by the problem's own metrics.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from posreal.errors import BadInput
from posreal.metric import Inertance, Metric, PeakInTime, StaticStiffness, WeightedSum
from posreal.optimisation.coordinates import Coordinates
from posreal.optimisation.figure import (
    Figure,
    Inside,
    PeakGain,
    PortFigure,
    RootMeanSquareFunctional,
    Slopes,
    WeightedFigures,
    laplace_line,
)
from posreal.optimisation.mean_square import Modes, beside, mean_square, opened
from posreal.optimisation.scaling import Scale
from posreal.plant import hinf_norm
from posreal.specification.problem import Problem

Real = np.ndarray

_LOWEST = np.geomspace(1e-6, 1e-2, 60)  # of a plant's middle frequency: where a gain may end in a slow or a fast pole
SECONDS = 8.0  # of a curve or slope in which a peak counts


@dataclass(frozen=True)
class AtTheEnds:
    """A limit of the port's admittance: s·Y at 0 (static stiffness) or Y/s at infinity (inertance).

    A device in a chart has such a pole only as the spring or the inerter that stands beside its states.
    """

    scale: Scale
    beside: float
    inertance: bool
    resolution: ClassVar[float] = 1e-11
    springs: Mapping[str, float] = field(default_factory=dict)  # the vehicle's own values of free ones beside it

    def _own(self, device: Any, parameters: Mapping[str, float]) -> float:
        if self.scale.impedance:
            return 0.0
        c0, omega = self.scale.damper, self.scale.omega
        if self.inertance:
            return c0 / omega * device.b
        return c0 * omega * device.k + sum(parameters[name] - own for name, own in self.springs.items())

    def values(self, device: Any, parameters: Mapping[str, float]) -> Real:
        """The number for a device."""
        return np.array([self.beside + self._own(device, parameters)])

    def slopes(self, chart: Any, theta: Real, parameters: Mapping[str, float]) -> Slopes:
        """The number and its slopes at a point of a chart."""
        by_theta = np.zeros((chart.size, 1))
        c0, omega = self.scale.damper, self.scale.omega
        if not self.scale.impedance:
            if self.inertance and chart.inerter:
                by_theta[-1] = 2 * theta[-1] * c0 / omega
            elif not self.inertance and chart.spring:
                by_theta[-1 - chart.inerter] = 2 * theta[-1 - chart.inerter] * c0 * omega
        by = {name: np.array([float(name in self.springs and not self.inertance)]) for name in parameters}
        return Slopes(self.values(chart.device(theta), parameters), by_theta, by)


@dataclass(frozen=True)
class AtTheEndsOfAStrut:
    """The same limits of a whole strut and what stands beside it, from Y at a point so near that no other term counts.

    On the positive real axis every term of a network's admittance is positive, so nothing cancels.
    """

    beside: float
    inertance: bool
    resolution: ClassVar[float] = 1e-11

    @property
    def _s(self) -> Real:
        return np.array([1e14 if self.inertance else 1e-14])

    def values(self, device: Any, parameters: Mapping[str, float]) -> Real:
        """The number for a strut."""
        return np.asarray(self.beside + (device(self._s) * self._s ** (-1 if self.inertance else 1)).real)

    def slopes(self, chart: Coordinates, theta: Real, parameters: Mapping[str, float]) -> Slopes:
        """The number and its slopes in the strut's coordinates."""
        _, dY = chart.values_and_slopes(theta, self._s)
        by_theta = (dY * self._s ** (-1 if self.inertance else 1)).real
        return Slopes(
            self.values(chart.device(theta), parameters), by_theta, {name: np.zeros(1) for name in parameters}
        )


def is_smooth_metric(metric: Metric) -> bool:
    """Whether searches have a smooth figure of a metric, to minimise or to limit: all but a least damping ratio."""
    return metric.norm() is not None or isinstance(metric, PeakInTime | StaticStiffness | Inertance | WeightedSum)


def figure_of(problem: Problem, name: str, scale: Scale, light: Modes = (), panels: int = 12) -> Figure:
    """The figure of a metric, in the metric's unit, on a grid of so many panels a decade that sees the modes `light`.

    Raises
    ------
    BadInput
        If the metric has no smooth figure.
    """
    metric = problem.vehicle.metrics.get(name)
    if isinstance(metric, StaticStiffness | Inertance):
        return _at_the_ends(problem, name, scale, inertance=isinstance(metric, Inertance))
    if isinstance(metric, WeightedSum):
        return WeightedFigures(
            tuple((weight, _figure_of(problem, part, scale, light, panels)) for weight, part in metric.parts)
        )
    return _figure(problem, name, scale, light, panels)


def objective_figures(problem: Problem, scale: Scale, light: Modes = (), panels: int = 12) -> tuple[Figure, ...]:
    """The figures of the objective: it is the largest of all their numbers."""
    found: list[Figure] = []
    for point in (problem, *problem.at_points.values()):
        if point.goal is None or point.goal.kind == "norm":
            found.append(figure_of(point, problem.base_objective, scale, light, panels))
        else:
            parts = [(weight, _figure(point, name, scale, light, panels)) for name, weight in point.goal.parts]
            found += (
                [WeightedFigures(tuple(parts))]
                if point.goal.kind == "sum"
                else [WeightedFigures((part,)) for part in parts]
            )
    return tuple(found)


def _figure(problem: Problem, name: str, scale: Scale, light: Modes, panels: int) -> PortFigure | PeakGain:
    metric = problem.vehicle.metrics.get(name)
    if metric is not None:
        return _figure_of(problem, metric, scale, light, panels)
    return _mean_square(problem, name, scale, light, panels)  # the norm of several


def _figure_of(problem: Problem, metric: Metric, scale: Scale, light: Modes, panels: int) -> PortFigure | PeakGain:
    vehicle = problem.vehicle
    if isinstance(metric, PeakInTime):
        line = laplace_line(SECONDS, metric.corners, metric.factor)
        plant = vehicle.plant(metric.load, opened=opened(problem))
        return PortFigure(Inside(problem, scale, line.s), plant.responses_at(line.s, metric.output), line)
    norm = metric.norm()
    if norm is not None and norm.kind == "H∞":
        plant = vehicle.plant(norm.load)
        ends = hinf_norm.middle(plant) * np.concatenate([_LOWEST, 1 / _LOWEST])
        omega = np.unique(np.concatenate([hinf_norm.grid(plant), ends, beside(light)]))
        return PeakGain(problem, scale, norm.output, omega, norm.load)
    name = next((name for name, one in vehicle.metrics.items() if one == metric), problem.base_objective)
    return _mean_square(problem, name, scale, light, panels)


def _mean_square(problem: Problem, name: str, scale: Scale, light: Modes, panels: int) -> PortFigure:
    goal = problem.goal if name == problem.base_objective else None
    posed = replace(problem, objective=name, goal=goal, points=())
    J = mean_square(posed, primary_open=opened(problem), panels=panels, light=light)
    return PortFigure(Inside(problem, scale, J.s), J.port, RootMeanSquareFunctional(J.scale * J.weight))


def _at_the_ends(problem: Problem, metric: str, scale: Scale, *, inertance: bool) -> AtTheEnds | AtTheEndsOfAStrut:
    beside = (problem.layout_mounting if scale.whole else problem.mounting).beside
    own = 0.0 if beside is None else float(beside.inertance if inertance else beside.static_stiffness)
    if scale.whole:
        return AtTheEndsOfAStrut(own, inertance)
    limit = problem.at_most.get(metric, math.inf)
    springs = {
        name: float(getattr(problem.vehicle, name))
        for name in problem.free
        if problem.vehicle.free[name] == ("secondary", -1)
    }
    if own > limit and not springs:
        raise BadInput(f"{metric} is {own:.6g} without any device, above its limit of {limit:g}")
    return AtTheEnds(scale, own, inertance, springs)
