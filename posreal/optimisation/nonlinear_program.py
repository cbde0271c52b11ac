"""What every candidate of a search is measured by: the objective, what must be kept, and the local optimum near it.

One object that can be sent to another process, so that many local searches run side by side.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from posreal.admittance import PortHamiltonian, state_space
from posreal.optimisation.bfgs import finish
from posreal.optimisation.coordinates import Chart
from posreal.optimisation.criterion import Candidate, Criterion
from posreal.optimisation.damping import ALL_SPEEDS, SEARCH_SPEEDS, Damping
from posreal.optimisation.figure import Figure
from posreal.optimisation.local import AtMost, Damped, Requirement, finish_constrained
from posreal.optimisation.mean_square import SETTLED, Modes, modes
from posreal.optimisation.problem_figures import figure_of, objective_figures
from posreal.optimisation.scaling import Scale
from posreal.plant.plant import close
from posreal.specification.constraint import ROUNDING
from posreal.specification.problem import Problem
from posreal.vehicle import Vehicle

Real = np.ndarray
Complex = np.ndarray

ROUNDS = 4  # local searches in a row, each with the speeds added at which the one before lost its damping
ADDED = 3  # speeds a round
NEAR = 1e-3  # of damping ratio: a candidate that misses by more is not worth another round
SPARE = 1e-7  # relative, of damping asked for at the watched speeds: between them it dips
DIP = 1e-2  # relative: a minimum over the grid of speeds that is no higher above the floor is looked at between them


@dataclass(frozen=True)
class Judge:
    """The objective and the constraints of a problem for scaled devices.

    Attributes
    ----------
    problem : Problem
    scale : Scale
    shrunk : mapping of metric to float
        Factors on the limits, where a metric's own quadrature and the search's differ.
    light : Modes
        Of the closed loop, which grids have to see.
    """

    problem: Problem
    scale: Scale
    shrunk: Mapping[str, float] = field(default_factory=dict)
    light: Modes = ()

    @cached_property
    def mean_square(self) -> Criterion | None:
        """The objective where it is one mean square of one vehicle."""
        problem = self.problem
        made = (problem.goal is not None and problem.goal.kind != "norm") or problem.points
        metric = problem.vehicle.metrics.get(problem.objective)
        norm = None if metric is None else metric.norm()
        if made or (metric is not None and (norm is None or norm.kind != "H2")):
            return None
        return Criterion(problem, self.scale, light=self.light)

    @cached_property
    def objective(self) -> tuple[Figure, ...]:
        """The objective is the largest of all numbers of these."""
        return objective_figures(self.problem, self.scale, self.light)

    @cached_property
    def nominal(self) -> dict[str, float]:
        """The free vehicle parameters at the vehicle's own values."""
        return {name: float(getattr(self.problem.vehicle, name)) for name in self.problem.free}

    @property
    def default(self) -> PortHamiltonian:
        """The device that the vehicle comes with where that is a damper, otherwise the scale's."""
        own = self.problem.default_device
        return damper(float(own(1.0).real) / self.scale.damper if own is not None and own.degree == 0 else 1.0)

    @cached_property
    def limits(self) -> tuple[AtMost, ...]:
        """Figures with upper limits."""
        return tuple(
            AtMost(
                c.metric,
                figure_of(self._at(c.point), c.base, self.scale, self.light),
                c.value * self.shrunk.get(c.metric, 1.0),
            )
            for c in self.problem.constraints
            if c.sense == "<="
        )

    def _at(self, point: str) -> Problem:
        return self.problem.at_points[point] if point else self.problem

    @cached_property
    def floors(self) -> tuple[Floor, ...]:
        """Damping ratios to be kept, the nominal vehicle's first."""
        found = []
        for c in self.problem.constraints:
            vehicle = self._at(c.point).vehicle
            if c.sense == ">=":
                found.append(Floor(vehicle, c.value / 100, self.scale, tuple(self.problem.free)))
        return tuple(found)

    @property
    def constrained(self) -> bool:
        """Whether local searches need more than an unconstrained quasi-Newton method."""
        return bool(self.problem.constraints or self.problem.free) or self.mean_square is None

    # --- measuring -----------------------------------------------------------------------------------------------

    def value(self, candidate: Candidate) -> float:
        """The objective, whatever the constraints."""
        return self.value_of(candidate.device, candidate.parameters)

    def value_of(self, H: Callable[[Complex], Any], parameters: Mapping[str, float]) -> float:
        """The objective of any scaled device."""
        if self.mean_square is not None:
            return self.mean_square.value_and_slope(np.asarray(H(self.mean_square.s)), parameters)[0]
        return max(float(figure.values(H, parameters).max()) for figure in self.objective)

    def feasible(self, candidate: Candidate) -> bool:
        """Whether everything is kept: limits, damping at every speed, the ranges of free parameters, stability."""
        for name, allowed in self.problem.free.items():
            if not allowed.lower * (1 - ROUNDING) <= candidate.parameters[name] <= allowed.upper * (1 + ROUNDING):
                return False
        for limit in self.limits:
            if not limit.figure.values(candidate.device, candidate.parameters).max() <= limit.limit * (1 + ROUNDING):
                return False
        if self.floors:
            return all(floor.spare(candidate) >= -ROUNDING * floor.ratio for floor in self.floors) and not any(
                floor.missed(candidate)[0] for floor in self.floors
            )
        return self._stable(candidate)

    def spare(self, candidate: Candidate) -> float:
        """By how much the least damping ratio at the watched speeds is above its limit."""
        return min(floor.spare(candidate) for floor in self.floors)

    def settled(self, candidate: Candidate) -> Judge:
        """One that sees a candidate as it is: this one, if it does to :data:`.mean_square.SETTLED`."""
        port = self.problem.mounting.port(self.scale.admittance(candidate.device.rational()))
        closer = replace(self, light=modes(self.problem.with_vehicle(candidate.parameters), port))
        seen, there = self._numbers(candidate), closer._numbers(candidate)
        return self if np.all(np.abs(seen - there) <= SETTLED * np.abs(there)) else closer

    def _numbers(self, candidate: Candidate) -> Real:
        """The objective and what is limited."""
        limited = [limit.figure.values(candidate.device, candidate.parameters).max() for limit in self.limits]
        return np.array([self.value(candidate), *limited])

    def measure(self, candidate: Candidate) -> float:
        """The objective; inf where something is not kept."""
        try:
            value = self.value(candidate)
            return value if math.isfinite(value) and self.feasible(candidate) else math.inf
        except np.linalg.LinAlgError:
            return math.inf

    def _stable(self, candidate: Candidate) -> bool:
        """Passive vehicles are stable with passive devices; a plant of the user's own may be anything."""
        if self.problem.vehicle.passive:
            return True
        port = self.problem.mounting.port(self.scale.admittance(candidate.device.rational()))
        poles = close(self.problem.plant, {"secondary": state_space(port)}).poles()
        return bool(poles.real.max() < 0)

    # --- improving -----------------------------------------------------------------------------------------------

    def improved(self, chart: Chart, start: Candidate, iterations: int, tolerance: float) -> tuple[float, Candidate]:
        """The local optimum near a start, and its measure."""
        # What a wild iterate does to floats is no news: whatever comes out is measured before it is taken.
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if self.mean_square is not None and not self.constrained:
                candidate = finish(self.mean_square, chart, start, iterations=iterations, tolerance=tolerance)
                return self.measure(candidate), candidate
            return self._improved_inside(chart, start, iterations, tolerance)

    def _improved_inside(
        self, chart: Chart, start: Candidate, iterations: int, tolerance: float
    ) -> tuple[float, Candidate]:
        speeds = [list(SEARCH_SPEEDS) for _ in self.floors]
        best = (self.measure(start), start)
        for _ in range(ROUNDS):
            requirements: list[Requirement] = [*self.limits]
            requirements += [Damped(f.damping(at), f.ratio, SPARE) for f, at in zip(self.floors, speeds, strict=True)]
            ends = finish_constrained(
                self.objective,
                requirements,
                self.problem.free,
                chart,
                chart.vector(start.device),
                start.parameters,
                iterations=iterations,
                tolerance=tolerance / 10,
            )
            found = [Candidate(chart.device(theta), parameters) for theta, parameters in ends]
            measured = [(self.measure(candidate), candidate) for candidate in found]
            best = min([best, *measured], key=lambda entry: entry[0])
            if not found or not self.floors or math.isfinite(measured[0][0]):
                break
            fresh = False
            for floor, at in zip(self.floors, speeds, strict=True):
                missed, short = floor.missed(found[0])
                if short > NEAR:
                    return best
                missed = [speed for speed in missed if speed not in at]
                at += missed[:ADDED]
                fresh = fresh or bool(missed)
            if not fresh:
                break
            start = found[0]
        return best


@dataclass(frozen=True)
class Floor:
    """A damping ratio that the vehicle of one operating point keeps at every speed."""

    vehicle: Vehicle
    ratio: float
    scale: Scale
    free: tuple[str, ...]

    def damping(self, speeds: Sequence[float]) -> Damping:
        """Damping at some speeds."""
        return Damping(self.vehicle, self.scale, self.free, tuple(speeds))

    @cached_property
    def _everywhere(self) -> Damping:
        return self.damping(ALL_SPEEDS)

    @cached_property
    def _watched(self) -> Damping:
        return self.damping(SEARCH_SPEEDS)

    def spare(self, candidate: Candidate) -> float:
        """By how much the least damping ratio at the watched speeds is above the floor."""
        return float(self._watched.least(candidate.device, candidate.parameters).min()) - self.ratio

    def missed(self, candidate: Candidate) -> tuple[list[float], float]:
        """Speeds with too little damping, the worst first, and by how much of damping ratio it misses there.

        Between the speeds of the grid as well: where the damping has a minimum near the floor, that is looked for.
        """

        def least_at(speed: float) -> float:
            return float(self.damping((speed,)).least(candidate.device, candidate.parameters)[0])

        least = self._everywhere.least(candidate.device, candidate.parameters)
        found = list(zip(least.tolist(), ALL_SPEEDS, strict=True))
        inner = least[1:-1]
        dips = (inner <= least[:-2]) & (inner <= least[2:]) & (inner < self.ratio * (1 + DIP))
        for i in np.flatnonzero(dips) + 1:
            bounds = (ALL_SPEEDS[i - 1], ALL_SPEEDS[i + 1])
            lowest = minimize_scalar(least_at, bounds=bounds, method="bounded", options={"xatol": 1e-4})
            found.append((float(lowest.fun), float(lowest.x)))
        missed = [speed for ratio, speed in sorted(found) if ratio < self.ratio * (1 - ROUNDING)]
        return missed, self.ratio - min(found)[0]


def damper(value: float) -> PortHamiltonian:
    """H = value."""
    return PortHamiltonian(np.zeros((0, 0)), np.zeros((0, 1)), np.array([[math.sqrt(value)]]))
