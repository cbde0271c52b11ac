"""The objective against a second metric: what a millimetre of deflection costs in comfort, for each number of elements.

    min J   subject to   M ≤ (1 − x) M*,      M* the metric at the best J of a size, x = 2, 5, 10, 20, 30 %

(the ε-constraint method: it finds the whole front, also where it is not convex), over the networks that were best in J
alone. What another design betters in elements, J and M at once is dropped.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from posreal.errors import BadInput, listed, shown
from posreal.network.topologies import Form
from posreal.numerics.parallel import Workers
from posreal.optimisation.caveats import reported
from posreal.optimisation.problem_figures import is_smooth_metric
from posreal.specification.named import limited
from posreal.specification.problem import Problem
from posreal.topology.found import Found, SearchSettings
from posreal.topology.front import designed, ranked
from posreal.topology.result import FrontPoint
from posreal.topology.values import best_values

CANDIDATES = 6  # networks of each size, best in the objective
CUTS = (0.02, 0.05, 0.1, 0.2, 0.3)  # of the metric at the best objective
_STARTS = 2  # random ones, besides the optima in J and in M, between which a design lies


def require_metric(problem: Problem, metric: str) -> None:
    """Refuse a second metric of which there is no smooth figure."""
    known = {name: problem.vehicle.metrics[name] for name in problem.vehicle.headline}
    accepted = [name for name, one in known.items() if is_smooth_metric(one) and name != problem.base_objective]
    if metric not in accepted:
        raise BadInput(f"the objective cannot be traded against {shown(metric)}; it can against {listed(accepted)}")


def tradeoff(
    problem: Problem,
    settings: SearchSettings,
    metric: str,
    points: Sequence[FrontPoint],
    classed: Mapping[Form, Form],
    found: Mapping[Form, Found],
    pool: Workers,
) -> tuple[FrontPoint, ...]:
    """The front in elements, objective and metric, from the front in elements and objective."""
    every = list(points)
    few = replace(settings, starts=min(settings.starts, _STARTS))
    least = replace(problem, objective=metric)
    for point in points:
        best = ranked(point.elements, classed, found)[:CANDIDATES]
        lows = _in_order(pool, [(least, few, one.form, one.values) for one in best])
        tasks = [
            (limited(problem, {metric: (1 - cut) * point.design.metrics[metric].value}), few, one.form, *ends)
            for cut in CUTS
            for one, low in zip(best, lows, strict=True)
            if low.objective < (1 - cut) * point.design.metrics[metric].value
            for ends in [(one.values, low.values)]
        ]
        by_limit: dict[float, list[Found]] = {}
        for (held, *_), one in zip(tasks, _in_order(pool, tasks), strict=True):
            by_limit.setdefault(held.at_most[metric], []).append(one)
        for limit, some in by_limit.items():
            held = limited(problem, {metric: limit})
            good = sorted((one for one in some if one.feasible), key=lambda one: one.objective)
            design = next((d for d in (designed(held, settings, one) for one in good) if d is not None), None)
            if design is not None:
                every.append(FrontPoint(reported(design)))
    return _undominated(every, problem, metric)


def _values(
    index: int, problem: Problem, settings: SearchSettings, form: Form, *warm: tuple[float, ...]
) -> tuple[int, Found]:
    return index, best_values(problem, form, settings, warm)


def _in_order(pool: Workers, tasks: Sequence[tuple[Any, ...]]) -> list[Found]:
    """Results in the order of their tasks, whoever finishes first."""
    numbered = [(index, *task) for index, task in enumerate(tasks)]
    return [result for _, result in sorted(pool.each(_values, numbered), key=lambda pair: pair[0])]


def _undominated(points: Sequence[FrontPoint], problem: Problem, metric: str) -> tuple[FrontPoint, ...]:
    def figures(point: FrontPoint) -> tuple[float, float, float]:
        design = point.design
        return point.elements, design.metrics[problem.objective].value, design.metrics[metric].value

    def beaten(point: FrontPoint) -> bool:
        n, J, M = figures(point)
        return any(
            m <= n and j <= J * (1 + 1e-9) and k <= M * (1 + 1e-9) and (m, j, k) != (n, J, M)
            for m, j, k in map(figures, points)
        )

    kept = [point for point in points if not beaten(point)]
    return tuple(sorted(kept, key=figures))
