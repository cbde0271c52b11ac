"""Best element values of a fixed layout.

    min J(θ, φ)   over the logarithms θ of element values and φ of free vehicle parameters, subject to the constraints

within bounds, by :class:`.element_search.ElementSearch` from the most promising of points spread over the bounds, and
from the default suspension where the layout has it as a limit. What is found is measured by the problem's own metrics.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed

from posreal.errors import Infeasible, PosrealError
from posreal.network.usual import at_ends
from posreal.numerics.threads import one_thread
from posreal.optimisation.both_bands import in_both_bands
from posreal.optimisation.caveats import reported
from posreal.optimisation.element_search import ElementSearch, Point, best_settled, distinct
from posreal.optimisation.mean_square import has_light_modes
from posreal.specification.as_made import ideal_beside, layout_as_made
from posreal.specification.design import Design
from posreal.specification.layout import Layout
from posreal.specification.layout import layout as read_layout
from posreal.specification.named import as_problem
from posreal.specification.problem import Problem
from posreal.specification.usual import chosen, own_springs, within

LOOKED_AT = 4  # ends, where a plant's own modes are light and a grid may not see the closed one's


@one_thread
def optimise(
    problem: Problem | str,
    layout: Layout | str | Path,
    *,
    starts: int = 6,
    seed: int = 0,
    jobs: int = 1,
    any_values: bool = False,
    progress: Callable[[str], None] | None = None,
) -> Design:
    """The best element values of `layout` on `problem` that were found, with free vehicle parameters.

    Of values that can be bought for the place: where the optimum within the layout's own bounds holds one that cannot,
    another one is looked for within the usual ranges as well, and a note says what they cost.

    Parameters
    ----------
    problem : Problem, or the name of one
    layout : Layout, the name of one, or a TOML file
    starts : int
        Local searches, from the best of 128 points spread over the bounds; one more begins at the default suspension
        where the layout has it as a limit.
    seed : int
    jobs : int
        Starts that run side by side (joblib).
    any_values : bool
        Whether values may be any within the layout's own bounds, bought or not.
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
    problem, layout = as_problem(problem), read_layout(layout)
    free = _best(problem, layout, starts, seed, jobs, progress)
    bought = chosen(layout, problem)
    beyond = [str(one) for one in free.outside if one.name in bought]
    if any_values or not beyond:
        return reported(free)
    lifted = f"--any-values lifts that: {free.objective} with {'; '.join(beyond)}"
    here = f"layout {layout.name} of values that can usually be bought for {problem.name}"
    try:
        usual = _best(problem, within(layout, problem), starts, seed, jobs, progress, known=free.parameters)
    except Infeasible as error:
        raise Infeasible(f"{here}: {error}; {lifted}") from None
    ends = at_ends(usual.bought, problem.usual, own=own_springs(problem)) if usual.bought is not None else []
    said = f"{'; '.join(ends)}; {lifted}" if ends else f"only values that can usually be bought; {lifted}"
    return reported(replace(usual, found={**usual.found, "notes": [said]}))


def _best(
    problem: Problem,
    layout: Layout,
    starts: int,
    seed: int,
    jobs: int,
    progress: Callable[[str], None] | None,
    *,
    known: Mapping[str, float] | None = None,
) -> Design:
    """The best found within a layout's bounds, started from `known` values besides."""
    began = time.perf_counter()
    found = in_both_bands(problem, lambda posed: _in_one(posed, layout, starts, seed, jobs, progress, known))
    return replace(found, found={**found.found, "seconds": round(time.perf_counter() - began, 2)})


def _in_one(
    problem: Problem,
    layout: Layout,
    starts: int,
    seed: int,
    jobs: int,
    progress: Callable[[str], None] | None,
    known: Mapping[str, float] | None,
) -> Design:
    """The same, whatever the figure does beyond where it ends, unless that is a constraint."""
    search = ElementSearch(problem, layout)
    default = search.default()
    points = [*search.screened(starts, np.random.default_rng(seed)), *default]
    if known is not None:
        points.append(search.point(known, known))
    run = Parallel(n_jobs=jobs, return_as="generator")(delayed(search.descended)(point) for point in points)
    ends = []
    for number, end in enumerate(run, 1):
        if end is not None:
            ends.append(end)
        if progress is not None:
            reached = "breaks a constraint" if end is None else f"{problem.objective} {end.value:.6g}"
            progress(f"{layout.name}: start {number}/{len(points)}: {reached}")
    several = distinct(ends)
    # a start that breaks a constraint as the figures see it may still keep it where the metrics do
    best, refused = best_settled(several, search.settled, look=LOOKED_AT if has_light_modes(problem) else 1)
    for point in () if best is not None else points:
        best, why = search.settled(point)
        refused = refused or why
        if best is not None:
            break
    kept: list[Design] = []
    for point in [*([best.point] if best is not None else []), *default]:
        if not kept or search.value(point) < kept[0].objective.value:
            with suppress(PosrealError):  # a vehicle that is not stable
                kept += [d for d in [measured(search, point)] if d.feasible and search.holds_at_corners(point)]
    if not kept:
        raise Infeasible(
            f"no values of layout {layout.name} were found that meet the constraints of {problem.name}: {refused}"
        )
    design = min(kept, key=lambda one: one.objective.value)
    agreed = sum(end.value <= several[0].value * 1.001 for end in ends)
    found = {
        "method": "SLSQP on element values, exact gradients",
        "starts": len(points),
        "agreed": agreed,
        "seed": seed,
        "at_bounds": _at_bounds(search, design.parameters),
    }
    return replace(design, found=found)


def measured(search: ElementSearch, point: Point) -> Design:
    """Everything about a point, by the problem's own metrics."""
    return evaluate_layout(search.tuned(point), search.ideal, search.elements.values(point[0]), vehicle=point[1])


def evaluate_layout(
    problem: Problem,
    layout: Layout,
    values: Mapping[str, float],
    *,
    vehicle: Mapping[str, float] | None = None,
) -> Design:
    """A layout at given element values as a design; `vehicle` names tuned parameters for the record."""
    network = layout_as_made(layout, problem).valued(problem, values)
    device = network.admittance()
    metrics = problem.metrics(problem.port(device, whole=True))
    own = layout.valued(problem, {name: value for name, value in values.items() if name in layout.network.names})
    return Design(
        layout.name,
        problem,
        device,
        metrics,
        network=network,
        ideal=ideal_beside(problem, own, whole=True),
        whole=True,
        parameters=own.values() | dict(vehicle or {}),
    )


def _at_bounds(search: ElementSearch, parameters: Mapping[str, float]) -> list[str]:
    """Which values stand at a bound: an element that wants to vanish, to lock, or to be stiffer than allowed."""
    bounds = dict(zip(search.elements.names, search.elements.bounds, strict=True))
    bounds |= {name: (math.log(r.lower), math.log(r.upper)) for name, r in search.free.items()}
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

    def found(posed: Problem) -> Design:
        search = ElementSearch(posed, layout)
        end, why = search.settled(search.point(values, vehicle))
        if end is None:
            raise Infeasible(why)
        return measured(search, end.point)

    try:
        return in_both_bands(problem, found)
    except Infeasible:
        return None


def promise(problem: Problem, layout: Layout, values: Mapping[str, float], vehicle: Mapping[str, float]) -> float:
    """The objective at given values as the search sees it, constraints and stability left out of account."""
    search = ElementSearch(problem, layout)
    return search.value(search.point(values, vehicle))
