"""The best values of one topology: screen many starts, descend from the best few at once, polish the winner.

Screening and descent run on a coarse frequency grid, polishing on a fine one; a winner whose figure is another on a
grid that sees its own modes (`posreal.optimisation.mean_square`) is polished again on that one. Where the open plant is
light itself, a coarse grid may miss a mode of any device, and several of the best are looked at that closely. Besides
random starts there are warm ones: the optimum of each network that this one has as a limit, with the lost element just
short of its border, so that a network is never found worse than its limits. Where the problem has constraints, the
search is that of a layout's values (:mod:`posreal.topology.constrained`); but the figure over all frequencies, that may
be no worse than the default's, is looked at only where it is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from posreal.network.topologies import Form, letters
from posreal.numerics.batched_descent import descend
from posreal.optimisation.mean_square import has_light_modes
from posreal.optimisation.scaling import reference
from posreal.real_elements import RealElements
from posreal.specification.constraint import Constraint, Range
from posreal.specification.problem import Problem
from posreal.topology.batch import Array
from posreal.topology.box import Box
from posreal.topology.constrained import best_constrained_values, settled_values
from posreal.topology.found import NO_GAIN, Found, SearchSettings, generator
from posreal.topology.ground import Ground, Units
from posreal.vehicle import Vehicle

FINE = 12  # panels a decade of the frequency grids
GRIDS = 6  # in a row, each made for the modes of what the one before led to
SETTLED = 1e-6  # relative change of the figure from one grid to the next at which the optimum stays where it is
PENALTIES = (3.0, 300.0)  # in turn, on the square of a limited figure's logarithm
_STIFF = 8  # ends of the mild penalty, the best that differ, to which the stiff one is put
_HUGE = 300.0  # logarithm of a figure that is none
_SCREENED = 64
_LOOKED_AT = 4  # ends of a coarse descent, where a plant's own modes are light


def logarithm(ground: Ground, form: Form) -> Callable[[Array], tuple[Array, Array]]:
    """log J and its gradient: without a unit, and curved about as much as any other problem's."""

    def function(theta: Array) -> tuple[Array, Array]:
        with np.errstate(all="ignore"):
            J, slope = ground.value_and_gradient(form, theta)
            return np.log(J), slope / J[:, None]

    return function


def coarse(problem: Problem) -> Ground:
    """The grid for screening, good for four digits: finer where the vehicle feeds energy in, and modes are lighter."""
    return ground(problem, _panels(problem))


def _panels(problem: Problem) -> int:
    return 4 if problem.vehicle.passive else 8


def is_smooth(problem: Problem) -> bool:
    """Whether a problem is one mean square over a box and no more, for which all starts descend at once.

    What it has to keep over all frequencies is another such mean square.
    """
    return _is_plain(problem) and not problem.in_its_band.constraints and _kind(problem) == "H2"


def _is_plain(problem: Problem) -> bool:
    one = problem.goal is None and not problem.points and len(problem.plant.shares) == 1
    return one and _kind(problem) != "H∞"


def _kind(problem: Problem) -> str:
    norm = problem.vehicle.metrics[problem.objective].norm() if problem.objective in problem.vehicle.metrics else None
    return "" if norm is None else norm.kind


def scale(problem: Problem) -> Units:
    """The units in which values are counted."""
    if _is_plain(problem):
        return coarse(problem).scale
    rough = reference(problem)
    return Units(rough.damper, rough.omega)


def best_values(
    problem: Problem,
    form: Form,
    settings: SearchSettings,
    warm: Sequence[Sequence[float]] = (),
    limit: float = math.inf,
) -> Found:
    """The best values found for a topology.

    Parameters
    ----------
    problem : Problem
    form : Form
    settings : Settings
    warm : sequences of values
        Points to start from besides the random ones.
    limit : float
        The best figure of the topology's limits. What comes out no better than this is not worth polishing.
    """
    box, easier = Box(problem, scale(problem), form, settings), problem.in_its_band
    search = _smooth_values if is_smooth(problem) else _constrained_values
    found = search(easier, form, settings, box, warm, limit)
    if easier is problem or not found.feasible or keeps_twins(problem, form, found):
        return found
    return search(problem, form, settings, box, [*warm, found.values], limit)


def _constrained_values(
    problem: Problem,
    form: Form,
    settings: SearchSettings,
    box: Box,
    warm: Sequence[Sequence[float]],
    limit: float,
) -> Found:
    return best_constrained_values(problem, form, settings, box, warm, limit, _panels(problem))


def _smooth_values(
    problem: Problem,
    form: Form,
    settings: SearchSettings,
    box: Box,
    warm: Sequence[Sequence[float]],
    limit: float,
) -> Found:
    if problem.constraints:
        return _within_limits(problem, form, settings, box, warm, limit)
    rough = coarse(problem)
    starts = screened(rough, form, box, settings, warm)
    theta, value = descend(logarithm(rough, form), starts, box.lower, box.upper)
    best = int(np.argmin(value))
    agreed = int(np.sum(value[: settings.starts] <= value[best] + 1e-3))
    point = theta[best]
    if has_light_modes(problem):
        ends = [polished(problem, form, box, theta[i]) for i in apart(value)[:_LOOKED_AT]]
        point, figure = min(ends, key=lambda end: end[1])
        return Found(form, figure, tuple(np.exp(point).tolist()), agreed, settings.starts)
    figure = float(ground(problem, FINE).value_and_gradient(form, point[None, :])[0][0])
    if figure < limit * (1 - NO_GAIN):
        point, figure = polished(problem, form, box, point)
    return Found(form, figure, tuple(np.exp(point).tolist()), agreed, settings.starts)


def keeps_twins(problem: Problem, form: Form, found: Found) -> bool:
    """Whether what was found for a problem in its band is no worse than the default over all frequencies, as a fine
    grid sees it."""
    theta = np.log(np.array(found.values))[None, :]
    return all(
        float(_at(problem, c, FINE).value_and_gradient(form, theta)[0][0]) <= c.value
        for c in problem.constraints
        if c.base in problem.twins
    )


def _within_limits(
    problem: Problem,
    form: Form,
    settings: SearchSettings,
    box: Box,
    warm: Sequence[Sequence[float]],
    limit: float,
) -> Found:
    """The best values where other mean squares are limited: a growing penalty, then the limits as they are measured."""
    if "c" not in letters(form) and problem.elements is None:
        # what rings above the objective's band has nothing to ring less by
        return Found(form, math.inf, (), 0, settings.starts)
    rough = ground(problem, _panels(problem))
    limits = [(_at(problem, c, _panels(problem)), c.value) for c in problem.constraints]
    starts = screened(rough, form, box, settings, warm)
    mild, stiff = (penalised(rough, limits, form, weight) for weight in PENALTIES)
    theta, value = descend(mild, starts, box.lower, box.upper, iterations=60, tolerance=1e-4)
    agreed = int(np.sum(value[: settings.starts] <= value.min() + 1e-3))
    theta, value = descend(stiff, theta[apart(value)[:_STIFF]], box.lower, box.upper)
    ends = [(math.exp(min(value[i], _HUGE)), np.exp(theta[i]).tolist()) for i in apart(value)]
    default = problem.default_metrics
    worth = limit if default is None else min(limit, default[problem.objective].value)
    if ends[0][0] >= worth * (1 - NO_GAIN):
        return Found(form, ends[0][0], tuple(ends[0][1]), agreed, settings.starts)
    settled = settled_values(problem, form, box, ends)
    if settled is None:
        return Found(form, math.inf, (), 0, settings.starts)
    return Found(form, *settled, agreed, settings.starts)


def penalised(
    ground: Ground, limits: Sequence[tuple[Ground, float]], form: Form, weight: float
) -> Callable[[Array], tuple[Array, Array]]:
    """log J and `weight` times the squares of how much too large the logarithms of other figures are."""
    plain = logarithm(ground, form)
    others = [(logarithm(other, form), math.log(most)) for other, most in limits]

    def function(theta: Array) -> tuple[Array, Array]:
        value, slope = plain(theta)
        for other, most in others:
            figure, steep = other(theta)
            over = np.maximum(figure - most, 0.0)
            value, slope = value + weight * over**2, slope + 2 * weight * over[:, None] * steep
        return value, slope

    return function


def _at(problem: Problem, constraint: Constraint, panels: int) -> Ground:
    """The ground of a limited mean square, at its operating point."""
    there = problem.at_points[constraint.point] if constraint.point else problem
    return _ground(there.vehicle, constraint.base, tuple(problem.free.items()), problem.elements, panels)


def apart(value: Array) -> list[int]:
    """Which of some logarithms of figures differ by more than 1e-4, the least first."""
    kept: list[int] = []
    for i in np.argsort(value, kind="stable").tolist():
        if np.isfinite(value[i]) and (not kept or value[i] > value[kept[-1]] + 1e-4):
            kept.append(i)
    return kept or [int(np.argmin(value))]


def screened(ground: Ground, form: Form, box: Box, settings: SearchSettings, warm: Sequence[Sequence[float]]) -> Array:
    """The best of many random points, and the warm ones."""
    points = box.random(max(_SCREENED, settings.starts), generator(settings.seed, form))
    value, _ = logarithm(ground, form)(points)
    chosen = points[np.argsort(np.where(np.isfinite(value), value, np.inf), kind="stable")[: settings.starts]]
    if not warm:
        return chosen
    return np.vstack([chosen, np.clip(np.log(np.array(warm)), box.lower, box.upper)])


def polished(problem: Problem, form: Form, box: Box, theta: Array) -> tuple[Array, float]:
    """A minimum on a grid that sees its modes, and its figure."""
    here = ground(problem, FINE)
    for _ in range(GRIDS):
        found, value = descend(
            logarithm(here, form), theta[None, :], box.lower, box.upper, iterations=60, tolerance=1e-9
        )
        theta, figure = found[0], math.exp(float(value[0]))
        here = here.closer(form, theta)
        finer = float(here.value_and_gradient(form, theta[None, :])[0][0])
        if abs(finer - figure) <= SETTLED * figure:
            break
    return theta, finer


def ground(problem: Problem, panels: int) -> Ground:
    """The ground of a problem, kept: every topology of a search stands on the same one."""
    return _ground(problem.vehicle, problem.objective, tuple(problem.free.items()), problem.elements, panels)


@lru_cache(maxsize=32)
def _ground(
    vehicle: Vehicle, objective: str, free: tuple[tuple[str, Range], ...], elements: RealElements | None, panels: int
) -> Ground:
    return Ground(Problem("", "", vehicle, objective, free=dict(free), elements=elements), panels, trimmed=True)
