"""The objective against a second metric: what a millimetre of deflection costs in comfort, for each number of elements.

    min J   subject to   M ≤ M_j,      M_j from the least M that a size reaches to the M of its best J

(the ε-constraint method: it finds the whole front, also where it is not convex), over the networks that were best in J
alone and over those that are best in M. What another design betters in elements, J and M at once is dropped.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from posreal.design.problem import Problem
from posreal.design.search.front import designed, ranked
from posreal.design.search.ground import mean_square_metrics
from posreal.design.search.restrict import restricted
from posreal.design.search.result import FrontPoint
from posreal.design.search.topologies import Form
from posreal.design.search.values import Found, Settings, best_values
from posreal.design.search.workers import Workers
from posreal.errors import BadInput, listed

CANDIDATES = 6  # networks of each size, best in the objective
LEVELS = (0.0, 0.25, 0.5, 0.75)  # of the way from the least of the metric to its value at the best objective
_STARTS = 2  # random ones, besides the two ends of the front between which a design lies
_SLACK = 1e-4  # relative, above the least value, at which there is still something to choose


def require_metric(problem: Problem, metric: str) -> None:
    """Refuse a second metric of which there is no smooth figure."""
    accepted = [name for name in mean_square_metrics(problem) if name != problem.objective]
    if metric not in accepted:
        raise BadInput(f"the objective cannot be traded against {metric!r}; it can against {listed(accepted)}")


def tradeoff(
    problem: Problem,
    settings: Settings,
    metric: str,
    points: Sequence[FrontPoint],
    classed: Mapping[Form, Form],
    found: Mapping[Form, Found],
    pool: Workers,
) -> tuple[FrontPoint, ...]:
    """The front in elements, objective and metric, from the front in elements and objective."""
    every = list(points)
    settings = replace(settings, starts=min(settings.starts, _STARTS))
    for point in points:
        best = ranked(point.elements, classed, found)[:CANDIDATES]
        other = replace(problem, objective=metric)
        lows = [
            one
            for task in pool.each(_values, [(other, settings, one.form, one.values) for one in best])
            for one in task
        ]
        reached = min((one.objective for one in lows if one.feasible), default=None)
        top = point.design.metrics[metric].value
        if reached is None or reached >= top * (1 - _SLACK):
            continue
        starts = {one.form: one.values for one in lows}
        tasks = []
        for level in LEVELS:
            limit = reached * (1 + _SLACK) + level * (top - reached)
            held = restricted(problem, {metric: limit})
            tasks += [(held, settings, one.form, one.values, starts.get(one.form, ())) for one in best]
        by_limit: dict[float, list[Found]] = {}
        for (held, *_), some in zip(tasks, _in_order(pool, tasks), strict=True):
            by_limit.setdefault(held.constraints[-1].value, []).extend(some)
        for limit, some in sorted(by_limit.items()):
            for one in sorted((one for one in some if one.feasible), key=lambda one: one.objective):
                design = designed(restricted(problem, {metric: limit}), settings, one)
                if design is not None:
                    every.append(FrontPoint(replace(design, problem=problem)))
                    break
    return _undominated(every, problem, metric)


def _values(problem: Problem, settings: Settings, form: Form, *warm: tuple[float, ...]) -> list[Found]:
    return [best_values(problem, form, settings, [values for values in warm if values])]


def _indexed(index: int, task: tuple[Any, ...]) -> tuple[int, list[Found]]:
    return index, _values(*task)


def _in_order(pool: Workers, tasks: Sequence[tuple[Any, ...]]) -> list[list[Found]]:
    """Results in the order of their tasks, whoever finishes first."""
    return [result for _, result in sorted(pool.each(_indexed, list(enumerate(tasks))), key=lambda pair: pair[0])]


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
