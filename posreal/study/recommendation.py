"""The network to build: everything that is known of a problem, put together into one recommendation.

What ends at 20 Hz is designed over all frequencies: what is built rings above, too. Of the networks found, of values
that can usually be bought and with what real elements bring with them, the smallest within a few parts in a hundred of
the best is the one to build, its values rounded to what a maker is asked for. What it reaches, what no device could,
what tolerances leave of it, and what the next part would buy stand beside it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from posreal.admittance.exact import rounded, to_fmpq, to_fraction
from posreal.errors import BadInput, Infeasible, PosrealError, shown
from posreal.network import Network
from posreal.network.as_made import made
from posreal.network.usual import outside
from posreal.optimisation.caveats import reported
from posreal.optimisation.evaluate import evaluate
from posreal.specification.design import Design
from posreal.specification.mounted import mounted
from posreal.specification.named import as_problem
from posreal.specification.problem import WORST_CASE, Problem
from posreal.study.compare import Comparison, compare
from posreal.study.tolerance import DRAWS, tolerance
from posreal.study.tolerance_result import Tolerance
from posreal.topology.result import FrontPoint, Search
from posreal.topology.search import search
from posreal.vehicle import whole_band_twin

WITHIN = 0.01  # of the best figure: what a smaller network may cost
ELEMENTS = 4
DIGITS = (3, 4, 5, 6)  # significant ones of a value that is ordered, tried in turn
ROUNDING = 1e-3  # of the objective: what rounding may cost
_MOST_CORNERS = 2**7  # ways of rounding up and down that are tried


@dataclass(frozen=True, repr=False)
class Recommendation:
    """The network to build for a problem, and what it is held against.

    Attributes
    ----------
    problem : Problem
        As it was solved: over all frequencies, unless it was asked to its own band only.
    asked : Problem
    comparison : Comparison
        The default suspension, the layouts at their optima, synthesised devices, and the bound.
    search : Search
        The networks of values that can usually be bought, by number of elements.
    within : float
        Of the best figure, that a smaller network may cost.
    recommended : Design
        With its network, values rounded.
    tolerance : Tolerance
        What tolerances leave of it.
    """

    problem: Problem
    asked: Problem
    comparison: Comparison
    search: Search
    within: float
    recommended: Design
    tolerance: Tolerance

    @property
    def network(self) -> Network:
        """The network in the device's place, as it is ordered."""
        return _bought(self.recommended)

    @property
    def strut(self) -> Network:
        """The network with the bush or the static spring that the vehicle has there."""
        return mounted(self.recommended.problem, self.network)

    @property
    def above_best_percent(self) -> float:
        """By how many per cent it is above the best network found."""
        return 100 * (self.recommended.objective.value / self.search.best.objective.value - 1)

    @property
    def above_reached_percent(self) -> float | None:
        """By how many per cent it is above what a passive device of high order is known to reach."""
        bound = self.comparison.bound
        if bound is None or bound.attained is None:
            return None
        return 100 * (bound.figure.measure(self.recommended.port) / bound.attained.value - 1)

    @property
    def gap_percent(self) -> float | None:
        """By how many per cent the proven bound is below it."""
        return self.comparison.gap(self.recommended)

    @property
    def larger(self) -> list[tuple[FrontPoint, float]]:
        """Networks of more elements, and by how many per cent each is better than this one."""
        mine = self.recommended.objective.value
        return [
            (point, 100 * (1 - point.design.objective.value / mine))
            for point in self.search.front
            if point.elements > len(self.network)
        ]

    def __repr__(self) -> str:
        return f"<Recommendation for {self.problem.name}: {self.recommended.objective}, {self.network}>"

    def __str__(self) -> str:
        return self.text()

    def text(self, *, ascii: bool = False) -> str:
        """Everything as text, the network to build last."""
        from posreal.study.recommendation_text import text

        return text(self, ascii=ascii)

    def html(self) -> str:
        """Everything as one self-contained page; see :mod:`.report`."""
        from posreal.study.report import page

        return page(self)

    def _repr_html_(self) -> str:
        from posreal.study.report import body

        return body(self)

    def to_dict(self) -> dict[str, Any]:
        """JSON-able."""
        compared = self.comparison.to_dict()
        return {
            "problem": self.problem.name,
            "objective": self.problem.objective,
            "rows": compared["rows"],
            "front": [point.to_dict() for point in self.search.front],
            "bound": compared["bound"],
            "recommended": self.recommended.to_dict()
            | {
                "network": {
                    "notation": str(self.network),
                    "strut": str(self.strut),
                    "elements": self.network.counts._asdict(),
                }
            },
            "within_percent": 100 * self.within,
            "above_best_percent": self.above_best_percent,
            "above_reached_percent": self.above_reached_percent,
            "gap_percent": self.gap_percent,
            "larger": [{**point.to_dict(), "better_percent": gain} for point, gain in self.larger],
            "tolerance": self.tolerance.to_dict(),
            "notes": list(self.comparison.notes),
        }


def design(
    problem: Problem | str,
    *,
    elements: int = ELEMENTS,
    orders: Sequence[int] = (1, 2),
    within: float = WITHIN,
    any_values: bool = False,
    ideal: bool = False,
    draws: int = DRAWS,
    seed: int = 0,
    jobs: int = 1,
    progress: Callable[[str], None] = lambda text: None,
) -> Recommendation:
    """The network to build for a problem: the smallest within `within` of the best found.

    Parameters
    ----------
    problem : Problem, or the name of one
        Where its objective ends at 20 Hz the design is over all frequencies, unless it is `band_only`.
    elements : int
        The most elements that are searched, bush or static spring not counted.
    orders : sequence of int
        Orders of the synthesised devices that stand beside.
    within : float
        Fraction of the best figure found that a smaller network may cost.
    any_values : bool
        Whether values that cannot usually be bought for the place are searched too.
    ideal : bool
        Whether elements are ideal ones; else they are the real ones of the problem or of the place, where it has any.
    draws : int
        Vehicles drawn within tolerances.
    seed, jobs : int
    progress : function of str

    Returns
    -------
    Recommendation

    Raises
    ------
    BadInput
        For a fraction that is none.
    Infeasible
        If no network was found that keeps the constraints.
    """
    asked = as_problem(problem)
    if not 0 <= within < 1:
        raise BadInput(f"within is {shown(within)}; give a fraction of the best figure from 0 to below 1, such as 0.01")
    posed = replace(over_all_frequencies(asked), elements=None if ideal else asked.elements or asked.place.elements)
    found = search(posed, elements, any_values=any_values, seed=seed, jobs=jobs, progress=progress)
    found.require_any()
    comparison = compare(replace(posed, elements=None), orders=orders, seed=seed, jobs=jobs, progress=progress)
    progress("rounding values to what can be ordered")
    chosen = ordered(smallest(found, within))
    progress("drawing vehicles within tolerances")
    spread = tolerance(chosen, draws=draws, seed=seed, jobs=jobs, progress=progress)
    if comparison.bound is not None:
        comparison.bound.require_not_below(chosen)
    return Recommendation(posed, asked, comparison, found, within, chosen, spread)


def over_all_frequencies(problem: Problem) -> Problem:
    """The problem whose objective does not end at 20 Hz; itself, if it ends nowhere or was asked to end there."""
    twin = whole_band_twin(problem.vehicle, problem.base_objective)
    if twin is None or problem.goal is not None or problem.band_only:
        return problem
    return replace(problem, objective=WORST_CASE + twin if problem.points else twin)


def smallest(found: Search, within: float) -> Design:
    """The network of fewest elements that is near enough to the best."""
    most = found.best.objective.value * (1 + within)
    near = [point for point in found.front if point.design.objective.value <= most]
    return min(near, key=lambda point: (point.elements, point.design.objective.value)).design


def ordered(design: Design, digits: Sequence[int] = DIGITS) -> Design:
    """The design with values of few significant digits, as a maker is asked for them.

    The nearest ones are taken if they keep the constraints and cost next to nothing; else values are rounded up and
    down in every way, and the best way that keeps the constraints is taken; else there is a digit more.

    Raises
    ------
    Infeasible
        If the design itself does not keep its constraints.
    """
    if not design.feasible:
        raise Infeasible(design.problem.violated(design.metrics)[0])
    most, beyond = design.objective.value * (1 + ROUNDING), {one.name for one in design.outside}
    for count in digits:
        nearest, *others = _ways(_bought(design), count)
        for values in [nearest, *_promising(design, others, most, beyond)]:
            found = _with(design, _bought(design).with_values(values))
            if found is None or not found.feasible or found.objective.value > most:
                continue
            if {one.name for one in found.outside} <= beyond:
                return reported(found)
    return design


def _ways(network: Network, digits: int) -> list[dict[str, Fraction]]:
    """Values of so many digits: the nearest, then every one up or down, if these are not too many."""
    exact = network.exact_values()
    nearest = {name: to_fraction(rounded(to_fmpq(value), digits)) for name, value in exact.items()}
    if 2 ** len(exact) > _MOST_CORNERS:
        return [nearest]
    ends: list[tuple[Fraction, ...]] = []
    for name, value in exact.items():
        step = Fraction(10) ** (math.floor(math.log10(float(value))) + 1 - digits)
        low = Fraction(math.floor(value / step)) * step
        ends.append((nearest[name],) if low == value else (low, low + step))
    return [nearest, *(dict(zip(exact, way, strict=True)) for way in itertools.product(*ends))]


def _promising(
    design: Design, ways: Sequence[Mapping[str, Fraction]], most: float, beyond: set[str]
) -> list[Mapping[str, Fraction]]:
    """Of ways to round those that keep everything as one method sees it, the best few first."""
    seen: list[tuple[float, int]] = []
    problem = design.problem
    for number, values in enumerate(ways):
        network = _bought(design).with_values(values)
        if {one.name for one in outside(network, problem.usual)} - beyond:
            continue
        port = problem.port(made(network, problem.elements).admittance())
        try:
            metrics = problem.metrics(port, confirmed=False)
        except PosrealError:
            continue
        value = metrics[problem.objective].value
        if value <= most and not problem.violated(metrics):
            seen.append((value, number))
    return [ways[number] for _, number in sorted(seen)[:3]]


def _with(design: Design, network: Network) -> Design | None:
    try:
        found = evaluate(design.problem, network, label=design.label)
    except PosrealError:  # a vehicle that is not stable
        return None
    kept = {name: value for name, value in design.found.items() if name != "notes"}
    return replace(found, parameters={**design.parameters, **network.values()}, found=kept)


def _bought(design: Design) -> Network:
    network = design.bought
    assert network is not None
    return network
