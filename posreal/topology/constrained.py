"""The best values of one topology where something must hold, or where the objective is no single mean square.

A topology in its place is a layout: the strut with the vehicle's own spring in it. Its values are found as a layout's
are (:mod:`posreal.optimisation.element_search`), from random starts about the vehicle's units and from the optima of
its limits, on coarse grids first.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from posreal.network.topologies import Form, letters, network
from posreal.optimisation.element_search import ElementSearch, End, Point, best_settled, distinct
from posreal.optimisation.mean_square import has_light_modes
from posreal.specification.layout import ElementRule, Layout
from posreal.specification.mounted import BUSH, STATIC, mounted
from posreal.specification.problem import Problem
from posreal.topology.box import Box
from posreal.topology.found import NO_GAIN, Found, SearchSettings, generator

_SCREENED = 64
_SETTLED = 3  # ends that are settled before a topology is given up
_LOOKED_AT = 4  # where a plant's own modes are light


class InPlace:
    """A topology in a problem's place.

    Parameters
    ----------
    problem : Problem
    form : Form
    box : Box
        Of the unknowns: logarithms of element values in the form's order, then of free vehicle parameters.
    """

    def __init__(self, problem: Problem, form: Form, box: Box) -> None:
        self.problem, self.box = problem, box
        inner = network(form)
        self.names = inner.names
        strut = mounted(problem, inner)
        bounds = np.exp([box.lower, box.upper]).T.tolist()
        rules = {name: ElementRule(bounds=(low, high)) for name, (low, high) in zip(self.names, bounds, strict=False)}
        rules |= {name: rule for name, rule in _RULES.items() if name in strut.names}
        self.layout = Layout("", strut, "", "", rules, ())
        self._tied = problem.roles.get("static spring", "")

    def within(self, search: ElementSearch) -> tuple[np.ndarray, np.ndarray]:
        """Where random starts lie, in the order of the search's unknowns."""
        at = dict(zip((*self.names, *self.problem.free), zip(self.box.low, self.box.high, strict=True), strict=True))
        ends = np.array([at[self._tied if name == STATIC else name] for name in search.elements.names])
        return ends[:, 0], ends[:, 1]

    def point(self, search: ElementSearch, values: Sequence[float]) -> Point:
        """Where values in the form's order lie, free vehicle parameters behind them."""
        named = dict(zip((*self.names, *self.problem.free), values, strict=True))
        if self._tied in self.problem.free:
            named[STATIC] = named[self._tied]
        return search.point(named, named)

    def values(self, search: ElementSearch, point: Point) -> tuple[float, ...]:
        """The values at a point, in that order."""
        found = search.elements.values(point[0]) | point[1]
        if self._tied in self.problem.free:
            found[self._tied] = found[STATIC]
        return tuple(float(found[name]) for name in (*self.names, *self.problem.free))


_RULES = {BUSH: ElementRule(fixed="bush"), STATIC: ElementRule(role="static spring")}


def require_figures(problem: Problem) -> None:
    """Refuse an objective or a limit on a metric of which a search has no smooth figure.

    Raises
    ------
    BadInput
    """
    strut = mounted(problem, network("c"))
    ElementSearch(problem, Layout("", strut, "", "", {k: v for k, v in _RULES.items() if k in strut.names}, ()))


def settled_values(
    problem: Problem, form: Form, box: Box, ends: Sequence[tuple[float, Sequence[float]]]
) -> tuple[float, tuple[float, ...]] | None:
    """The figure and the values of the best of some ends (figure, values) that keeps its constraints as measured.

    Parameters
    ----------
    ends : in ascending order; the first few are gone to, until one is kept that the next cannot win over
    """
    there = InPlace(problem, form, box)
    fine = ElementSearch(problem, there.layout)
    points = [End(value, there.point(fine, values)) for value, values in ends[:_SETTLED]]
    best, _ = best_settled(points, fine.settled)
    return None if best is None else (best.value, there.values(fine, best.point))


def best_constrained_values(
    problem: Problem,
    form: Form,
    settings: SearchSettings,
    box: Box,
    warm: Sequence[Sequence[float]],
    limit: float,
    panels: int,
) -> Found:
    """As :func:`posreal.topology.values.best_values`, whatever the objective and the constraints.

    `panels` a decade have the grids on which starts descend.
    """
    there = InPlace(problem, form, box)
    coarse = ElementSearch(problem, there.layout, panels=panels)
    starts = coarse.screened(
        settings.starts, generator(settings.seed, form), max(_SCREENED, settings.starts), there.within(coarse)
    )
    starts += [there.point(coarse, values) for values in warm]
    fine = ElementSearch(problem, there.layout)
    if "c" not in letters(form):  # the vehicle may have all the damping that it needs, or none at all
        first = coarse.descended(starts[0], iterations=60, tolerance=1e-7)
        if first is not None and fine.is_undamped(first.point):
            return Found(form, math.inf, (), 0, settings.starts)
    reached = [coarse.descended(start, iterations=60, tolerance=1e-7) for start in starts]
    ends = [End(fine.value(end.point), end.point) if end is not None else None for end in reached]
    several = distinct([end for end in ends if end is not None])
    if not several:
        return Found(form, math.inf, (), 0, settings.starts)
    agreed = sum(end is not None and end.value <= several[0].value * 1.001 for end in ends[: settings.starts])
    light = has_light_modes(problem)
    if not light and several[0].value >= limit * (1 - NO_GAIN):
        # fewer speeds are watched here than there are, and still it is no better than its limit
        return Found(form, several[0].value, there.values(fine, several[0].point), agreed, settings.starts)
    best, _ = best_settled(several[:_SETTLED], fine.settled, look=_LOOKED_AT if light else 1)
    if best is None:
        return Found(form, math.inf, (), 0, settings.starts)
    return Found(form, best.value, there.values(fine, best.point), agreed, settings.starts)
