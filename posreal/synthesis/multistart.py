"""Local searches from many starts, the best of these shaken, the best of all to full convergence."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from posreal.admittance import PortHamiltonian
from posreal.errors import BadInput
from posreal.metric import ClosedVehicle
from posreal.metric.damping_ratio import least_damping
from posreal.optimisation.coordinates import Chart
from posreal.optimisation.criterion import Candidate
from posreal.optimisation.damping import SEARCH_SPEEDS
from posreal.synthesis.incumbent import AGREED, Found, Incumbent, Task
from posreal.synthesis.starts import RESONANCES, faces, inside, lifted, random_starts, resonant, shaken

CONTENDER = 1.005  # a face whose best is that near the best of all is worth full convergence
ROUNDS = 5  # fresh runs along a flat valley, at most
POOL = 4  # best candidates that are shaken
SHAKEN = 8  # of these, before the pool is drawn anew
DRAWN = 4  # known devices with a resonator, of which one begins
AROUND = 0.08  # powers of ten, either side of the least damped mode's frequency
SHORT = 10.0  # relative cost of an objective for a damping ratio that is short by 1
RETUNED = 0.1  # standard deviation of the logarithm by which free vehicle parameters are shaken
QUICK, FULL = (150, 1e-6), (1000, 1e-10)  # iterations and tolerance
NEARLY, ON = 1.01, 12  # an independent start that ends so near the best, of so many first ones, goes on
BOXES, WIDEST, NARROWEST = 60, 0.1, 1e-4  # walks of boxes, and their size
RESTS = 1e-9  # relative gain of a full local search that counts as none
GRIDS = 6  # in a row, each made for the best that the one before led to
AGAIN = 24  # candidates measured anew on each


def local(
    search: Incumbent,
    order: int,
    starts: int,
    spring: bool,
    inerter: bool,
    begun: Sequence[Candidate],
    rng: np.random.Generator,
    method: str,
    bases: Sequence[Candidate] = (),
) -> Candidate:
    """The best device of an order that local searches reach.

    Parameters
    ----------
    search : Search
    order, starts : int
        As many starts at random, and as many of the best ones shaken.
    spring, inerter : bool
        Allowed beside the device on top of the order.
    begun : sequence of Candidate
        To start from as well, of at most the order.
    rng : numpy.random.Generator
    method : str
        Named in the history.
    bases : sequence of Candidate
        Of lower order still, to put resonators on.
    """
    search.regrid(replace(search.judge, light=()))
    charts = faces(order, spring=spring, inerter=inerter)
    found: list[Found] = []

    def run(tasks: Sequence[Task]) -> None:
        best = min(found, key=_value)[0] if found else math.inf
        for entry in search.improve(method, tasks):
            found.append(entry)
            if entry[0] < best:
                best = entry[0]
                search.progress(f"order {order}, {len(found)} starts: {best:.6g}")

    run([*_known(charts, begun, rng), *_fresh(search, charts, [search.first, *bases], starts, rng)])
    independent = found[-starts:]
    pool = _distinct(found)[:POOL]
    rest = starts if order else 0
    while rest > 0 and pool:
        chosen = [pool[i % len(pool)] for i in range(min(SHAKEN, rest))]
        run([(chart, _shaken(search, chart, candidate, rng), *QUICK) for _, chart, candidate in chosen])
        pool = _distinct(found)[:POOL]
        rest -= len(chosen)
    _converge(search, charts, found, method)
    if search.judge.floors:
        _walked(search, min(found, key=_value), found, method)
    if method == "ph":
        search.landed += _landed(search, independent, found)
    return min(found, key=_value)[2]


def _known(charts: Sequence[Chart], begun: Sequence[Candidate], rng: np.random.Generator) -> list[Task]:
    """Given candidates: as they are, and with weakly coupled states."""
    tasks: list[Task] = []
    for start in begun:
        chart = _fitting(charts, start.device)
        tasks.append((chart, start, *QUICK))
        if chart.order > start.device.order:
            tasks.append((chart, Candidate(lifted(start.device, chart.order, rng), start.parameters), *QUICK))
    return tasks


def _fresh(
    search: Incumbent, charts: tuple[Chart, ...], bases: Sequence[Candidate], count: int, rng: np.random.Generator
) -> list[Task]:
    """Random devices; where a damping has to be kept, which few do, three of four are known ones with resonators.

    These are proper or end in an inerter by turns. Half of their frequencies go through the decades of
    :data:`.starts.RESONANCES` evenly, half lie about the mode whose damping the known device leaves least, where a
    resonator has most to gain; of a few drawn at each the one that promises most begins.
    """
    tasks: list[Task] = []
    random = random_starts(charts, rng)
    wide = [
        (chart, [base for base in reversed(bases) if base.device.order <= chart.order - 2])
        for chart in charts
        if chart.spring == charts[0].spring and chart.order >= 2
    ]
    low, high = RESONANCES
    for number in range(count):
        chart, device = next(random)
        start = Candidate(device, _retuned(search, search.judge.nominal, rng))
        if search.judge.floors and wide and number % 4:
            chart, fitting = wide[number % len(wide)]
            width = (high - low) / count
            band = (low + number * width, low + (number + 1) * width)
            base = fitting[number // 4 % len(fitting)]
            if number % 8 > 4:
                mode = math.log10(_critical_mode(search, base))
                band = (mode - AROUND, mode + AROUND)
            start = min(
                (_with_resonators(search, chart, base, band, rng) for _ in range(DRAWN)),
                key=lambda candidate: _promise(search, candidate),
            )
        tasks.append((chart, start, *QUICK))
    return tasks


def _with_resonators(
    search: Incumbent, chart: Chart, base: Candidate, band: tuple[float, float], rng: np.random.Generator
) -> Candidate:
    """A known device with resonators, and what the chart has beside it drawn where the device has none."""
    own = base.device
    k, b = 10.0 ** rng.uniform(-2, 0.5, 2)
    inner = PortHamiltonian(own.J, own.G, own.L, (own.k or k) * chart.spring, (own.b or b) * chart.inerter)
    return Candidate(resonant(inner, chart.order, rng, band), _retuned(search, base.parameters, rng))


def _critical_mode(search: Incumbent, base: Candidate) -> float:
    """Natural frequency, over ω0, of the mode that a device leaves least damped."""
    judge = search.judge
    port = judge.problem.mounting.port(judge.scale.admittance(base.device.rational()))
    vehicle = judge.floors[0].vehicle
    mode = least_damping(ClosedVehicle(vehicle, {"secondary": port}), vehicle.random, SEARCH_SPEEDS)
    return 2 * math.pi * mode.frequency / judge.scale.omega


def _promise(search: Incumbent, candidate: Candidate) -> float:
    """The objective, and more where damping is short."""
    short = max(0.0, -search.judge.spare(candidate))
    return search.judge.value(candidate) * (1 + SHORT * short)


def _shaken(search: Incumbent, chart: Chart, candidate: Candidate, rng: np.random.Generator) -> Candidate:
    return Candidate(shaken(chart, candidate.device, rng), _retuned(search, candidate.parameters, rng))


def _retuned(search: Incumbent, values: Mapping[str, float], rng: np.random.Generator) -> dict[str, float]:
    """Free vehicle parameters moved a little, within their ranges."""
    return {
        name: float(np.clip(values[name] * np.exp(RETUNED * rng.standard_normal()), allowed.lower, allowed.upper))
        for name, allowed in search.judge.problem.free.items()
    }


def _converge(search: Incumbent, charts: Sequence[Chart], found: list[Found], method: str) -> None:
    """The best on each face to full convergence, on a grid on which the figure of the best of all is settled."""
    for _ in range(GRIDS):
        _converge_here(search, charts, found, method)
        judge = search.judge.settled(min(found, key=_value)[2])
        if judge is search.judge:
            return
        search.regrid(judge)
        again = _distinct(found)[:AGAIN] or [min(found, key=_value)]  # where no start keeps the constraints yet
        found[:] = [(search.judge.measure(other), chart, other) for _, chart, other in again]


def _converge_here(search: Incumbent, charts: Sequence[Chart], found: list[Found], method: str) -> None:
    """The best on each face that comes near the best of all, again and again until it rests; then off the face."""
    best = min(found, key=_value)[0]
    for chart in charts:
        here = [entry for entry in found if entry[1] == chart and entry[0] <= best * CONTENDER]
        if not here:
            continue
        reached = _rested(search, min(here, key=_value), found, method)
        if chart != charts[0]:
            proper = Candidate(inside(reached.device, charts[0]), reached.parameters)
            _rested(search, (search.judge.measure(proper), charts[0], proper), found, method)


@dataclass(frozen=True)
class _Box(Chart):
    """A chart near a point: each number within `radius` of its size there, of 0.1 at least."""

    centre: tuple[float, ...] = ()
    radius: float = math.inf

    @property
    def bounds(self) -> Any:
        """The box."""
        return [(x - self.radius * max(abs(x), 0.1), x + self.radius * max(abs(x), 0.1)) for x in self.centre]


def _walked(search: Incumbent, start: Found, found: list[Found], method: str) -> float:
    """On from where a full local search stalls, its steps losing the damping: in boxes so small that they do not."""
    value, chart, candidate = start
    radius = WIDEST
    for _ in range(BOXES):
        centre = tuple(chart.vector(candidate.device).tolist())
        box = _Box(chart.order, chart.spring, chart.inerter, centre, radius)
        ((new, _, other),) = search.improve(method, [(box, candidate, *QUICK)])
        if new < value * (1 - RESTS):
            value, candidate, radius = new, other, min(2 * radius, WIDEST)
        else:
            radius /= 4
        if radius < NARROWEST:
            break
    found.append((value, chart, candidate))
    return value


def _landed(search: Incumbent, independent: Sequence[Found], found: list[Found]) -> list[float]:
    """Where independent starts ended: those that came near the best but not to it, after full convergence."""
    best = min(found, key=_value)[0]
    values: list[float] = []
    for number, (value, chart, candidate) in enumerate(sorted(independent, key=_value)):
        if best * AGREED < value <= best * NEARLY and number < ON:
            candidate = _rested(search, (value, chart, candidate), found, "ph")
            value = search.judge.measure(candidate)
            if search.judge.floors and number == 0:
                value = _walked(search, (value, chart, candidate), found, "ph")
        values.append(value)
    return values


def _rested(search: Incumbent, start: Found, found: list[Found], method: str) -> Candidate:
    """Where full local searches, each from where the last one ended, no longer improve."""
    value, chart, candidate = start
    for _ in range(ROUNDS):
        before = value
        ((value, _, candidate),) = search.improve(method, [(chart, candidate, *FULL)])
        found.append((value, chart, candidate))
        if value > before * (1 - RESTS):
            break
    return candidate


def _distinct(found: Sequence[Found]) -> list[Found]:
    """Feasible candidates in order of value, the first of each value and face."""
    kept: list[Found] = []
    for entry in sorted(found, key=_value):
        if math.isfinite(entry[0]) and not any(
            entry[1] == other[1] and abs(entry[0] - other[0]) <= 1e-5 * other[0] for other in kept
        ):
            kept.append(entry)
    return kept


def _value(entry: Found) -> float:
    return entry[0]


def _fitting(charts: Sequence[Chart], device: PortHamiltonian) -> Chart:
    """The chart that holds a device, the one with the most states if there are several."""
    for chart in charts:
        if device.order <= chart.order and (chart.spring or not device.k) and (chart.inerter or not device.b):
            return chart
    raise BadInput(f"a start of order {device.order} does not fit order {charts[0].order}")
