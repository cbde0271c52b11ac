"""The matrix inequalities (:mod:`.path_following`) on a problem: its norms, its sectors, and devices to begin with."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from posreal.admittance import PortHamiltonian, random_port_hamiltonian
from posreal.optimisation.coordinates import Chart
from posreal.optimisation.criterion import Candidate
from posreal.optimisation.figure import PeakGain, PortFigure
from posreal.optimisation.nonlinear_program import damper
from posreal.optimisation.problem_figures import figure_of
from posreal.optimisation.scaling import Scale
from posreal.specification.problem import Problem
from posreal.synthesis import path_following
from posreal.synthesis.generalised_plant import damped_plant, generalised_plant
from posreal.synthesis.incumbent import Incumbent
from posreal.synthesis.linearised import LinearisedNorm, Sector
from posreal.synthesis.starts import faces, inside, lifted

SLACK = 1.01  # a drawn device that near the best may be preferred for its damping
DRAWN = 100  # devices looked at for the start
COUPLINGS = (0.3, 0.1, 0.03, 0.01, 0.001, 0.0)  # of the states added to known ones, weaker until one is feasible
FIRST = 8  # iterations from every start
TO_THE_END = 6  # starts of which the iteration goes on
RESTORING = 20  # times so many iterations at most until the limits are kept
SECTOR_SPEEDS = (1.0, 55.0)  # m/s, where the damping of [Jiang2012]'s vehicle binds
AT_THE_ENDS = ("static_stiffness", "inertance")  # metrics that the spring and inerter beside the device decide


def programs(
    search: Incumbent,
    order: int,
    starts: int,
    settings: path_following.Settings,
    known: Sequence[Candidate],
    fixed: Mapping[str, float],
    rng: np.random.Generator,
    *,
    asked: bool,
    spring: bool = False,
    inerter: bool = False,
) -> Candidate | None:
    """The matrix inequalities from the best of many drawn devices, `starts` times over.

    Each start is on the next face of the order (:func:`.starts.faces`) and is iterated a few times; the best few
    are iterated to the end, and the best of these once more among the proper devices, if it is on another face.

    Parameters
    ----------
    search : Search
    order, starts : int
    settings : path_following.Settings
    known : sequence of Candidate
        Among those drawn.
    fixed : mapping
        Free vehicle parameters, which the inequalities leave alone.
    rng : numpy.random.Generator
    asked : bool
        Whether this is the order that was asked for: then where it ends counts.
    spring, inerter : bool
        Allowed beside the device.

    Returns
    -------
    Candidate or None
        None if no device was found to start from.

    Raises
    ------
    BadInput
        If the objective or a limit is no norm.
    """
    judge = search.judge
    goals = goals_of(judge.problem.with_vehicle(fixed), judge.scale)
    charts = faces(order, spring=spring, inerter=inerter)
    if judge.scale.impedance:  # a pole at 0 would be a state of the bush's force that the plant does not have
        charts = tuple(chart for chart in charts if not chart.spring)

    def iterated(chart: Chart, start: PortHamiltonian, settings: path_following.Settings) -> path_following.Outcome:
        return path_following.iterate(
            goals,
            start,
            lambda device: judge.measure(Candidate(device, fixed)),
            spring=chart.spring,
            inerter=chart.inerter,
            settings=settings,
            taken=lambda device, value: search.offer("bmi", Candidate(device, fixed), value),
        )

    short = replace(settings, iterations=min(settings.iterations, FIRST))
    begun: list[tuple[Chart, path_following.Outcome]] = []
    for number in range(starts):
        chart = charts[number % len(charts)]
        start = _drawn(search, goals, chart, known, fixed, rng)
        if start is None:
            continue
        search.offer("start", start, judge.measure(start))
        begun.append((chart, iterated(chart, start.device, short)))
        search.progress(f"matrix inequalities {number + 1} of {starts}: {begun[-1][1].value:.6g}")
    begun.sort(key=lambda run: run[1].value)
    rest = replace(settings, iterations=settings.iterations - short.iterations)

    def to_the_end(chart: Chart, outcome: path_following.Outcome) -> path_following.Outcome:
        ended = iterated(chart, outcome.device, replace(rest, radius=max(outcome.radius, settings.radius)))
        search.progress(
            f"matrix inequalities to the end: {ended.value:.6g} after {ended.taken} more steps, {ended.refused} refused"
        )
        return ended

    ended = [(chart, to_the_end(chart, outcome)) for chart, outcome in begun[:TO_THE_END]]
    ended.sort(key=lambda run: run[1].value)
    if asked:
        search.landed += [outcome.value for _, outcome in [*ended, *begun[TO_THE_END:]]]
    for chart, outcome in ended[:1]:
        if chart != charts[0]:  # off the face again
            proper = inside(outcome.device, charts[0])
            ended.append((charts[0], to_the_end(charts[0], replace(outcome, device=proper))))
    best = min((outcome for _, outcome in ended), key=lambda outcome: outcome.value, default=None)
    return None if best is None else Candidate(best.device, fixed)


def goals_of(problem: Problem, scale: Scale) -> path_following.Goals:
    """A problem's objective and constraints as inequalities, free vehicle parameters at their present values.

    Raises
    ------
    BadInput
        If the objective or a limit is neither a root mean square nor a largest gain.
    """
    present = replace(problem, free={})

    def norm(point: Problem, metric: str) -> LinearisedNorm:
        plant = generalised_plant(point, scale, metric)
        figure = figure_of(point, metric, scale)
        assert isinstance(figure, PortFigure | PeakGain)
        return LinearisedNorm(plant, point.gain_output(metric) is not None, figure)

    sums: list[tuple[tuple[float, LinearisedNorm], ...]] = []
    for point in (present, *present.at_points.values()):
        goal = point.goal
        parts = ((point.base_objective, 1.0),) if goal is None or goal.kind == "norm" else goal.parts
        weighted = [(weight, norm(point, name)) for name, weight in parts]
        sums += [(part,) for part in weighted] if goal is not None and goal.kind == "worst" else [tuple(weighted)]
    limits, sectors = [], []
    most = dict.fromkeys(AT_THE_ENDS, math.inf)
    for constraint in problem.constraints:
        point = present.at_points[constraint.point] if constraint.point else present
        if constraint.sense == ">=":
            sectors += [
                Sector(damped_plant(point.vehicle.at(v), point.mounting, scale), constraint.value / 100)
                for v in SECTOR_SPEEDS
            ]
        elif constraint.base in AT_THE_ENDS:
            beside = figure_of(point, constraint.base, scale).values(damper(1.0), {})[0]
            most[constraint.base] = min(most[constraint.base], constraint.value - beside)
        else:
            limits.append((norm(point, constraint.base), constraint.value))
    return path_following.Goals(
        tuple(sums),
        tuple(limits),
        tuple(sectors),
        stiffness=most["static_stiffness"] / (scale.damper * scale.omega),
        inertance=most["inertance"] * scale.omega / scale.damper,
    )


def _drawn(
    search: Incumbent,
    goals: path_following.Goals,
    chart: Chart,
    known: Sequence[Candidate],
    fixed: Mapping[str, float],
    rng: np.random.Generator,
) -> Candidate | None:
    """The best feasible of many devices: drawn at random, or known ones with weak states added."""
    judge = search.judge
    bases = [judge.default, *(c.device for c in known if _fits(c.device, chart))]
    devices: list[PortHamiltonian] = []
    first: list[PortHamiltonian] = []
    if not judge.floors:
        devices += [random_port_hamiltonian(chart.order, rng, 1.0) for _ in range(DRAWN // 2)]
    for coupling in COUPLINGS:
        devices += [lifted(base, chart.order, rng, coupling) for base in bases for _ in range(DRAWN // 2)]
        devices = [_beside(device, chart, goals, rng) for device in devices]
        first = first or devices
        candidates = sorted((Candidate(device, fixed) for device in devices), key=judge.value)
        if judge.floors:  # well inside: at the sector's edge the first step goes nowhere
            best = judge.value(candidates[0])
            near = [candidate for candidate in candidates if judge.value(candidate) <= best * SLACK]
            candidates = sorted(near, key=judge.spare, reverse=True)
        for candidate in candidates:
            if math.isfinite(judge.measure(candidate)):  # dear where damping has to be kept, so in this order
                return candidate
        devices = []
    return _restored(search, goals, chart, first, fixed) if goals.limits else None


def _restored(
    search: Incumbent,
    goals: path_following.Goals,
    chart: Chart,
    devices: Sequence[PortHamiltonian],
    fixed: Mapping[str, float],
) -> Candidate | None:
    """A device within the limits by the inequalities themselves: the worst of norm/limit is lowered to 1."""
    towards = replace(goals, objective=tuple(((1 / limit, norm),) for norm, limit in goals.limits), limits=())

    def worst(device: PortHamiltonian) -> float:
        return max(norm.value(device) / limit for norm, limit in goals.limits)

    start = Candidate(min(devices, key=worst), fixed)
    few = path_following.Settings(iterations=FIRST)
    for _ in range(RESTORING):
        outcome = path_following.iterate(
            towards, start.device, worst, spring=chart.spring, inerter=chart.inerter, settings=few
        )
        start, few = Candidate(outcome.device, fixed), replace(few, radius=outcome.radius)
        if math.isfinite(search.judge.measure(start)):
            return start
        if not outcome.taken:
            break
    return None


def _fits(device: PortHamiltonian, chart: Chart) -> bool:
    return device.order <= chart.order and (chart.spring or not device.k) and (chart.inerter or not device.b)


def _beside(
    device: PortHamiltonian, chart: Chart, goals: path_following.Goals, rng: np.random.Generator
) -> PortHamiltonian:
    """The device with a spring and an inerter drawn beside it where the chart has a place for them."""
    k, b = 10.0 ** rng.uniform(-2, 0.5, 2)
    return PortHamiltonian(
        device.J,
        device.G,
        device.L,
        device.k or min(k, goals.stiffness) * chart.spring,
        device.b or min(b, goals.inertance) * chart.inerter,
    )
