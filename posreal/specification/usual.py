"""What can be bought for a problem's place: a layout held within it, springs that are the vehicle's own."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping

from posreal.errors import BadInput, plain
from posreal.metric import Measured
from posreal.network.usual import Outside
from posreal.ranges import UNITS
from posreal.specification.layout import ElementRule, Layout
from posreal.specification.problem import Problem
from posreal.units import engineering


def out_of_stroke(problem: Problem, metrics: Mapping[str, Measured]) -> list[Outside]:
    """Where the suspension moves further than a device of its place can be bought for."""
    most = None if problem.usual is None else problem.usual.stroke
    if most is None:
        return []
    travels = {name: metrics[name].value / 1e3 for name in problem.place.travels if name in metrics}
    return [Outside(name, value, 0.0, most, "m") for name, value in travels.items() if value > most]


def own_springs(problem: Problem) -> dict[str, float]:
    """The stiffnesses of the vehicle that a strut contains."""
    return {name: float(getattr(problem.vehicle, name)) for name in problem.roles.values()}


def within(layout: Layout, problem: Problem) -> Layout:
    """The layout with its bounds cut to what can be bought for the problem's place.

    Elements that are fixed, or stand for a part of the vehicle, stay as they are.

    Raises
    ------
    BadInput
        If a layout's own bounds leave nothing that can be bought.
    """
    rules = dict(layout.rules)
    for name, low, high in _cut(layout, problem):
        if not low < high:
            usual = dict(problem.usual.by_kind if problem.usual is not None else {})[name[0]]
            said = [engineering(end, UNITS[name[0]]) for end in (*layout.free_elements(problem)[name], *usual)]
            raise BadInput(
                f"layout {plain(layout.name, 40)}: the bounds of {name}, {said[0]} to {said[1]}, leave nothing of what "
                f"can be bought, {said[2]} to {said[3]}; --any-values lifts that, --ranges FILE gives other ranges"
            )
        rules[name] = ElementRule(bounds=(low, high))
    return dataclasses.replace(layout, rules=rules)


def chosen(layout: Layout, problem: Problem) -> list[str]:
    """The elements of a layout that are bought by their value: free ones that are no part of the vehicle."""
    return [name for name, _, _ in _cut(layout, problem)]


def _cut(layout: Layout, problem: Problem) -> Iterator[tuple[str, float, float]]:
    by_kind = {} if problem.usual is None else problem.usual.by_kind
    for name, (low, high) in layout.free_elements(problem).items():
        rule = layout.rules.get(name)
        if name[0] in by_kind and (rule is None or rule.role is None):
            least, greatest = by_kind[name[0]]
            yield name, max(low, least), min(high, greatest)
