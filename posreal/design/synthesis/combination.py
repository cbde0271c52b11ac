"""The best positive-real device of an order: matrix inequalities, then quasi-Newton, from many starts.

Default combination (``method="auto"``), for order n:

1. the best device of order n − 1, found by 3 and 4 with few starts;
2. the matrix inequalities (:mod:`.bmi`) from the best of a hundred drawn devices;
3. quasi-Newton over devices that are positive real by construction (:mod:`.finish`, :mod:`.constrained`), from
   what 2 reached, from 1 with a weak state added, from the caller's warm devices, and from random starts on
   every face of the order (:mod:`.starts`); then from the best few of these, shaken;
4. the best on each face to full convergence; of these the best, with few digits, exactly positive real
   (:mod:`.presented`).

Why: what each reaches by itself, seed 0, and seconds of one core for the whole.

    ====================  =====  ================  ===========  =======
    problem               order  inequalities (2)  combination  seconds
    ====================  =====  ================  ===========  =======
    vertical-comfort T        1           1.96127      1.96127        1
    vertical-comfort T        2           1.92163      1.92163        2
    vertical-comfort T        3           1.92111      1.87519        7
    vertical-comfort T        4           1.90758      1.85071       18
    quarter-car J1            3           1.47970      1.45477        7
    quarter-car J1            4           1.45385      1.43384       13
    lateral-comfort           1           0.21348      0.21348       12
    ====================  =====  ================  ===========  =======

The inequalities end at a local optimum to six digits (orders 1 and 2) or on the way to one that lies at a face,
and under the damping constraint of lateral-comfort they reach from one start what a quarter of 3's random starts
reach. But from order 3 on there are many optima, and a step of theirs (0.2 s on the side view) costs more than a
whole local search of 3, so the number of starts decides. The faces and the shaking matter as much: at order 3 of
the first problem, of 16 random proper devices none ended below 1.889, on the face with a pole at 0 three of 16
ended on 1.8752, and shaken ones mostly do.
"""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from posreal.admittance import PortHamiltonian, Rational, random_port_hamiltonian, require
from posreal.admittance.device import Device, as_rational
from posreal.design.problem import Problem
from posreal.design.synthesis import bmi, presented
from posreal.design.synthesis.chart import Chart
from posreal.design.synthesis.constrained import finish_damped
from posreal.design.synthesis.criterion import Candidate, Criterion
from posreal.design.synthesis.damping import Damping
from posreal.design.synthesis.finish import finish
from posreal.design.synthesis.generalised_plant import damped_plant, generalised_plant
from posreal.design.synthesis.result import Step, Synthesis
from posreal.design.synthesis.scale import Scale, reference
from posreal.design.synthesis.starts import faces, lifted, random_starts, shaken
from posreal.design.synthesis.storage import port_hamiltonian
from posreal.errors import BadInput, listed
from posreal.vehicle import PlanView
from posreal.vehicle.metrics import SPEEDS

METHODS = ("auto", "bmi", "ph")
LARGEST_ORDER = 12
DRAWN = 100  # devices looked at for the start of the matrix inequalities
FEW = 24  # starts
CONTENDER = 1.005  # a face whose best is that near the best of all is worth full convergence
ROUNDS = 5  # fresh quasi-Newton runs along a flat valley, at most
POOL = 4  # best starts that are shaken
SECTOR_SPEEDS = (1.0, 55.0)  # m/s, where the damping of [Jiang2012]'s vehicle binds
Progress = Callable[[str], None]


def synthesise(
    problem: Problem,
    order: int,
    *,
    method: str = "auto",
    starts: int | None = None,
    seed: int = 0,
    spring: bool = False,
    inerter: bool = False,
    progress: Progress | None = None,
    warm: Sequence[Device] = (),
    settings: bmi.Settings | None = None,
) -> Synthesis:
    """Find the best positive-real device of an order.

    Parameters
    ----------
    problem : Problem
        Its objective is a mean-square figure (``J1z_…``, ``J1``, ``J3``, ``Macc``); damping may be constrained
        and the primary lateral suspension free.
    order : int
        McMillan degree of the device, 0 to 12.
    method : {"auto", "bmi", "ph"}
        The default combination (see the module's text), the matrix inequalities alone, or quasi-Newton alone.
    starts : int, optional
        Random starts of the local searches, and as many shaken ones. By default 24, and for problems without
        constraints 24 more for every order beyond the second.
    seed : int
        Of everything random; the same seed gives the same device.
    spring, inerter : bool
        Allow a spring k/s, an inerter b·s beside the device on top of the order. Not with a bush behind it:
        there, ask for the next order.
    progress : function of str, optional
        Called with a line at each event worth one.
    warm : sequence of devices
        Positive-real devices of at most the order to start from as well (the best layouts, a lower order).
    settings : bmi.Settings, optional
        Limits of the matrix inequalities' iteration.

    Returns
    -------
    Synthesis
        Interrupting (Ctrl-C) returns the best so far, and says so in its notes.

    Raises
    ------
    BadInput
        For an order, method or problem that is not supported, in a sentence.
    NotPositiveReal
        If a warm device is not.
    """
    _validated(problem, order, method, starts, spring, inerter)
    if starts is None:
        starts = FEW if problem.constraints else FEW * max(1, order - 1)
    clock = time.monotonic()
    scale = reference(problem)
    search = _Search(Criterion(problem, scale), np.random.default_rng(seed), progress or (lambda text: None))
    begun = _warm(warm, scale, order)
    search.offer("start", search.best, search.criterion.measure(search.best))
    try:
        # What a wild iterate does to floats is no news: whatever comes out is measured before it is taken.
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            _run(search, order, method, starts, spring, inerter, begun, settings or bmi.Settings())
    except KeyboardInterrupt:
        search.note("interrupted: this is the best device found until then")
    if method != "bmi" and search.landed and not search.agreeing:
        search.note("no independent start ended within 0.1 % of the best, which a shaken one reached")
    device = _presented(search, scale)
    parameters = dict(search.best.parameters)
    metrics = problem.with_vehicle(parameters).metrics(problem.mounting.port(device))
    value = metrics[problem.objective].value
    if abs(value - search.value) > 1e-3 * value:
        search.note(f"the search saw {search.value:.6g} where the metric is {value:.6g}: see its speed and resonances")
    return Synthesis(
        device=device,
        order=order,
        metrics=metrics,
        value=value,
        parameters=parameters,
        history=tuple(search.history),
        starts=len(search.landed),
        agreeing=search.agreeing,
        seconds=time.monotonic() - clock,
        seed=seed,
        method=method,
        notes=tuple(search.notes),
    )


@dataclass
class _Search:
    """The best candidate so far, and what happened on the way to it."""

    criterion: Criterion
    rng: np.random.Generator
    progress: Progress
    best: Candidate = field(init=False)
    value: float = math.inf
    history: list[Step] = field(default_factory=list)
    landed: list[float] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.best = Candidate(self.damper, self.criterion.nominal)

    @cached_property
    def damper(self) -> PortHamiltonian:
        """The vehicle's default damper, or the unit one: there is always a device to return."""
        vehicle, c = self.criterion.problem.vehicle, 1.0
        if isinstance(vehicle, PlanView):
            c = vehicle.Csy / self.criterion.scale.damper
        return PortHamiltonian(np.zeros((0, 0)), np.zeros((0, 1)), np.array([[math.sqrt(c)]]))

    @cached_property
    def limit(self) -> float | None:
        """Least damping ratio of the vehicle, where the problem has one."""
        limits = {c.metric: c.value for c in self.criterion.problem.constraints}
        return limits["Ldmp"] / 100 if "Ldmp" in limits else None

    @cached_property
    def damping(self) -> Damping:
        """Damping at the speeds that the search watches."""
        vehicle = self.criterion.problem.vehicle
        assert isinstance(vehicle, PlanView)
        return Damping(vehicle, self.criterion.scale, primary="Kpy" in self.criterion.problem.free)

    @cached_property
    def _everywhere(self) -> Damping:
        return Damping(self.damping.vehicle, self.damping.scale, self.damping.primary, tuple(SPEEDS.tolist()))

    def feasible(self, candidate: Candidate) -> bool:
        """Whether the vehicle keeps its damping at every speed."""
        if self.limit is None:
            return True
        return self._everywhere.least(candidate.device, candidate.parameters) >= self.limit * (1 - 1e-9)

    def measure(self, candidate: Candidate) -> float:
        """The objective; inf where a constraint is broken."""
        value = self.criterion.measure(candidate)
        return value if math.isfinite(value) and self.feasible(candidate) else math.inf

    def offer(self, method: str, candidate: Candidate, value: float) -> None:
        """Take a candidate if it is better than the best so far and feasible."""
        if value < self.value and self.feasible(candidate):
            self.best, self.value = candidate, value
            self.history.append(Step(method, value))

    def improved(self, chart: Chart, start: Candidate, method: str, iterations: int, tolerance: float) -> Candidate:
        """The local optimum near a start."""

        def taken(candidate: Candidate, value: float) -> None:
            self.offer(method, candidate, value)

        if self.limit is None:
            return finish(self.criterion, chart, start, iterations=iterations, tolerance=tolerance, taken=taken)
        return finish_damped(
            self.criterion,
            self.damping,
            self.limit,
            chart,
            start,
            iterations=iterations,
            tolerance=tolerance / 10,
            taken=taken,
        )

    def note(self, text: str) -> None:
        """Say something in the result and on the way."""
        self.notes.append(text)
        self.progress(text)

    @property
    def agreeing(self) -> int:
        """Starts that ended within 0.1 % of the best."""
        return sum(value <= self.value * 1.001 for value in self.landed)


def _run(
    search: _Search,
    order: int,
    method: str,
    starts: int,
    spring: bool,
    inerter: bool,
    warm: Sequence[PortHamiltonian],
    settings: bmi.Settings,
) -> None:
    """The stages of the module's text, every improvement offered to `search`."""
    below = search.best
    nominal = search.criterion.nominal
    if method != "bmi":
        for lower in range(order):
            below = _local(search, lower, max(2, min(starts, FEW) // 4), spring, inerter, [below], "lower order")
    begun = [Candidate(device, nominal) for device in warm]
    if method != "ph" and order > 0:
        count = min(starts, 4) if method == "bmi" else 1
        reached = _inequalities(search, order, count, settings, [*begun, below], below.parameters)
        if reached is None:  # what the lower order chose for the vehicle does not suit a device without an inerter
            reached = _inequalities(search, order, count, settings, begun, nominal)
        begun += [] if reached is None else [reached]
    if method != "bmi":
        _local(search, order, starts, spring, inerter, [*begun, below], "ph")


def _inequalities(
    search: _Search,
    order: int,
    starts: int,
    settings: bmi.Settings,
    known: Sequence[Candidate],
    fixed: Mapping[str, float],
) -> Candidate | None:
    """The matrix inequalities from the best of many drawn devices, `starts` times over.

    `known` candidates are among those drawn; `fixed` are the free vehicle parameters, which the inequalities leave
    alone. None if no device was found to start from.
    """
    criterion = search.criterion
    problem = criterion.problem.with_vehicle(fixed)
    plant = generalised_plant(problem, criterion.scale)
    sectors = []
    if search.limit is not None:
        assert isinstance(problem.vehicle, PlanView)
        sectors = [
            bmi.Sector(damped_plant(problem.vehicle.at(v), problem.mounting, criterion.scale), search.limit)
            for v in SECTOR_SPEEDS
        ]
    best: tuple[float, Candidate] | None = None
    for number in range(starts):
        start = _drawn(search, order, known, fixed)
        if start is None:
            return None
        search.offer("start", start, criterion.measure(start))
        outcome = bmi.iterate(
            plant,
            start.device,
            lambda device: search.measure(Candidate(device, fixed)),
            lambda device: criterion.slope(Candidate(device, fixed)),
            sectors=sectors,
            settings=settings,
            taken=lambda device, value: search.offer("bmi", Candidate(device, fixed), value),
        )
        search.landed.append(outcome.value)
        search.progress(
            f"matrix inequalities {number + 1} of {starts}: {outcome.value:.6g} after {outcome.taken} steps, "
            f"{outcome.refused} refused"
        )
        if best is None or outcome.value < best[0]:
            best = outcome.value, Candidate(outcome.device, fixed)
    return None if best is None else best[1]


def _drawn(search: _Search, order: int, known: Sequence[Candidate], fixed: Mapping[str, float]) -> Candidate | None:
    """The best feasible of many devices: drawn at random, or known ones with weak states added."""
    bases = [search.damper, *(c.device for c in known if c.device.order <= order and not c.device.k + c.device.b)]
    devices: list[PortHamiltonian] = []
    if search.limit is None:
        devices += [random_port_hamiltonian(order, search.rng, 1.0) for _ in range(DRAWN)]
    for coupling in (0.3, 0.1, 0.03, 0.01, 0.001, 0.0):
        devices += [lifted(base, order, search.rng, coupling) for base in bases for _ in range(DRAWN // 10)]
        best = min((Candidate(device, fixed) for device in devices), key=search.measure)
        if math.isfinite(search.measure(best)):
            return best
        devices = []
    return None


def _local(
    search: _Search,
    order: int,
    starts: int,
    spring: bool,
    inerter: bool,
    begun: Sequence[Candidate],
    method: str,
) -> Candidate:
    """Quasi-Newton from given candidates, random ones, the best of these shaken; then to full convergence."""
    charts = faces(order, spring=spring, inerter=inerter)
    found: list[tuple[float, Chart, Candidate]] = []

    def run(chart: Chart, start: Candidate) -> float:
        candidate = search.improved(chart, start, method, 150, 1e-6)
        value = search.measure(candidate)
        if not found or value < min(found, key=_value)[0]:
            search.progress(f"order {order}, {len(found) + 1} starts: {value:.6g}")
        found.append((value, chart, candidate))
        return value

    for start in begun:
        chart = _fitting(charts, start.device)
        run(chart, Candidate(lifted(start.device, chart.order, search.rng), start.parameters))
    random = random_starts(charts, search.rng)
    for _ in range(starts):
        chart, device = next(random)
        value = run(chart, Candidate(device, search.criterion.nominal))
        if method == "ph":
            search.landed.append(value)
    pool = _distinct(sorted(found, key=_value))[:POOL]
    for number in range(starts if order else 0):
        _, chart, candidate = pool[number % len(pool)]
        value = run(chart, Candidate(shaken(chart, candidate.device, search.rng), candidate.parameters))
        if value < pool[number % len(pool)][0]:
            pool[number % len(pool)] = found[-1]
    close = min(found, key=_value)[0] * CONTENDER
    for chart in charts:
        here = [entry for entry in found if entry[1] == chart and entry[0] <= close]
        if here:
            _, _, candidate = min(here, key=_value)
            before = math.inf
            value = search.measure(candidate)
            for _ in range(ROUNDS):
                if value > before * (1 - 1e-7):
                    break
                before = value
                candidate = search.improved(chart, candidate, method, 1000, 1e-10)
                value = search.measure(candidate)
            found.append((value, chart, candidate))
    return min(found, key=_value)[2]


def _distinct(found: Sequence[tuple[float, Chart, Candidate]]) -> list[tuple[float, Chart, Candidate]]:
    """Of candidates in order of value, the first of each value and face."""
    kept: list[tuple[float, Chart, Candidate]] = []
    for entry in found:
        if not any(entry[1] == other[1] and abs(entry[0] - other[0]) <= 1e-5 * other[0] for other in kept):
            kept.append(entry)
    return kept


def _value(entry: tuple[float, Chart, Candidate]) -> float:
    return entry[0]


def _fitting(charts: Sequence[Chart], device: PortHamiltonian) -> Chart:
    """The chart that holds a device, the one with the most states if there are several."""
    for chart in charts:
        if device.order <= chart.order and (chart.spring or not device.k) and (chart.inerter or not device.b):
            return chart
    raise BadInput(f"a start of order {device.order} does not fit order {charts[0].order}")


def _warm(devices: Sequence[Device], scale: Scale, order: int) -> list[PortHamiltonian]:
    found = []
    for device in devices:
        Y = require(as_rational(device))
        if Y.degree > order:
            raise BadInput(f"a warm start has degree {Y.degree}; ask for at least that order, or leave it out")
        form = None if Y.is_zero() else port_hamiltonian(scale.from_admittance(Y))
        if form is not None:
            found.append(form)
    return found


def _presented(search: _Search, scale: Scale) -> Rational:
    """The best device as a tidy exact admittance."""
    criterion, parameters = search.criterion, search.best.parameters

    def acceptable(H: Rational) -> bool:
        value = criterion.value_and_slope(np.asarray(H(criterion.s)), parameters)[0]
        return value <= search.value * (1 + 1e-9) and not _breaks(criterion.problem, scale.admittance(H), parameters)

    H = presented.tidy(search.best.device.rational(), acceptable)
    Y, note = presented.rounded(scale.admittance(H))
    if note:
        search.note(note)
    return Y


def _breaks(problem: Problem, Y: Rational, parameters: Mapping[str, float]) -> bool:
    """Whether a device breaks a constraint, by the problem's own metrics."""
    changed = problem.with_vehicle(parameters)
    return bool(problem.constraints) and bool(changed.violated(changed.metrics(problem.mounting.port(Y))))


def _validated(problem: Problem, order: int, method: str, starts: int | None, spring: bool, inerter: bool) -> None:
    if isinstance(order, bool) or not isinstance(order, int) or not 0 <= order <= LARGEST_ORDER:
        raise BadInput(f"order {order!r} cannot be synthesised; give a whole number from 0 to {LARGEST_ORDER}")
    if method not in METHODS:
        raise BadInput(f"unknown method {method!r}; the methods are {listed(METHODS)}")
    if starts is not None and starts < 1:
        raise BadInput(f"starts is {starts}; give at least 1")
    if problem.objective == "max_yv":
        raise BadInput(
            f"{problem.name} minimises a peak in time, which is not a mean square: synthesis cannot take it yet; "
            "optimise a layout for it"
        )
    if (spring or inerter) and problem.mounting.behind is not None:
        raise BadInput("a spring or inerter cannot be added behind a bush; ask for the next order, which has it")
