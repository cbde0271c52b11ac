"""Local searches from many starts, the best of these shaken, the best of all to full convergence."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from posreal.admittance import PortHamiltonian
from posreal.design.synthesis.chart import Chart
from posreal.design.synthesis.criterion import Candidate
from posreal.design.synthesis.progress import Found, Search, Task
from posreal.design.synthesis.starts import faces, lifted, random_starts, resonant, shaken
from posreal.errors import BadInput

CONTENDER = 1.005  # a face whose best is that near the best of all is worth full convergence
ROUNDS = 5  # fresh runs along a flat valley, at most
POOL = 4  # best candidates that are shaken
SHAKEN = 8  # of these, before the pool is drawn anew
RETUNED = 0.1  # standard deviation of the logarithm by which free vehicle parameters are shaken
QUICK, FULL = (150, 1e-6), (1000, 1e-10)  # iterations and tolerance


def local(
    search: Search,
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
    charts = faces(order, spring=spring, inerter=inerter)
    found: list[Found] = []

    def run(tasks: Sequence[Task]) -> list[float]:
        first = len(found)
        best = min(found, key=_value)[0] if found else math.inf
        for entry in search.improve(method, tasks):
            found.append(entry)
            if entry[0] < best:
                best = entry[0]
                search.progress(f"order {order}, {len(found)} starts: {best:.6g}")
        return [value for value, _, _ in found[first:]]

    landed = run([*_known(charts, begun, rng), *_fresh(search, charts, [search.first, *bases], starts, rng)])[-starts:]
    pool = _distinct(found)[:POOL]
    rest = starts if order else 0
    while rest > 0 and pool:
        chosen = [pool[i % len(pool)] for i in range(min(SHAKEN, rest))]
        run([(chart, _shaken(search, chart, candidate, rng), *QUICK) for _, chart, candidate in chosen])
        pool = _distinct(found)[:POOL]
        rest -= len(chosen)
    _converge(search, charts, found, method)
    if method == "ph":
        search.landed += landed
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
    search: Search, charts: tuple[Chart, ...], bases: Sequence[Candidate], count: int, rng: np.random.Generator
) -> list[Task]:
    """Random devices; where a damping has to be kept, which few do, two of three are known ones with resonators."""
    tasks: list[Task] = []
    random = random_starts(charts, rng)
    bases = [base for base in bases if base.device.order <= charts[0].order - 2]
    for number in range(count):
        chart, device = next(random)
        parameters: Mapping[str, float] = search.judge.nominal
        if search.judge.least_damping is not None and bases and number % 3:
            base = bases[number // 3 % len(bases)]
            chart, parameters = charts[0], base.parameters
            device = resonant(_within(base.device, chart), chart.order, rng)
        tasks.append((chart, Candidate(device, _retuned(search, parameters, rng)), *QUICK))
    return tasks


def _within(device: PortHamiltonian, chart: Chart) -> PortHamiltonian:
    """The device without the spring or inerter that the chart has no place for."""
    return PortHamiltonian(
        device.J, device.G, device.L, device.k if chart.spring else 0.0, device.b if chart.inerter else 0.0
    )


def _shaken(search: Search, chart: Chart, candidate: Candidate, rng: np.random.Generator) -> Candidate:
    return Candidate(shaken(chart, candidate.device, rng), _retuned(search, candidate.parameters, rng))


def _retuned(search: Search, values: Mapping[str, float], rng: np.random.Generator) -> dict[str, float]:
    """Free vehicle parameters moved a little, within their ranges."""
    return {
        name: float(np.clip(values[name] * np.exp(RETUNED * rng.standard_normal()), allowed.lower, allowed.upper))
        for name, allowed in search.judge.problem.free.items()
    }


def _converge(search: Search, charts: Sequence[Chart], found: list[Found], method: str) -> None:
    """The best on each face that comes near the best of all, again and again until it rests."""
    best = min(found, key=_value)[0]
    for chart in charts:
        here = [entry for entry in found if entry[1] == chart and entry[0] <= best * CONTENDER]
        if not here:
            continue
        value, _, candidate = min(here, key=_value)
        for _ in range(ROUNDS):
            before = value
            ((value, _, candidate),) = search.improve(method, [(chart, candidate, *FULL)])
            found.append((value, chart, candidate))
            if value > before * (1 - 1e-7):
                break


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
