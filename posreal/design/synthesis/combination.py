"""The best positive-real device of an order: the matrix inequalities, finished by quasi-Newton, from many starts.

Default combination (``method="auto"``), for order n:

1. the best device of order n − 1, found the same way with few starts;
2. the matrix inequalities (:mod:`.bmi`) from the best of a hundred drawn devices;
3. quasi-Newton over devices that are positive real by construction (:mod:`.finish`), from what 2 reached, from 1 with
   a weak state added, from the caller's warm devices, and from random starts on every face of the order (:mod:`.starts`);
4. the best of them to full convergence, then few digits, exactly positive real (:mod:`.presented`).

MEASUREMENT
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from posreal.admittance import PortHamiltonian, Rational, random_port_hamiltonian, require
from posreal.admittance.device import Device, as_rational
from posreal.design.problem import Problem
from posreal.design.synthesis import bmi, presented
from posreal.design.synthesis.chart import Chart
from posreal.design.synthesis.criterion import Criterion
from posreal.design.synthesis.finish import finish
from posreal.design.synthesis.generalised_plant import generalised_plant
from posreal.design.synthesis.result import Step, Synthesis
from posreal.design.synthesis.scale import Scale, reference
from posreal.design.synthesis.starts import faces, lifted, random_starts
from posreal.design.synthesis.storage import port_hamiltonian
from posreal.errors import BadInput, listed

METHODS = ("auto", "bmi", "ph")
LARGEST_ORDER = 12
DRAWN = 100  # devices looked at for the start of the matrix inequalities
Progress = Callable[[str], None]


def synthesise(
    problem: Problem,
    order: int,
    *,
    method: str = "auto",
    starts: int = 16,
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
        Its objective is a mean-square figure (``J1z_…``, ``J1``, ``J3``).
    order : int
        McMillan degree of the device, 0 to 12.
    method : {"auto", "bmi", "ph"}
        The default combination (see the module's text), the matrix inequalities alone, or quasi-Newton alone.
    starts : int
        Random starts of the local searches.
    seed : int
        Of everything random; the same seed gives the same device.
    spring, inerter : bool
        Allow a spring k/s, an inerter b·s beside the device on top of the order. Not with a bush behind it: there,
        ask for the next order.
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
    scale = reference(problem)
    begun = _warm(warm, scale, order)
    search = _Search(Criterion(problem, scale), np.random.default_rng(seed), progress or (lambda text: None))
    clock = time.monotonic()
    try:
        _search(search, order, method, starts, spring, inerter, begun, settings or bmi.Settings())
    except KeyboardInterrupt:
        search.note("interrupted: this is the best device found until then")
    device = _present(search, scale)
    metrics = problem.metrics(problem.mounting.port(device))
    return Synthesis(
        device=device,
        order=order,
        metrics=metrics,
        value=metrics[problem.objective].value,
        parameters={},
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
    """The best device so far, and what happened on the way to it."""

    criterion: Criterion
    rng: np.random.Generator
    progress: Progress
    best: PortHamiltonian | None = None
    value: float = math.inf
    history: list[Step] = field(default_factory=list)
    landed: list[float] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def offer(self, method: str, device: PortHamiltonian, value: float) -> None:
        """Take a device if it is better than the best so far."""
        if value < self.value:
            self.best, self.value = device, value
            self.history.append(Step(method, value))

    def note(self, text: str) -> None:
        """Say something in the result and on the way."""
        self.notes.append(text)
        self.progress(text)

    @property
    def agreeing(self) -> int:
        """Starts that ended within 0.1 % of the best."""
        return sum(value <= self.value * 1.001 for value in self.landed)


def _search(
    search: _Search,
    order: int,
    method: str,
    starts: int,
    spring: bool,
    inerter: bool,
    warm: Sequence[PortHamiltonian],
    settings: bmi.Settings,
) -> None:
    """Run the stages of the module's text, offering every improvement to `search`."""
    damper = _damper(search)
    below = [damper]
    if method != "bmi":
        for lower in range(order):
            below.append(_local(search, lower, min(starts, 6), spring, inerter, below[-1:], "lower order"))
    begun = [*warm, *below[-1:]]
    if method != "ph" and order > 0:
        begun.append(_inequalities(search, order, starts if method == "bmi" else 1, settings))
    if method != "bmi":
        _local(search, order, starts, spring, inerter, begun, "ph")


def _damper(search: _Search) -> PortHamiltonian:
    """The plain damper of one unit, so that there is always a device to return."""
    nothing = np.zeros((0, 0))
    damper = PortHamiltonian(nothing, np.zeros((0, 1)), np.ones((1, 1)))
    search.offer("start", damper, search.criterion.measure(damper))
    return damper


def _inequalities(search: _Search, order: int, starts: int, settings: bmi.Settings) -> PortHamiltonian:
    """The matrix inequalities from the best of many drawn devices, `starts` times over."""
    criterion = search.criterion
    plant = generalised_plant(criterion.problem, criterion.scale)
    best: tuple[float, PortHamiltonian] | None = None
    for number in range(starts):
        drawn = [random_port_hamiltonian(order, search.rng, 1.0) for _ in range(DRAWN)]
        start = min(drawn, key=criterion.measure)
        search.offer("start", start, criterion.measure(start))
        outcome = bmi.iterate(
            plant,
            start,
            criterion.measure,
            criterion.slope,
            settings=settings,
            taken=lambda device, value: search.offer("bmi", device, value),
        )
        search.landed.append(outcome.value)
        search.progress(
            f"matrix inequalities {number + 1}: {outcome.value:.6g} in {outcome.taken} steps "
            f"({outcome.refused} refused)"
        )
        if best is None or outcome.value < best[0]:
            best = outcome.value, outcome.device
    assert best is not None
    return best[1]


def _local(
    search: _Search,
    order: int,
    starts: int,
    spring: bool,
    inerter: bool,
    begun: Sequence[PortHamiltonian],
    method: str,
) -> PortHamiltonian:
    """Quasi-Newton from given devices and random ones; the best is polished to full convergence."""
    criterion = search.criterion
    charts = faces(order, spring=spring, inerter=inerter)
    pairs = [(_fitting(charts, device), device) for device in begun]
    # a weak state more than a device of lower order has
    pairs = [
        (chart, device if device.order == chart.order else lifted(device, chart.order, search.rng))
        for chart, device in pairs
    ]
    random = random_starts(charts, search.rng)
    pairs += [next(random) for _ in range(starts)]
    best: tuple[float, Chart, PortHamiltonian] | None = None
    for number, (chart, start) in enumerate(pairs, 1):
        device, value = finish(
            criterion,
            chart,
            start,
            iterations=150,
            tolerance=1e-6,
            taken=lambda device, value: search.offer(method, device, value),
        )
        if method == "ph":
            search.landed.append(value)
        if best is None or value < best[0]:
            best = value, chart, device
            search.progress(f"order {order}, start {number} of {len(pairs)}: {value:.6g}")
    assert best is not None
    device, value = finish(
        criterion,
        best[1],
        best[2],
        iterations=1000,
        tolerance=1e-10,
        taken=lambda device, value: search.offer(method, device, value),
    )
    return device


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
        if Y.is_zero():
            continue
        form = port_hamiltonian(scale.from_admittance(Y))
        if form is not None:
            found.append(form)
    return found


def _present(search: _Search, scale: Scale) -> Rational:
    """The best device as a tidy exact admittance."""
    assert search.best is not None
    criterion = search.criterion
    limit = search.value * (1 + 1e-9)

    def acceptable(H: Rational) -> bool:
        return criterion.value_and_slope(np.asarray(H(criterion.s)))[0] <= limit

    H = presented.tidy(search.best.rational(), acceptable)
    Y, note = presented.rounded(scale.admittance(H))
    if note:
        search.note(note)
    return Y


def _validated(problem: Problem, order: int, method: str, starts: int, spring: bool, inerter: bool) -> None:
    if isinstance(order, bool) or not isinstance(order, int) or not 0 <= order <= LARGEST_ORDER:
        raise BadInput(f"order {order!r} cannot be synthesised; give a whole number from 0 to {LARGEST_ORDER}")
    if method not in METHODS:
        raise BadInput(f"unknown method {method!r}; the methods are {listed(METHODS)}")
    if starts < 1:
        raise BadInput(f"starts is {starts}; give at least 1")
    if problem.objective == "max_yv":
        raise BadInput(
            f"{problem.name} minimises a peak in time, which is not a mean square: synthesis cannot take it yet; "
            "optimise a layout instead"
        )
    if (spring or inerter) and problem.mounting.behind is not None:
        raise BadInput("a spring or inerter cannot be added behind a bush; ask for the next order, which has it")
