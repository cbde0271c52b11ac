"""Local search over the element values of one network on one problem.

    min J(θ, φ)   over the logarithms θ of element values and φ of free vehicle parameters, subject to the constraints

by sequential quadratic programming (:mod:`.local`) over smooth figures (:mod:`.figure`): mean squares, weighted sums,
the worst of several, largest gains, peaks in time, damping ratios, each with its exact gradient. Every start first
descends as the figures see it. The best ends then go on until what is limited holds as the metrics measure it: speeds
at which the damping turns out to be too little are added, limits that a metric's own quadrature sees exceeded are
tightened, and grids are cut beside the modes of what has been found.

A layout and a topology are searched alike: both are a :class:`Layout`, the strut with the vehicle's own spring in it.
"""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from posreal.errors import BadInput, PosrealError
from posreal.metric import ClosedVehicle, DampingRatio, PeakInTime
from posreal.network import Network
from posreal.optimisation.coordinates import Coordinates
from posreal.optimisation.corners import Corners, Signs
from posreal.optimisation.damping import Damping
from posreal.optimisation.element_values import ElementValues
from posreal.optimisation.figure import Figure, Slopes
from posreal.optimisation.local import AtLeast, AtMost, Damped, Requirement, finish_constrained
from posreal.optimisation.mean_square import Modes, modes
from posreal.optimisation.problem_figures import figure_of, objective_figures
from posreal.optimisation.scaling import STRUT
from posreal.specification.as_made import layout_as_made
from posreal.specification.constraint import ROUNDING, Constraint
from posreal.specification.layout import Layout
from posreal.specification.problem import Problem

Array = np.ndarray
PANELS = 12  # a decade of the figures' grids
UNDAMPED = 1e-8  # damping ratio
SETTLED = 1e-7  # change of a figure from one grid to the next at which an optimum stays where it is
_SAFETY = 1e-7  # relative room that a constraint is given where the metric missed it
_GIVEN = 1e-6  # relative room beyond that which is given back
_NEAR = 0.1  # relative miss of a constraint that may be due to the search's own quadrature
_MISSED = 1e-2  # in a requirement's unit: more is missed by an end that led nowhere
_ROUNDS, _ROUNDS_AT_CORNERS = 6, 15
_LOOKS = 3  # at the corners, by a start that descends
_SEEN, _ALIKE = (0.1, 300.0), 0.05  # rad/s; relative difference of two admittances there that are taken for the same
_FULL = 10  # elements whose every limit is looked at

Point = tuple[Array, dict[str, float]]
"""Logarithms of element values, and free vehicle parameters."""


@dataclass
class Watch:
    """What a round is shown of each constraint: speeds of a damping ratio, a factor on a limit, and corners of the
    tolerances with the speeds there."""

    speeds: dict[str, tuple[float, ...]] = field(default_factory=dict)
    factors: dict[str, float] = field(default_factory=dict)
    corners: dict[tuple[Constraint, Signs], tuple[float, ...]] = field(default_factory=dict)


@dataclass(frozen=True)
class End:
    """Where a local search ended: the objective there, in the metric's unit."""

    value: float
    point: Point


@dataclass(frozen=True)
class _There:
    """A figure or a requirement of an operating point, where a layout's static spring or bush has the value there."""

    inner: Any
    elements: ElementValues

    @property
    def resolution(self) -> float:
        return float(self.inner.resolution)

    def values(self, device: Any, parameters: Mapping[str, float]) -> Array:
        return np.asarray(self.inner.values(self.elements.moved(device), parameters))

    def slopes(self, chart: Coordinates, theta: Array, parameters: Mapping[str, float]) -> Slopes:
        found: Slopes = self.inner.slopes(self.elements, theta, parameters)
        return found

    def margins(self, chart: Coordinates, theta: Array, parameters: Mapping[str, float]) -> Slopes:
        found: Slopes = self.inner.margins(self.elements, theta, parameters)
        return found


class ElementSearch:
    """One network on one problem: its unknowns, its objective, its constraints.

    Parameters
    ----------
    problem : Problem
    layout : Layout
        The strut, with what its elements stand for; of ideal elements, in place of which the problem's are taken.
    panels : int
        A decade of the figures' grids: few, to descend from many starts; the usual number for what is found.

    Raises
    ------
    BadInput
        If the layout does not fit the problem, or leaves nothing to choose.
    """

    def __init__(self, problem: Problem, layout: Layout, *, panels: int = PANELS) -> None:
        layout.require(problem)
        self.problem, self.ideal, self.panels = problem, layout, panels
        self.layout = layout = layout_as_made(layout, problem)
        self.elements = ElementValues(problem, layout)
        # the static spring is the layout's own element, so what is left free are the primary parameters
        self.free = {name: r for name, r in problem.free.items() if name not in problem.roles.values()}
        if not self.elements.names and not self.free:
            raise BadInput(f"layout {layout.name} leaves no value to choose on {problem.name}; evaluate it instead")
        for name in self.elements.names:
            role = layout.rules[name].role if name in layout.rules else None
            if role and any(problem.roles[role] in values for values in problem.points):
                raise BadInput(f"layout {layout.name} chooses its own {role}, so no operating point can set it")
        posed = replace(problem, free=self.free)
        self._nominal = replace(posed, objective=problem.base_objective, points=())
        self._points = posed.at_points
        self._elements_at = {name: self.elements.at(point, layout) for name, point in self._points.items()}
        self.corners: Corners | None = None
        if problem.tolerances is not None:
            everywhere = {"": self._nominal, **self._points}
            elements = {"": self.elements, **self._elements_at}
            self.corners = Corners(problem, everywhere, layout, elements, tuple(self.free))
        self._see(())

    def _see(self, light: Modes) -> None:
        """Put figures on grids that see some modes."""
        self.objective: tuple[Figure, ...] = objective_figures(self._nominal, STRUT, light, self.panels)
        for name, point in self._points.items():
            there = objective_figures(point, STRUT, light, self.panels)
            self.objective += tuple(_There(one, self._elements_at[name]) for one in there)
        self._limited: dict[str, Figure] = {}
        for c in self.problem.constraints:
            if not self._is_damping(c):
                self._limited[c.metric] = figure_of(self._at(c.point), c.base, STRUT, light, self.panels)

    def closer(self, point: Point) -> ElementSearch:
        """One whose grids see what is at `point` as it is: this one, if they do to :data:`SETTLED`, relative."""
        other = copy(self)
        other._see(self.modes(point))
        seen, there = self._numbers(point), other._numbers(point)
        return self if np.all(np.abs(seen - there) <= SETTLED * np.abs(there)) else other

    def modes(self, point: Point) -> Modes:
        """The light modes of the closed vehicle."""
        tuned = self.tuned(point)
        return modes(tuned, tuned.port(self.network(point).admittance(), whole=True))

    def is_undamped(self, point: Point) -> bool:
        """Whether a mode has no more damping than rounding gives it."""
        return any(sigma <= UNDAMPED * omega for omega, sigma in self.modes(point))

    def _numbers(self, point: Point) -> Array:
        """The objective and what is limited."""
        figures: list[Figure] = []
        for c in self.problem.constraints:
            if c.metric in self._limited:
                one = self._limited[c.metric]
                figures.append(_There(one, self._elements_at[c.point]) if c.point else one)
        return np.array([self.value(point), *(self._largest((one,), point) for one in figures)])

    def _at(self, point: str) -> Problem:
        return self._points[point] if point else self._nominal

    # --- constraints -----------------------------------------------------------------------------------------

    def _metric(self, constraint: Constraint) -> Any:
        return self.problem.vehicle.metrics[constraint.base]

    def _is_damping(self, constraint: Constraint) -> bool:
        return isinstance(self._metric(constraint), DampingRatio)

    def _speeds(self, constraint: Constraint, watch: Watch) -> tuple[float, ...]:
        """The first, the last, and every fifteenth between, until others turn out to matter."""
        every = self._metric(constraint).speeds
        return watch.speeds.get(constraint.metric, tuple(np.unique([every[0], *every[9::15], every[-1]]).tolist()))

    def damping(self, point: str, speeds: tuple[float, ...]) -> Damping:
        """Damping ratios at an operating point."""
        return Damping(self._at(point).vehicle, STRUT, tuple(self.free), speeds)

    def requirements(self, watch: Watch) -> list[Requirement]:
        """The constraints as the local search sees them."""
        made: list[Requirement] = []
        for c in self.problem.constraints:
            limit = c.value * watch.factors.get(c.metric, 1.0)
            one: Requirement
            if self._is_damping(c):
                one = Damped(self.damping(c.point, self._speeds(c, watch)), limit / 100)
            else:
                one = (AtMost if c.sense == "<=" else AtLeast)(c.metric, self._limited[c.metric], limit)
            made.append(_There(one, self._elements_at[c.point]) if c.point else one)
        if self.corners is not None:
            for (c, signs), speeds in watch.corners.items():
                made.append(self.corners.requirement(c, signs, speeds, watch.factors.get(c.metric, 1.0)))
        return made

    def least_damping(self, constraint: Constraint, speeds: tuple[float, ...], point: Point) -> Array:
        """The least damping ratio at each of the speeds, at the operating point of a constraint on it."""
        elements = self._elements_at.get(constraint.point, self.elements)
        return self.damping(constraint.point, speeds).least(elements.device(point[0]), point[1])

    def limited(self, point: Point) -> dict[str, float]:
        """What is limited, as the metrics measure it.

        Raises
        ------
        Infeasible
            If a metric has no value there, or the vehicle is not stable.
        """
        tuned, found = self.tuned(point), dict[str, float]()
        port = tuned.port(self.network(point).admittance(), whole=True)
        there = {"": (tuned, port)}
        for (name, at), changed in zip(tuned.at_points.items(), tuned.points, strict=True):
            there[name] = at, tuned.port_at(at, port, changed)
        closed = {name: ClosedVehicle(at.vehicle, {"secondary": inside}) for name, (at, inside) in there.items()}
        damped = {c.point for c in self.problem.constraints if self._is_damping(c)}
        for name, one in closed.items():
            if name not in damped and not there[name][0].vehicle.passive:
                there[name][0].vehicle.require_stable(one)
        for c in self.problem.constraints:
            metric, one = self._metric(c), closed[c.point]
            if isinstance(metric, DampingRatio):
                mode = metric.least(one)
                mode.require_positive()
                found[c.metric] = 100 * mode.ratio
            else:
                found[c.metric] = one.value(metric).value
        return found

    def _broken(self, numbers: Mapping[str, float]) -> list[Constraint]:
        def missed(c: Constraint) -> float:
            return (c.value - numbers[c.metric]) * (1 if c.sense == ">=" else -1)

        return [c for c in self.problem.constraints if not missed(c) <= ROUNDING * abs(c.value)]

    def _look_closer(self, point: Point, numbers: Mapping[str, float], watch: Watch) -> bool:
        """Add speeds at which a damping is too little, tighten what is missed by a little; False if nothing helps."""
        changed = False
        for c in self._broken(numbers):
            if self._is_damping(c):
                every, seen = self._metric(c).speeds, self._speeds(c, watch)
                least = self.least_damping(c, every, point)
                speeds = tuple(np.union1d(seen, np.array(every)[least < c.value / 100]).tolist())
                if speeds != seen:
                    watch.speeds[c.metric] = speeds
                    changed = True
                    continue
            short = c.value / numbers[c.metric] if numbers[c.metric] else math.inf
            if math.isfinite(short) and abs(short - 1) < _NEAR:
                away = 1 + _SAFETY if c.sense == ">=" else 1 - _SAFETY
                watch.factors[c.metric] = watch.factors.get(c.metric, 1.0) * short * away
                changed = True
        return changed

    def _loosened(self, numbers: Mapping[str, float], watch: Watch) -> bool:
        """Give back what a limit was tightened too much by; False if that is nothing."""
        changed = False
        for c in self.problem.constraints:
            if c.metric in watch.factors:
                room = c.value / numbers[c.metric] * (1 - _SAFETY if c.sense == "<=" else 1 + _SAFETY)
                if abs(room - 1) > _GIVEN:
                    watch.factors[c.metric] *= room
                    changed = True
        return changed

    def holds_at_corners(self, point: Point) -> bool:
        """Whether the constraints hold at every corner of the problem's tolerances; so they do if it has none."""
        return self.corners is None or not self.corners.missed(*point)

    def _missed_at_corners(self, point: Point, watch: Watch) -> tuple[str, bool]:
        """Which constraint does not hold at a corner of the tolerances, and whether that is news to the search."""
        return ("", False) if self.corners is None else self.corners.look(*point, watch.corners)

    # --- points ----------------------------------------------------------------------------------------------

    def point(self, values: Mapping[str, float], vehicle: Mapping[str, float]) -> Point:
        """Where named values lie, the nearest within the bounds."""
        theta = np.log(np.array([values[name] for name in self.elements.names], dtype=float))
        return np.clip(theta, self.elements.lower, self.elements.upper), {name: vehicle[name] for name in self.free}

    def tuned(self, point: Point) -> Problem:
        """The problem with its vehicle parameters in place."""
        return self.problem.with_vehicle(point[1])

    def network(self, point: Point) -> Network:
        """The strut."""
        return self.layout.valued(self.tuned(point), self.elements.values(point[0]))

    def value(self, point: Point) -> float:
        """The objective as the figures see it, constraints and stability left out of account."""
        return self._largest(self.objective, point)

    def _largest(self, figures: Iterable[Figure], point: Point) -> float:
        strut = self.elements.device(point[0])
        with np.errstate(all="ignore"):
            return max(float(figure.values(strut, point[1]).max()) for figure in figures)

    def screened(
        self, count: int, rng: np.random.Generator, among: int = 128, within: tuple[Array, Array] | None = None
    ) -> list[Point]:
        """The most promising of points spread over the bounds (or `within` others) by a Latin hypercube."""
        elements, free = self.elements, self.free
        ranges = np.log(np.array([[r.lower, r.upper] for r in free.values()]).reshape(-1, 2))
        low, high = within or (elements.lower, elements.upper)
        lower, upper = np.append(low, ranges[:, 0]), np.append(high, ranges[:, 1])
        strata = np.array([rng.permutation(among) for _ in lower]).T + rng.uniform(size=(among, len(lower)))
        points: list[Point] = [
            (row[: elements.size], dict(zip(free, np.exp(row[elements.size :]).tolist(), strict=True)))
            for row in lower + strata / among * (upper - lower)
        ]
        # a curve's peak says little of a vehicle that sways without end, its ride more
        peak = isinstance(self.problem.vehicle.metrics.get(self.problem.base_objective), PeakInTime)
        ride = self._ride if peak and not self.problem.vehicle.passive else self.objective
        scores = np.array([self._largest(ride, point) for point in points])
        scores = np.where(np.isfinite(scores), scores, np.inf)
        order = np.argsort(scores, kind="stable")
        floors = [c for c in self.problem.constraints if self._is_damping(c)]
        if floors:
            # an undamped vehicle is no start: rank by ride only among points near enough to the damping floor
            order = order[: among // 2]
            short = [max(0.0, *(c.value / 100 - self._few(c, points[i]) for c in floors)) for i in order]
            order = order[np.argsort(np.array(short) + 1e-3 * scores[order] / scores[order[0]], kind="stable")]
        return [points[i] for i in order[:count]]

    @property
    def _ride(self) -> tuple[Figure, ...]:
        """The first mean square that is always shown: the ride on the random load."""
        metrics = self.problem.vehicle.metrics
        norms = ((name, metrics[name].norm()) for name in self.problem.vehicle.headline)
        ride = next(name for name, norm in norms if norm is not None and norm.kind == "H2")
        return (figure_of(self._nominal, ride, STRUT, (), self.panels),)

    def _few(self, constraint: Constraint, point: Point) -> float:
        return float(self.least_damping(constraint, self._three_speeds(constraint), point).min())

    def _three_speeds(self, constraint: Constraint) -> tuple[float, ...]:
        every = self._metric(constraint).speeds
        return every[0], every[len(every) // 2], every[-1]

    def default(self) -> list[Point]:
        """The default suspension as values of the layout, elements that it lacks at whichever bound is no element."""
        problem, elements = self.problem.original, self.elements
        if problem.default_port is None or elements.size > _FULL:
            return []
        s = 1j * np.geomspace(*_SEEN, 13)
        beside = problem.layout_mounting.beside
        around, target = (0.0 if beside is None else np.asarray(beside(s))), np.asarray(problem.default_port(s))
        ends = np.array(list(itertools.product(*elements.bounds))).reshape(-1, elements.size)
        trials = [ends]
        if (device := problem.default_device) is not None and device.degree == 0:
            c = math.log(float(device(1.0).real))
            dampers = [name[0] == "c" for name in elements.names]
            trials += [np.where(np.arange(elements.size) == i, c, ends) for i in np.flatnonzero(dampers)]
        points = np.clip(np.vstack(trials), elements.lower, elements.upper)
        off = [float(np.abs((elements.device(theta)(s) + around) / target - 1).max()) for theta in points]
        best = int(np.argmin(off))
        own = {name: float(getattr(problem.vehicle, name)) for name in self.free}
        return [(points[best], own)] if off[best] < _ALIKE else []

    # --- searches --------------------------------------------------------------------------------------------

    def polished(self, start: Point, watch: Watch, *, iterations: int = 200, tolerance: float = 1e-11) -> list[Point]:
        """Where a local search ends, and the best point on its way that seemed to keep everything."""
        with warnings.catch_warnings():
            # SLSQP says so when a line search leaves the bounds by rounding and is clipped
            warnings.filterwarnings("ignore", message="Values in x were outside bounds", category=RuntimeWarning)
            ends = finish_constrained(
                self.objective,
                self.requirements(watch),
                self.free,
                self.elements,
                *start,
                iterations=iterations,
                tolerance=max(tolerance, *(figure.resolution for figure in self.objective)),
            )
        return [(np.clip(theta, self.elements.lower, self.elements.upper), values) for theta, values in ends]

    def descended(self, start: Point, *, iterations: int = 100, tolerance: float = 1e-8) -> End | None:
        """Where a start leads as the figures see it; None if it breaks a constraint there, or runs off."""
        floors = [c for c in self.problem.constraints if self._is_damping(c)]
        watch = Watch(speeds={c.metric: self._three_speeds(c) for c in floors})
        ends = self.polished(start, watch, iterations=iterations, tolerance=tolerance)
        for _ in range(_LOOKS if self.corners is not None else 0):
            if not ends or not self._missed_at_corners(ends[0], watch)[1]:
                break
            ends = self.polished(ends[0], watch, iterations=iterations, tolerance=tolerance)
        for point in ends:
            value = self.value(point)
            with np.errstate(all="ignore"):
                margins = [one.margins(self.elements, *point).values.min() for one in self.requirements(watch)]
            if math.isfinite(value) and all(margin >= -_MISSED for margin in margins):
                return End(value, point)
        return None

    def settled(self, start: Point) -> tuple[End | None, str]:
        """The local optimum from a start at which all constraints hold as measured; or why there is none."""
        search, watch = self, Watch()
        kept: list[Point] = []
        reason = "the local search ran off to infinity"
        for _ in range(_ROUNDS if self.corners is None else _ROUNDS_AT_CORNERS):
            found = news = False
            for point in search.polished(start, watch):
                try:
                    numbers = search.limited(point)
                except PosrealError as error:
                    reason = str(error)
                    continue
                start, found, broken = point, True, search._broken(numbers)
                missed, more = search._missed_at_corners(point, watch)
                news = news or more
                if not broken and not missed:
                    kept.append(point)
                    break
                reason = f"{broken[0]} is violated: {numbers[broken[0].metric]:.6g}" if broken else missed
            if not found:
                break
            if search.is_undamped(start):
                return None, "the vehicle has next to no damping"
            closer = search.closer(start)
            again = search._look_closer(start, numbers, watch) if broken else search._loosened(numbers, watch)
            if closer is search and not again and not news:
                break
            search = closer
        if not kept:
            return None, reason
        best = min(kept, key=search.value)
        return End(search.value(best), best), ""


def distinct(ends: Sequence[End]) -> list[End]:
    """Ends in ascending order, those left out whose figure another one has to seven digits."""
    kept: list[End] = []
    for end in sorted(ends, key=lambda end: end.value):
        if not kept or end.value > kept[-1].value * (1 + 1e-7):
            kept.append(end)
    return kept


def best_settled(
    ends: Sequence[End], settle: Callable[[Point], tuple[End | None, str]], *, look: int = 1
) -> tuple[End | None, str]:
    """The best of the ends that keeps its constraints as measured; later ones are only gone to where they may win.

    Parameters
    ----------
    ends : sequence of End
        In ascending order.
    settle : as :meth:`ElementSearch.settled`
    look : int
        At least so many are settled, for figures that a grid sees badly.
    """
    best, reason = None, ""
    for number, end in enumerate(ends):
        if best is not None and number >= look and end.value >= best.value * (1 - 1e-6):
            break
        found, why = settle(end.point)
        reason = reason or why
        if found is not None and (best is None or found.value < best.value):
            best = found
    return best, reason
