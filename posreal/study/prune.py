"""Networks with no more parts than they need: each part opened and shorted in turn, the values improved again.

A synthesised device is the best of its order to the last digit, and its network pays for the last digits with springs
of 90 N/m and inerters of tons. Of all networks with one part less, values at their optimum, the best few go on, as
long as they cost no more than a fraction of the objective over the best figure seen, the device's among them. As values
are free, and like parts merge, a smaller network may have more poles than the device, and a better figure.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

from posreal.admittance.exact import rounded, to_fmpq, to_fraction
from posreal.bounds.guard import guarded
from posreal.errors import BadInput, PosrealError
from posreal.network import Network
from posreal.network.removal import removed
from posreal.optimisation.layout_values import improve, promise
from posreal.specification.design import Design
from posreal.specification.layout import ElementRule, Layout
from posreal.specification.mounted import BUSH, STATIC, mounted
from posreal.specification.problem import Problem

PRUNE = 5e-4  # of the objective
WIDE = 2  # networks of each size that go on
TRIED = 8  # removals whose values are improved, of those that promise most
IDLE = 0.1  # of the fraction: what parts that go before any value is improved may cost
DECADES = 4  # to either side: how far a value may move
DIGITS = (4, 5, 6, 8, 10, 12)  # significant digits of values, tried in turn
ROUNDED = 1e-7  # relative cost of rounding


@dataclass(frozen=True)
class _Built:
    """A network in the device's place, the problem with its vehicle tuned, and the figures."""

    network: Network
    design: Design

    @property
    def value(self) -> float:
        """The objective."""
        return self.design.objective.value


def pruned(
    design: Design, fraction: float = PRUNE, progress: Callable[[str], None] = lambda text: None
) -> Design | None:
    """The smallest network found whose objective is within a fraction of the best.

    Parameters
    ----------
    design : Design
        With a network in the device's place.
    fraction : float
        Of the objective, that leaving out all the parts may cost.
    progress : function of str
        Called with a line for each size.

    Returns
    -------
    Design or None
        With the smaller network, its admittance as the device, and its own figures; None if no part can go.
    """
    assert design.network is not None
    if design.whole or not design.feasible:
        return None
    best = design.objective.value
    level, kept = [_Built(design.network, design)], []
    shed = _without_idle(design, IDLE * fraction)
    if len(shed) < len(design.network):
        improved = _Start(design.problem, shed).improved(design)
        if improved is not None and improved.value <= best * (1 + fraction):
            level, kept = [improved], [improved]
    while level:
        progress(f"leaving out parts of {min(len(built.network) for built in level)}")
        smaller = _smaller(level)
        best = min([best, *(built.value for built in smaller)])
        level = sorted((b for b in smaller if b.value <= best * (1 + fraction)), key=_rank)[:WIDE]
        kept = kept + level
    fitting = [built for built in kept if built.value <= best * (1 + fraction)]
    return _in_few_digits(min(fitting, key=_rank).design) if fitting else None


def with_best_values(design: Design) -> Design | None:
    """A network's design at the local optimum of its values near its own; None if they keep no constraints."""
    assert design.network is not None
    built = _Start(design.problem, design.network).improved(design)
    return None if built is None else built.design


def _without_idle(design: Design, fraction: float) -> Network:
    """The design's network without the parts that may go as it stands, one by one the least missed.

    Where constraints hold a part in its place the objective does not tell; then none goes.
    """
    assert design.network is not None
    network = design.network
    if design.problem.in_its_band.constraints:
        return network
    limit = _Start(design.problem, network).promise * (1 + fraction)
    while True:
        starts = [_Start(design.problem, smaller) for smaller in _removals(network)]
        least = min(starts, key=lambda start: start.promise, default=None)
        if least is None or least.promise > limit:
            return network
        network = least.network


def _removals(network: Network) -> Iterator[Network]:
    """The network with each element opened and shorted; one that dissipates nothing is no suspension."""
    for index, shorted in product(range(len(network)), (False, True)):
        smaller = removed(network, index, shorted=shorted)
        if smaller is not None and smaller.counts.dampers:
            yield smaller


def _rank(built: _Built) -> tuple[int, float]:
    return len(built.network), built.value


@dataclass(frozen=True)
class _Start:
    """A network in the device's place before its values are improved."""

    problem: Problem
    network: Network

    @cached_property
    def layout(self) -> Layout:
        """The strut, its values free but for the bush and a settled static spring."""
        if self.problem.elements is not None:
            raise BadInput("parts are left out, and values improved, of ideal elements")
        strut = mounted(self.problem, self.network)
        return Layout("", strut, "", "", {name: _rule(name, v) for name, v in strut.exact_values().items()}, ())

    @property
    def point(self) -> tuple[dict[str, float], dict[str, float]]:
        """Element values, and the vehicle parameters that are free."""
        values = {name: float(value) for name, value in self.layout.network.exact_values().items()}
        return values, {name: float(getattr(self.problem.vehicle, name)) for name in self.problem.free}

    @cached_property
    def promise(self) -> float:
        """The objective with the values as they are."""
        value = promise(self.problem, self.layout, *self.point)
        return value if math.isfinite(value) else math.inf

    def improved(self, design: Design) -> _Built | None:
        """The network at the optimum of its values, these in few digits; None if it keeps no constraints."""
        try:
            found = improve(self.problem, self.layout, *self.point)
        except PosrealError:
            return None
        if found is None or not found.feasible:
            return None
        tuned = {name: found.parameters.get(name, value) for name, value in self.point[1].items()}
        if self.problem.roles.get("static spring") in tuned:
            tuned[self.problem.roles["static spring"]] = found.parameters[STATIC]
        network = self.network.with_values({name: found.parameters[name] for name in self.network.names})
        measured = _measured(design, self.problem.with_vehicle(tuned), network, tuned)
        return _Built(network, measured) if measured.feasible else None


def _smaller(level: list[_Built]) -> list[_Built]:
    """Networks with a part less, improved: those that promise most as they are."""
    starts: dict[str, _Start] = {}
    for built in level:
        for network in _removals(built.network):
            start = _Start(built.design.problem, network)
            starts.setdefault(f"{len(network)} {start.promise:.9g}", start)  # the same number, the same admittance
    ranked = sorted(starts.values(), key=lambda start: start.promise)[:TRIED]
    found = [start.improved(level[0].design) for start in ranked if start.promise < math.inf]
    return [built for built in found if built is not None]


def _rule(name: str, value: object) -> ElementRule:
    if name == BUSH:
        return ElementRule(fixed="bush")
    if name == STATIC:
        return ElementRule(role="static spring")
    size = float(value)  # type: ignore[arg-type]
    return ElementRule(bounds=(size / 10**DECADES, size * 10**DECADES))


def _in_few_digits(design: Design) -> Design:
    """The design with values of as few significant digits as cost next to nothing."""
    assert design.network is not None
    network, most = design.network, design.objective.value * (1 + ROUNDED)
    for digits in DIGITS:
        values = {name: to_fraction(rounded(to_fmpq(value), digits)) for name, value in network.exact_values().items()}
        short = _measured(design, design.problem, network.with_values(values), design.parameters)
        if short.feasible and short.objective.value <= most:
            return short
    return design


def _measured(design: Design, problem: Problem, network: Network, vehicle: Mapping[str, float]) -> Design:
    device = network.admittance()
    metrics = problem.metrics(problem.port(device))
    return guarded(
        replace(design, problem=problem, device=device, network=network, metrics=metrics, parameters=dict(vehicle))
    )
