"""Corners of the tolerances: constraints that hold in every vehicle that may be built.

A value p that is built between p (1 − τ) and p (1 + τ) has its logarithm moved by one of two numbers at its ends, so a
corner of the tolerances is the same search at moved coordinates: what is limited there has exact slopes as on the
drawing. There are 2ⁿ corners and few of them matter. A local search is shown those that a design was found to miss,
and goes on until it misses none: cutting sets [MutapcicBoyd2009]. With up to :data:`ALL` corners each is looked at; of
more, those that are reached from the one to which each value points by changing one at a time.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from posreal.errors import BadInput
from posreal.metric import DampingRatio
from posreal.optimisation.coordinates import Coordinates
from posreal.optimisation.damping import Damping
from posreal.optimisation.element_values import ElementValues
from posreal.optimisation.figure import Slopes
from posreal.optimisation.local import AtLeast, AtMost, Damped, Requirement
from posreal.optimisation.problem_figures import figure_of
from posreal.optimisation.scaling import STRUT
from posreal.specification.constraint import ROUNDING, Constraint
from posreal.specification.layout import Layout
from posreal.specification.mounted import NAMES
from posreal.specification.problem import Problem
from posreal.vehicle import override

Array = np.ndarray
Signs = tuple[int, ...]
"""Of each part −1 or +1: built at the lower or the upper end of its tolerance."""

ALL = 128
_INSIDE = 1e-7  # relative room of a limit at a corner, for what the metric's own quadrature sees


@dataclass(frozen=True)
class AtCorner:
    """A requirement where every value is at an end of its tolerance."""

    inner: Requirement
    elements: ElementValues
    factors: Mapping[str, float]

    def margins(self, chart: Coordinates, theta: Array, parameters: Mapping[str, float]) -> Slopes:
        """As of the inner requirement, at the moved values."""
        there = {name: value * self.factors.get(name, 1.0) for name, value in parameters.items()}
        found = self.inner.margins(self.elements, theta, there)
        return Slopes(
            found.values, found.by_theta, {n: slope * self.factors.get(n, 1.0) for n, slope in found.by.items()}
        )


class Corners:
    """Corners of a problem's tolerances for one network.

    Parameters
    ----------
    problem : Problem
        With its tolerances and constraints.
    points : mapping of name to Problem
        The problem at its operating points and, as "", the nominal one.
    layout : Layout
    elements : mapping of the same names to ElementValues
    free : names of the vehicle parameters that are searched

    Raises
    ------
    BadInput
        If nothing is limited, or nothing varies.
    """

    def __init__(
        self,
        problem: Problem,
        points: Mapping[str, Problem],
        layout: Layout,
        elements: Mapping[str, ElementValues],
        free: tuple[str, ...],
    ) -> None:
        assert problem.tolerances is not None
        kept = tuple(one for one in problem.constraints if not one.nominal)
        if not kept:
            raise BadInput(
                f"{problem.name} has no constraint that tolerances could break; limit a metric, such as "
                "--limit static_stiffness=3e5, or look at the spread with posreal tolerance"
            )
        self.constraints, self.points, self.elements, self.free = kept, points, elements, free
        roles = {NAMES[role]: name for role, name in problem.roles.items()}  # springs that a topology's strut has
        whole = not set(roles) & set(layout.network.names)
        of_vehicle = problem.tolerances.of_vehicle(problem, whole=whole)
        own = tuple(name for name in layout.network.names if name not in roles)
        shares = problem.tolerances.of_elements(own)
        shares |= {spring: of_vehicle.pop(name) for spring, name in roles.items() if not whole and name in of_vehicle}
        self.of_elements = {name: share for name, share in shares.items() if share}
        self.of_vehicle = {name: share for name, share in of_vehicle.items() if share}
        if not (self.of_elements or self.of_vehicle):
            raise BadInput("no value has a tolerance; give one above 0")
        self._known: dict[tuple[str, Signs], tuple[Problem, ElementValues]] = {}

    @cached_property
    def count(self) -> int:
        """Values that vary."""
        return len(self.of_elements) + len(self.of_vehicle)

    def factors(self, signs: Signs) -> dict[str, float]:
        """By what every value is multiplied at a corner."""
        shares = {**self.of_elements, **self.of_vehicle}
        return {name: 1 + sign * share for (name, share), sign in zip(shares.items(), signs, strict=True)}

    def _there(self, signs: Signs, point: str) -> tuple[Problem, ElementValues]:
        """The problem and the elements at a corner of an operating point."""
        if (point, signs) not in self._known:
            factors, problem = self.factors(signs), self.points[point]
            settled = {name for name in self.of_vehicle if name not in self.free}
            moved = {name: getattr(problem.vehicle, name) * factors[name] for name in settled}
            there = replace(problem, vehicle=override(problem.vehicle, moved)) if moved else problem
            elements = self.elements[point].scaled({name: factors[name] for name in self.of_elements})
            self._known[point, signs] = there, elements
        return self._known[point, signs]

    def requirement(self, c: Constraint, signs: Signs, speeds: tuple[float, ...], factor: float) -> AtCorner:
        """A constraint at a corner, a damping ratio at some speeds, its limit multiplied by a factor."""
        problem, elements = self._there(signs, c.point)
        limit = c.value * factor * (1 + _INSIDE if c.sense == ">=" else 1 - _INSIDE)
        one: Requirement
        if isinstance(problem.vehicle.metrics[c.base], DampingRatio):
            one = Damped(Damping(problem.vehicle, STRUT, self.free, speeds), limit / 100)
        else:
            figure = figure_of(problem, c.base, STRUT)
            one = (AtMost if c.sense == "<=" else AtLeast)(c.metric, figure, limit)
        return AtCorner(one, elements, self.factors(signs))

    def value(self, c: Constraint, signs: Signs, theta: Array, parameters: Mapping[str, float]) -> float:
        """What a constraint limits, at a corner."""
        problem, elements = self._there(signs, c.point)
        factors = self.factors(signs)
        there = {name: value * factors.get(name, 1.0) for name, value in parameters.items()}
        metric, device = problem.vehicle.metrics[c.base], elements.device(theta)
        with np.errstate(all="ignore"):
            if isinstance(metric, DampingRatio):
                return 100 * float(Damping(problem.vehicle, STRUT, self.free, metric.speeds).least(device, there).min())
            return float(figure_of(problem, c.base, STRUT).values(device, there).max())

    def least_damping(self, c: Constraint, signs: Signs, theta: Array, parameters: Mapping[str, float]) -> Array:
        """The least damping ratio at every speed of the metric, at a corner."""
        problem, elements = self._there(signs, c.point)
        factors = self.factors(signs)
        there = {name: value * factors.get(name, 1.0) for name, value in parameters.items()}
        speeds = self.points[c.point].vehicle.metrics[c.base].speeds  # type: ignore[attr-defined]
        return Damping(problem.vehicle, STRUT, self.free, speeds).least(elements.device(theta), there)

    def worst(
        self, c: Constraint, theta: Array, parameters: Mapping[str, float], start: Signs | None = None
    ) -> tuple[float, Signs]:
        """The worst value of what a constraint limits over the corners, and where."""
        sign = -1.0 if c.sense == ">=" else 1.0
        seen: dict[Signs, float] = {}

        def bad(signs: Signs) -> float:
            if signs not in seen:
                value = sign * self.value(c, signs, theta, parameters)
                seen[signs] = value if np.isfinite(value) else np.inf
            return seen[signs]

        if 2**self.count <= ALL:
            top = max(product((-1, 1), repeat=self.count), key=bad)
        else:
            top = start or self._towards(c, theta, parameters)
            while True:
                beside = [tuple(-s if i == k else s for i, s in enumerate(top)) for k in range(self.count)]
                best = max([top, *beside], key=bad)
                if best == top:
                    break
                top = best
        return sign * seen[top], top

    def _towards(self, c: Constraint, theta: Array, parameters: Mapping[str, float]) -> Signs:
        """The corner to which each value by itself points, with the others as drawn."""
        sign, pointed = -1.0 if c.sense == ">=" else 1.0, []
        for k in range(self.count):
            alone = [tuple(end * (i == k) for i in range(self.count)) for end in (-1, 1)]
            low, high = (sign * self.value(c, signs, theta, parameters) for signs in alone)
            pointed.append(1 if high >= low else -1)
        return tuple(pointed)

    def missed(self, theta: Array, parameters: Mapping[str, float]) -> dict[Constraint, tuple[float, Signs]]:
        """The constraints that do not hold at every corner, with the worst value and its corner."""
        found = {}
        for c in self.constraints:
            value, signs = self.worst(c, theta, parameters)
            short = (c.value - value) * (1 if c.sense == ">=" else -1)
            if not short <= ROUNDING * abs(c.value):
                found[c] = value, signs
        return found

    def look(
        self, theta: Array, parameters: Mapping[str, float], seen: dict[tuple[Constraint, Signs], tuple[float, ...]]
    ) -> tuple[str, bool]:
        """Put the corners that a point misses to those that are `seen`, of a damping ratio with the speeds it misses.

        Returns
        -------
        str
            A sentence about what does not hold; empty if everything does.
        bool
            Whether anything was not seen before.
        """
        reason, news = "", False
        for c, (value, signs) in self.missed(theta, parameters).items():
            reason = f"{c} is violated at a corner of the tolerances: {value:.6g}"
            known, speeds = seen.get((c, signs)), tuple[float, ...]()
            metric = self.points[c.point].vehicle.metrics[c.base]
            if isinstance(metric, DampingRatio):
                every = metric.speeds
                short = np.array(every)[self.least_damping(c, signs, theta, parameters) < c.value / 100]
                first = known or (every[0], every[len(every) // 2], every[-1])
                speeds = tuple(np.union1d(first, short).tolist())
            if known is None or speeds != known:
                seen[c, signs], news = speeds, True
        return reason, news
