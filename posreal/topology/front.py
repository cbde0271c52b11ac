"""From the best values of every topology to the networks worth building.

A topology whose optimum is no better than that of one of its limits is that smaller network. What remains is ranked for
each number of elements, and the best enters the front if it is better than every smaller network. Its figures are
measured by the problem's own metrics, and every topology of as many elements that can have the very same admittance is
listed with the values that do it: those that came to the same optimum, and those that were left out because another
topology does all they can do.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from posreal.errors import PosrealError
from posreal.network import Network
from posreal.network.as_made import made
from posreal.network.topologies import Form, key, letters, valued
from posreal.network.usual import at_ends
from posreal.optimisation.caveats import reported
from posreal.ranges import UsualRanges
from posreal.specification.as_made import ideal_beside
from posreal.specification.design import Design
from posreal.specification.problem import Problem
from posreal.text_table import counted
from posreal.topology.degenerate import limits
from posreal.topology.equivalent import fitted, sample
from posreal.topology.found import NO_GAIN, Found, SearchSettings, generator
from posreal.topology.result import FrontPoint, RunnerUp, Tally
from posreal.topology.values import scale

BETTER = 1e-5  # relative gain that counts: less than this is the optimiser's, not the network's
SAME = 1e-5  # relative difference of optima that may be the same
RUNNERS_UP = 5


def least(form: Form, classed: Mapping[Form, Form], found: Mapping[Form, Found]) -> float:
    """The best figure found for a topology or the one that stands for it; infinite if there is none."""
    one = found.get(classed.get(form, form))
    return math.inf if one is None else one.objective


def least_of_limits(form: Form, classed: Mapping[Form, Form], found: Mapping[Form, Found]) -> float:
    """The best figure among the networks that a topology becomes when one element goes."""
    return min((least(limit.form, classed, found) for limit in limits(form)), default=math.inf)


def reduces(form: Form, classed: Mapping[Form, Form], found: Mapping[Form, Found]) -> bool:
    """Whether a topology's optimum is one of its limits': an element vanishes or locks."""
    smaller = least_of_limits(form, classed, found)
    return math.isfinite(smaller) and found[form].objective >= smaller * (1 - NO_GAIN)


def ranked(size: int, classed: Mapping[Form, Form], found: Mapping[Form, Found]) -> list[Found]:
    """The networks of a size that are no smaller ones in disguise, best first."""
    own = [
        one
        for form, one in found.items()
        if len(letters(form)) == size and one.feasible and not reduces(form, classed, found)
    ]
    return sorted(own, key=lambda one: (one.objective, key(one.form)))


def front(
    problem: Problem,
    settings: SearchSettings,
    classed: Mapping[Form, Form],
    sizes: Sequence[Sequence[Form]],
    found: Mapping[Form, Found],
) -> tuple[FrontPoint, ...]:
    """The best network of each size, if it is better than all smaller ones.

    Parameters
    ----------
    problem : Problem
    settings : Settings
    classed : mapping
        Which topology stands for which.
    sizes : the topologies of one, two, … elements, redundant ones among them
    found : mapping of topology to its best values
    """
    points: list[FrontPoint] = []
    least_yet = math.inf
    for size, everything in enumerate(sizes, 1):
        order = ranked(size, classed, found)
        for place, one in enumerate(order):
            if not one.objective < least_yet * (1 - BETTER):
                break
            design = designed(problem, settings, one)
            if design is None or not design.objective.value < least_yet * (1 - BETTER):
                continue
            point = _with_company(design, one, order[place + 1 :], problem, settings, classed, everything)
            points.append(point)
            least_yet = design.objective.value
            break
    return tuple(points)


def designed(problem: Problem, settings: SearchSettings, one: Found) -> Design | None:
    """What was found for a topology, measured by the problem's own metrics; None if these do not accept it."""
    count = len(letters(one.form))
    bought = valued(one.form, one.values[:count])
    network = made(bought, problem.elements)
    tuned = problem.with_vehicle(dict(zip(problem.free, one.values[count:], strict=True)))
    device = network.admittance()
    try:
        metrics = tuned.metrics(tuned.port(device))
    except PosrealError:  # a vehicle that is not stable, between the speeds or frequencies that were looked at
        return None
    vehicle = {name: float(getattr(tuned.vehicle, name)) for name in problem.free}
    design = Design(
        counted(count, "element"),
        tuned,
        device,
        metrics,
        network=network,
        ideal=ideal_beside(tuned, bought),
        parameters=bought.values() | vehicle,
        found={
            "method": "search over topologies, exact gradients",
            "starts": one.starts,
            "agreed": one.agreed,
            "seed": settings.seed,
            "at_bounds": _at_bounds(bought, settings),
            "notes": _at_usual_ends(bought, problem, settings),
        },
    )
    return design if design.feasible else None


def _at_usual_ends(network: Network, problem: Problem, settings: SearchSettings) -> list[str]:
    """Which values stand at an end of what can be bought, and not at a bound that was given instead."""
    usual = {} if problem.usual is None else problem.usual.by_kind
    inside = {kind: pair for kind, pair in settings.bounds.items() if usual.get(kind) == pair}
    return [f"{said}; --any-values lifts that" for said in at_ends(network, UsualRanges.of_kinds(inside))]


def _at_bounds(network: Network, settings: SearchSettings) -> list[str]:
    """Which values stand at a bound that was given."""
    said = []
    for name, value in network.values().items():
        low, high = settings.bounds.get(name[0], (0.0, math.inf))
        if value <= low * (1 + 1e-6):
            said.append(f"{name} at its lower bound")
        elif value >= high * (1 - 1e-6):
            said.append(f"{name} at its upper bound")
    return said


def _with_company(
    design: Design,
    one: Found,
    after: Sequence[Found],
    problem: Problem,
    settings: SearchSettings,
    classed: Mapping[Form, Form],
    everything: Sequence[Form],
) -> FrontPoint:
    """A point of the front with its equivalents and runners-up."""
    near = {one.form} | {other.form for other in after if other.objective <= one.objective * (1 + SAME)}
    unit = scale(problem)
    points = sample(unit)
    assert design.network is not None
    target = np.asarray(design.network(points))
    equivalent: list[Network] = []
    same: set[Form] = {one.form}
    for form in everything:
        if form == one.form or classed[form] not in near or problem.tolerances is not None:
            continue  # networks of one admittance are not one within tolerances
        values = fitted(form, target, points, unit, generator(settings.seed, form), problem.elements)
        if values is not None and _within(form, values, settings):
            equivalent.append(valued(form, values))
            same.add(form)
    others = [other for other in after if other.form not in same][:RUNNERS_UP]
    return FrontPoint(
        reported(design),
        tuple(equivalent),
        tuple(RunnerUp(valued(o.form, o.values[: len(letters(o.form))]), o.objective) for o in others),
    )


def _within(form: Form, values: Sequence[float], settings: SearchSettings) -> bool:
    """Whether an equivalent network's values are within the bounds that were given."""
    for kind, value in zip(letters(form), values, strict=True):
        low, high = settings.bounds.get(kind, (0.0, math.inf))
        if not low * (1 - 1e-6) <= value <= high * (1 + 1e-6):
            return False
    return True


def tally(size: int, everything: Sequence[Form], classed: Mapping[Form, Form], found: Mapping[Form, Found]) -> Tally:
    """What became of the topologies of one size."""
    kept = [form for form in everything if classed[form] == form]
    possible = [form for form in kept if found[form].feasible]
    return Tally(
        elements=size,
        topologies=len(everything),
        redundant=len(everything) - len(kept),
        reduced=sum(reduces(form, classed, found) for form in possible),
        impossible=len(kept) - len(possible),
    )
