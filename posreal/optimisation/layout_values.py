"""Best element values of a fixed layout.

    min J(θ, φ)   over the logarithms θ of element values and φ of free vehicle parameters, subject to the constraints

within bounds, by the same sequential quadratic programming (:mod:`.synthesis.constrained`) over the same figures
(:mod:`.synthesis.figures`) as synthesis: mean squares, weighted sums, the worst of several, largest gains, peaks in
time, damping ratios, each with its exact gradient. What each start reaches is measured again, in full, by the problem's
own metrics; speeds at which the damping turns out to be too little are added, and limits that the metric's own
quadrature sees exceeded are tightened, until everything holds.
"""

from __future__ import annotations

import itertools
import math
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from posreal.errors import BadInput, Infeasible, PosrealError
from posreal.numerics.threads import one_thread
from posreal.optimisation.caveats import reported
from posreal.optimisation.coordinates import Coordinates
from posreal.optimisation.damping import Damping
from posreal.optimisation.element_values import ElementValues
from posreal.optimisation.figure import Figure, Slopes
from posreal.optimisation.local import AtMost, Damped, Requirement, finish_constrained
from posreal.optimisation.mean_square import SETTLED, Modes, modes
from posreal.optimisation.problem_figures import figure_of, objective_figures
from posreal.optimisation.scaling import STRUT
from posreal.specification.constraint import Constraint
from posreal.specification.design import Design
from posreal.specification.layout import Layout
from posreal.specification.problem import Problem
from posreal.vehicle.metrics import SPEEDS

Array = np.ndarray
_SAFETY = 1e-7  # relative room that a constraint is given where the metric missed it
_NEAR = 0.1  # relative miss of a constraint that may be due to the search's own quadrature
_ROUNDS = 5
_SEEN, _ALIKE = (0.1, 300.0), 0.05  # rad/s; relative difference of two admittances there that are taken for the same
_FULL = 10  # elements whose every limit is looked at
_SCREENED = 7  # power of two of the points that starts are chosen from
_WATCHED = (float(SPEEDS[0]), *SPEEDS[9::15].tolist(), float(SPEEDS[-1]))
_FEW = tuple(SPEEDS[[0, 27, -1]].tolist())

Point = tuple[Array, dict[str, float]]
"""Logarithms of element values, and free vehicle parameters."""


@dataclass
class _Watch:
    """What a round is shown of each constraint: speeds of a damping ratio, a factor on a limit."""

    speeds: dict[str, tuple[float, ...]] = field(default_factory=dict)
    factors: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class _There:
    """A figure or a requirement of an operating point, where a layout's static spring or bush has the value there."""

    inner: Any
    elements: ElementValues

    def values(self, device: Any, parameters: Mapping[str, float]) -> Array:
        return np.asarray(self.inner.values(self.elements.moved(device), parameters))

    def slopes(self, chart: Coordinates, theta: Array, parameters: Mapping[str, float]) -> Slopes:
        found: Slopes = self.inner.slopes(self.elements, theta, parameters)
        return found

    def margins(self, chart: Coordinates, theta: Array, parameters: Mapping[str, float]) -> Slopes:
        found: Slopes = self.inner.margins(self.elements, theta, parameters)
        return found


class _Station:
    """One layout on one problem: its unknowns, its objective, its constraints."""

    def __init__(self, problem: Problem, layout: Layout) -> None:
        layout.require(problem)
        self.problem, self.layout = problem, layout
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
        self._see(())

    def _see(self, light: Modes) -> None:
        """Put figures on grids that see some modes."""
        self.objective: tuple[Figure, ...] = objective_figures(self._nominal, STRUT, light)
        for name, point in self._points.items():
            there = objective_figures(point, STRUT, light)
            self.objective += tuple(_There(one, self._elements_at[name]) for one in there)
        self.limits = {
            c.metric: AtMost(c.metric, figure_of(self._at(c.point), c.base, STRUT, light), c.value)
            for c in self.problem.constraints
            if c.sense == "<="
        }

    def settled(self, design: Design, point: Point) -> _Station:
        """One whose grids see a design as it is: this one, if they do to :data:`.objective.SETTLED`."""
        closer = copy(self)
        closer._see(modes(design.problem, design.port))
        seen, there = self._numbers(point), closer._numbers(point)
        return self if np.all(np.abs(seen - there) <= SETTLED * np.abs(there)) else closer

    def _numbers(self, point: Point) -> Array:
        """The objective and what is limited."""
        figures: list[Figure] = []
        for c in self.problem.constraints:
            if c.metric in self.limits:
                one = self.limits[c.metric].figure
                figures.append(_There(one, self._elements_at[c.point]) if c.point else one)
        return np.array([self.value(self.objective, point), *(self.value((one,), point) for one in figures)])

    def _at(self, point: str) -> Problem:
        return self._points[point] if point else self._nominal

    @property
    def ride(self) -> tuple[Figure, ...]:
        """Macc of the lateral problems."""
        return (figure_of(self._nominal, "Macc", STRUT),)

    def damping(self, point: str, speeds: tuple[float, ...]) -> Damping:
        """Damping ratios at an operating point."""
        return Damping(self._at(point).vehicle, STRUT, tuple(self.free), speeds)

    def requirements(self, watch: _Watch) -> list[Requirement]:
        """The constraints as the local search sees them."""
        made: list[Requirement] = []
        for c in self.problem.constraints:
            factor = watch.factors.get(c.metric, 1.0)
            one: Requirement
            if c.sense == "<=":
                one = replace(self.limits[c.metric], limit=c.value * factor)
            else:
                one = Damped(self.damping(c.point, watch.speeds.get(c.metric, _WATCHED)), c.value / 100 * factor)
            made.append(_There(one, self._elements_at[c.point]) if c.point else one)
        return made

    def least_damping(self, constraint: Constraint, speeds: tuple[float, ...], point: Point) -> Array:
        """The least damping ratio at each of the speeds, at the operating point of a constraint on it."""
        elements = self._elements_at.get(constraint.point, self.elements)
        return self.damping(constraint.point, speeds).least(elements.device(point[0]), point[1])

    def point(self, values: Mapping[str, float], vehicle: Mapping[str, float]) -> Point:
        """Where named values lie."""
        theta = np.log([values[name] for name in self.elements.names])
        return theta, {name: vehicle[name] for name in self.free}

    def tuned(self, point: Point) -> Problem:
        """The problem with its vehicle parameters in place."""
        return self.problem.with_vehicle(point[1])

    def value(self, figures: tuple[Figure, ...], point: Point) -> float:
        """The largest number of some figures."""
        strut = self.elements.device(point[0])
        return max(float(figure.values(strut, point[1]).max()) for figure in figures)


def _polish(station: _Station, start: Point, watch: _Watch) -> list[Point]:
    """Where a local search ends, and the best point on its way that seemed to keep everything."""
    with warnings.catch_warnings():
        # SLSQP says so when a line search leaves the bounds by rounding and is clipped
        warnings.filterwarnings("ignore", message="Values in x were outside bounds", category=RuntimeWarning)
        ends = finish_constrained(
            station.objective,
            station.requirements(watch),
            station.free,
            station.elements,
            *start,
            iterations=200,
            tolerance=1e-11,
        )
    return [(np.clip(theta, station.elements.lower, station.elements.upper), values) for theta, values in ends]


def _screened(station: _Station, count: int, seed: int) -> Iterator[Point]:
    """Starting points: the most promising of a scrambled Sobol set over the bounds."""
    from scipy.stats import qmc  # slow to import, and only a search needs it

    elements, free = station.elements, station.free
    ranges = np.log(np.array([[r.lower, r.upper] for r in free.values()]).reshape(-1, 2))
    lower, upper = np.append(elements.lower, ranges[:, 0]), np.append(elements.upper, ranges[:, 1])
    sobol = qmc.Sobol(len(lower), scramble=True, rng=np.random.default_rng(seed)).random_base2(_SCREENED)
    points: list[Point] = [
        (row[: elements.size], dict(zip(free, np.exp(row[elements.size :]).tolist(), strict=True)))
        for row in lower + sobol * (upper - lower)
    ]
    # a curve's peak says little of a vehicle that sways without end, its ride more
    figures = station.objective if station.problem.base_objective != "max_yv" else station.ride
    scores = np.array([station.value(figures, point) for point in points])
    floors = [c for c in station.problem.constraints if c.sense == ">="]
    order = np.argsort(scores, kind="stable")
    if floors:
        # an undamped vehicle is no start: rank by ride only among points that are near enough to the damping floor
        order = order[: len(points) // 2]
        shortfall = [
            max(0.0, *(c.value / 100 - station.least_damping(c, _FEW, points[i]).min() for c in floors)) for i in order
        ]
        order = order[np.argsort(np.array(shortfall) + 1e-3 * scores[order] / scores[order[0]], kind="stable")]
    yield from (points[i] for i in order[:count])


def _default(station: _Station) -> list[Point]:
    """The default suspension as values of the layout, elements that it lacks at whichever bound is no element."""
    problem, elements = station.problem.original, station.elements
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
    own = {name: float(getattr(problem.vehicle, name)) for name in station.free}
    return [(points[best], own)] if off[best] < _ALIKE else []


@one_thread
def optimise(
    problem: Problem,
    layout: Layout,
    *,
    starts: int = 6,
    seed: int = 0,
    jobs: int = 1,
    progress: Callable[[str], None] | None = None,
) -> Design:
    """The best element values of `layout` on `problem` that were found, with free vehicle parameters.

    Parameters
    ----------
    problem : Problem
    layout : Layout
    starts : int
        Local searches, from the best of 128 points spread over the bounds; one more begins at the default suspension
        where the layout has it as a limit.
    seed : int
    jobs : int
        Starts that run side by side (joblib).
    progress : function of str, optional
        Called with one line per start.

    Returns
    -------
    Design
        Measured by the problem's own metrics; ``found`` says how many starts agreed to 0.1 %, and which values stand
        at a bound.

    Raises
    ------
    BadInput
        If the layout does not fit the problem.
    Infeasible
        If no start led to a point that meets the constraints.
    """
    began = time.perf_counter()
    station = _Station(problem, layout)
    default = _default(station)
    points = [*_screened(station, starts, seed), *default]
    run = Parallel(n_jobs=jobs, return_as="generator")(delayed(_from_start)(station, point) for point in points)
    candidates: list[Design] = []
    refused = ""
    for number, (design, reason) in enumerate(run, 1):
        if design is not None and design.feasible:
            candidates.append(design)
        elif design is not None:
            refused = design.problem.violated(design.metrics)[0]
        else:
            refused = reason
        if progress is not None:
            progress(f"{layout.name}: start {number}/{len(points)}: {design.objective if design else reason}")
    known: list[Design] = []
    for point in default:
        with suppress(PosrealError):  # a vehicle that is not stable
            known += [design for design in [_measured(station, point)] if design.feasible]
    if not candidates and not known:
        raise Infeasible(
            f"no values of layout {layout.name} were found that meet the constraints of {problem.name}: {refused}"
        )
    best = min([*candidates, *known], key=lambda design: design.objective.value)
    agreed = sum(design.objective.value <= best.objective.value * 1.001 for design in candidates)
    return reported(
        replace(
            best,
            found={
                "method": "SLSQP on element values, exact gradients",
                "starts": len(points),
                "agreed": agreed,
                "seed": seed,
                "seconds": round(time.perf_counter() - began, 2),
                "at_bounds": _at_bounds(station, best.parameters),
            },
        )
    )


def _from_start(station: _Station, start: Point) -> tuple[Design | None, str]:
    """Polish one start until the constraints hold as the metrics measure them; or why it led nowhere."""
    watch = _Watch()
    design: Design | None = None
    kept: list[Design] = []
    for _ in range(_ROUNDS):
        reason = "the local search ran off to infinity"
        for point in _polish(station, start, watch):
            try:
                found = _measured(station, point)
            except PosrealError as error:
                reason = str(error)
                continue
            design, start = found, point
            if design.feasible:
                kept.append(design)
                break
        if design is None:
            return None, reason
        closer = station.settled(design, start)
        if closer is station and (design.feasible or not _look_closer(station, start, design, watch)):
            break
        station = closer
    return min(kept, key=lambda one: one.objective.value, default=design), ""


def _look_closer(station: _Station, point: Point, design: Design, watch: _Watch) -> bool:
    """Add the speeds at which a damping is too little, tighten what is missed by a little; False if nothing helps."""
    changed = False
    for c in station.problem.constraints:
        if c.verdict(design.metrics) != "VIOLATED":
            continue
        seen = watch.speeds.get(c.metric, _WATCHED)
        if c.sense == ">=":
            least = station.least_damping(c, tuple(SPEEDS.tolist()), point)
            speeds = tuple(np.union1d(seen, SPEEDS[least < c.value / 100]).tolist())
            if speeds != seen:
                watch.speeds[c.metric] = speeds
                changed = True
                continue
        short = c.value / design.metrics[c.metric].value
        if math.isfinite(short) and abs(short - 1) < _NEAR:
            away = 1 + _SAFETY if c.sense == ">=" else 1 - _SAFETY
            watch.factors[c.metric] = watch.factors.get(c.metric, 1.0) * short * away
            changed = True
    return changed


def _measured(station: _Station, point: Point) -> Design:
    """Everything about a point, by the problem's own metrics."""
    tuned = station.tuned(point)
    return evaluate_layout(tuned, station.layout, station.elements.values(point[0]), vehicle=point[1])


def evaluate_layout(
    problem: Problem,
    layout: Layout,
    values: Mapping[str, float],
    *,
    vehicle: Mapping[str, float] | None = None,
) -> Design:
    """A layout at given element values as a design; `vehicle` names tuned parameters for the record."""
    network = layout.valued(problem, values)
    device = network.admittance()
    metrics = problem.metrics(problem.port(device, whole=True))
    parameters = network.values() | dict(vehicle or {})
    return Design(layout.name, problem, device, metrics, network=network, whole=True, parameters=parameters)


def _at_bounds(station: _Station, parameters: Mapping[str, float]) -> list[str]:
    """Which values stand at a bound: an element that wants to vanish, to lock, or to be stiffer than allowed."""
    bounds = dict(zip(station.elements.names, station.elements.bounds, strict=True))
    bounds |= {name: (math.log(r.lower), math.log(r.upper)) for name, r in station.free.items()}
    said = []
    for name, (low, high) in bounds.items():
        where = math.log(parameters[name])
        if where <= low + 1e-6:
            said.append(f"{name} at its lower bound")
        elif where >= high - 1e-6:
            said.append(f"{name} at its upper bound")
    return said


def improve(
    problem: Problem, layout: Layout, values: Mapping[str, float], vehicle: Mapping[str, float]
) -> Design | None:
    """The local optimum that a layout reaches from given values of its elements and of free vehicle parameters.

    Returns
    -------
    Design or None
        Measured by the problem's own metrics; None if the search found nothing that can be measured.
    """
    station = _Station(problem, layout)
    design, _ = _from_start(station, station.point(values, vehicle))
    return design


def promise(problem: Problem, layout: Layout, values: Mapping[str, float], vehicle: Mapping[str, float]) -> float:
    """The objective at given values as the search sees it, constraints and stability left out of account."""
    station = _Station(problem, layout)
    with np.errstate(all="ignore"):
        return station.value(station.objective, station.point(values, vehicle))
