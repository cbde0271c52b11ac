"""Best element values of a fixed layout.

    min J(θ)   over θ = log(element values, free vehicle parameters) within bounds, subject to the constraints

J of a mean-square objective has an exact gradient: the frequency grid gives dJ/dY and the network dY/dθ (see
:mod:`posreal.design.objective`). Damping ratios and the curve's peak come from eigenvalues; their gradients are
differences. Each start is polished by SLSQP; the best of them is measured again, in full, by the problem's own metrics,
and speeds at which the damping constraint turns out to bind are added until it holds at all of them.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from joblib import Parallel, delayed
from scipy.optimize import minimize

from posreal.admittance.state_space import StateSpace, state_space
from posreal.design.guard import guarded
from posreal.design.layout import Layout
from posreal.design.objective import MeanSquare, mean_square
from posreal.design.problem import Problem
from posreal.design.result import Design
from posreal.design.threads import one_thread
from posreal.errors import Infeasible, PosrealError
from posreal.vehicle import PlanView, damping
from posreal.vehicle.metrics import SPEEDS, curve_peak, lateral_poles

Array = np.ndarray
_STEP = 1e-6  # of a difference in log θ: half the digits of an eigenvalue
_SAFETY = 1e-7  # constraints are asked for with this relative margin, so that rounding leaves them satisfied
_MODES = 4  # least damped modes of each speed that SLSQP sees: enough that two can change places


@dataclass(frozen=True)
class _Free:
    """The unknowns: names, bounds, and how a vector of logarithms becomes values."""

    elements: tuple[str, ...]
    vehicle: tuple[str, ...]
    lower: Array
    upper: Array

    @property
    def names(self) -> tuple[str, ...]:
        return self.elements + self.vehicle

    def values(self, theta: Array) -> dict[str, float]:
        """Values of the free elements and vehicle parameters."""
        return dict(zip(self.names, np.exp(np.clip(theta, self.lower, self.upper)).tolist(), strict=True))


class _Station:
    """One layout on one problem as functions of θ; remembers the last point, as SLSQP asks for it several times."""

    def __init__(self, problem: Problem, layout: Layout) -> None:
        layout.require(problem)
        self.problem, self.layout = problem, layout
        elements = layout.free_elements(problem)
        tied = {problem.roles[rule.role] for rule in layout.rules.values() if rule.role}
        vehicle = {name: (r.lower, r.upper) for name, r in problem.free.items() if name not in tied}
        bounds = np.log(np.array([*elements.values(), *vehicle.values()]).reshape(-1, 2))
        self.free = _Free(tuple(elements), tuple(vehicle), bounds[:, 0], bounds[:, 1])
        self.settled = layout.settled_values(problem)
        self.ride: MeanSquare = mean_square(problem, primary_open=bool(vehicle))
        self._index = [layout.network.names.index(name) for name in elements]

    def tuned(self, theta: Array) -> tuple[Problem, dict[str, float]]:
        """The problem with its vehicle parameters in place, and all element values."""
        values = self.free.values(theta)
        vehicle = {name: values[name] for name in self.free.vehicle}
        return self.problem.with_vehicle(vehicle), self.settled | {n: values[n] for n in self.free.elements}

    def rms(self, theta: Array) -> tuple[float, Array]:
        """The mean-square metric and its gradient in θ."""
        values = self.free.values(theta)
        elements = [(self.settled | values)[name] for name in self.layout.network.names]
        s = self.ride.s
        Y, dY = self.layout.network.evaluate(elements, s)
        beside = self.problem.layout_mounting.beside
        ports = {"secondary": Y if beside is None else Y + np.asarray(beside(s))}
        if self.free.vehicle:
            ports["primary"] = values["Kpy"] / s + values["Cpy"]
        J, slopes = self.ride.value_and_slopes(ports)
        gradient = [float((slopes["secondary"] @ dY[i]).real) for i in self._index]
        if self.free.vehicle:
            share = {"Kpy": values["Kpy"] / s, "Cpy": np.full_like(s, values["Cpy"])}
            gradient += [float((slopes["primary"] @ share[name]).real) for name in self.free.vehicle]
        return J, np.array(gradient)

    def device(self, theta: Array) -> tuple[PlanView, StateSpace]:
        """Vehicle and port device in state space, for poles and time responses (lateral problems)."""
        tuned, elements = self.tuned(theta)
        network = self.layout.network.with_values(elements)
        assert isinstance(tuned.vehicle, PlanView)
        return tuned.vehicle, state_space(self.problem.port(network.admittance(), whole=True))

    def damping_ratios(self, theta: Array, speeds: Array) -> Array:
        """The least damping ratios of each speed, in ascending order, one after another."""
        vehicle, device = self.device(theta)
        poles = lateral_poles(vehicle, device, speeds)
        upper = np.where(poles.imag >= 0, damping.ratios(poles), np.inf)
        return np.asarray(np.sort(upper, axis=1)[:, :_MODES].ravel())

    def peak(self, theta: Array) -> float:
        """Max(yv), mm."""
        return 1e3 * curve_peak(*self.device(theta))


def _gradient(function: Callable[[Array], Array | float], theta: Array) -> Array:
    """Central differences, one row an output."""
    rows = []
    for i in range(len(theta)):
        step = np.zeros_like(theta)
        step[i] = _STEP
        rows.append((np.atleast_1d(function(theta + step)) - np.atleast_1d(function(theta - step))) / (2 * _STEP))
    return np.array(rows).T


@dataclass(frozen=True)
class _Watch:
    """What SLSQP is shown of the constraints: `speeds` of the damping ratio, and metric / smooth figure of Macc."""

    speeds: Array
    correction: float = 1.0


def _constraints(station: _Station, watch: _Watch) -> list[dict[str, object]]:
    """The problem's constraints for SLSQP, each scaled to order one."""
    made: list[dict[str, object]] = []
    for constraint in station.problem.constraints:
        if constraint.metric == "Ldmp":

            def slack(theta: Array, floor: float = constraint.value / 100 * (1 + _SAFETY)) -> Array:
                return (station.damping_ratios(theta, watch.speeds) - floor) / floor

            made.append({"type": "ineq", "fun": slack, "jac": lambda theta, f=slack: _gradient(f, theta)})
        else:
            ceiling = constraint.value * (1 - _SAFETY) / watch.correction
            made.append(
                {
                    "type": "ineq",
                    "fun": lambda theta, c=ceiling: 1 - station.rms(theta)[0] / c,
                    "jac": lambda theta, c=ceiling: -station.rms(theta)[1] / c,
                }
            )
    return made


def _polish(station: _Station, start: Array, watch: _Watch) -> Array:
    """SLSQP from one start."""
    if station.problem.objective == "max_yv":
        scale = station.peak(start)

        def objective(theta: Array) -> tuple[float, Array]:
            return station.peak(theta) / scale, _gradient(station.peak, theta)[0] / scale
    else:
        scale = station.rms(start)[0]

        def objective(theta: Array) -> tuple[float, Array]:
            J, slope = station.rms(theta)
            return J / scale, slope / scale

    with warnings.catch_warnings():
        # SLSQP says so when a line search leaves the bounds by rounding and is clipped
        warnings.filterwarnings("ignore", message="Values in x were outside bounds", category=RuntimeWarning)
        result = minimize(
            objective,
            start,
            jac=True,
            method="SLSQP",
            bounds=list(zip(station.free.lower, station.free.upper, strict=True)),
            constraints=_constraints(station, watch),
            options={"maxiter": 200, "ftol": 1e-11},
        )
    return np.clip(np.asarray(result.x), station.free.lower, station.free.upper)


def _screened(station: _Station, count: int, seed: int) -> Iterator[Array]:
    """Starting points: the most promising of a scrambled Sobol set over the bounds."""
    from scipy.stats import qmc  # slow to import, and only a search needs it

    size = len(station.free.names)
    sobol = qmc.Sobol(size, scramble=True, rng=np.random.default_rng(seed)).random_base2(7)
    points = station.free.lower + sobol * (station.free.upper - station.free.lower)
    scores = np.array([station.rms(theta)[0] for theta in points])
    if "Ldmp" in station.problem.keep:
        # an undamped vehicle is no start: rank by ride only among points that are near enough to the damping floor
        floor = next(c.value for c in station.problem.constraints if c.metric == "Ldmp") / 100
        order = np.argsort(scores)[: len(points) // 2]
        few = SPEEDS[[0, 27, -1]]
        shortfall = np.array([max(0.0, floor - station.damping_ratios(points[i], few).min()) for i in order])
        yield from points[order[np.argsort(shortfall + 1e-3 * scores[order] / scores[order[0]])][:count]]
    else:
        yield from points[np.argsort(scores)[:count]]


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
        Local searches, from the best of 128 points spread over the bounds.
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
    points = list(_screened(station, starts, seed))
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
            progress(f"{layout.name}: start {number}/{starts}: {design.objective if design else reason}")
    if not candidates:
        raise Infeasible(
            f"no values of layout {layout.name} were found that meet the constraints of {problem.name}: {refused}"
        )
    best = min(candidates, key=lambda design: design.objective.value)
    agreed = sum(design.objective.value <= best.objective.value * 1.001 for design in candidates)
    return guarded(
        replace(
            best,
            found={
                "method": "SLSQP on element values, exact gradients",
                "starts": starts,
                "agreed": agreed,
                "seed": seed,
                "seconds": round(time.perf_counter() - began, 2),
                "at_bounds": _at_bounds(station, best.parameters),
            },
        )
    )


def _from_start(station: _Station, start: Array) -> tuple[Design | None, str]:
    """Polish one start until the constraints hold as the metrics measure them; or why it led nowhere."""
    watch = _Watch(np.array([SPEEDS[0], *SPEEDS[9::15], SPEEDS[-1]]))
    theta = start
    design: Design | None = None
    for _ in range(5):
        theta = _polish(station, theta, watch)
        try:
            design = _measured(station, theta)
        except PosrealError as error:
            return None, str(error)
        if design.feasible:
            break
        watch = _Watch(
            np.union1d(watch.speeds, _violating_speeds(station, theta)),
            design.metrics["Macc"].value / station.rms(theta)[0] if "Macc" in design.metrics else 1.0,
        )
    return design, ""


def _measured(station: _Station, theta: Array) -> Design:
    """Everything about a point, by the problem's own metrics."""
    tuned, elements = station.tuned(theta)
    return evaluate_layout(
        tuned, station.layout, elements, vehicle={n: getattr(tuned.vehicle, n) for n in station.free.vehicle}
    )


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


def _violating_speeds(station: _Station, theta: Array) -> Array:
    """Speeds at which the damping constraint is broken."""
    floors = [c.value / 100 for c in station.problem.constraints if c.metric == "Ldmp"]
    if not floors:
        return np.array([])
    vehicle, device = station.device(theta)
    least = damping.ratios(lateral_poles(vehicle, device, SPEEDS)).min(axis=1)
    return np.asarray(SPEEDS[least < floors[0]])


def _at_bounds(station: _Station, parameters: Mapping[str, float]) -> list[str]:
    """Which values stand at a bound: an element that wants to vanish, to lock, or to be stiffer than allowed."""
    said = []
    for name, low, high in zip(station.free.names, station.free.lower, station.free.upper, strict=True):
        where = np.log(parameters[name])
        if where <= low + 1e-6:
            said.append(f"{name} at its lower bound")
        elif where >= high - 1e-6:
            said.append(f"{name} at its upper bound")
    return said
