"""The best values of one topology: screen many starts, descend from the best few at once, polish the winner.

Screening and descent run on a coarse frequency grid, polishing on a fine one; a winner whose figure is another on a
grid that sees its own modes (`posreal.optimisation.mean_square`) is polished again on that one. Where the open plant is
light itself, a coarse grid may miss a mode of any device, and several of the best are looked at that closely. Besides
random starts there are warm ones: the optimum of each network that this one has as a limit, with the lost element just
short of its border, so that a network is never found worse than its limits. Where the problem has constraints, the
polishing is done by SLSQP with the constraints of :mod:`posreal.topology.lateral`.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from posreal.network.topologies import Form, key, letters
from posreal.numerics.batched_descent import descend
from posreal.optimisation.mean_square import NARROW
from posreal.plant import hinf_norm
from posreal.specification.problem import Problem
from posreal.topology.batch import Array
from posreal.topology.ground import Ground

FINE = 12  # panels a decade of the frequency grids
GRIDS = 6  # in a row, each made for the modes of what the one before led to
NO_GAIN = 1e-5  # relative gain over a limit below which a network is that limit
SETTLED = 1e-7  # relative change of the figure from one grid to the next that counts as none
DECADES = 6.0  # to either side of the vehicle's units: how far free values may run
SPREAD = 2.0  # decades to either side: where random starts lie
_SCREENED = 64
_LOOKED_AT = 4  # ends of a coarse descent, where a plant's own modes are light


@dataclass(frozen=True)
class Settings:
    """What, besides the problem and the topology, decides what is found.

    Attributes
    ----------
    starts : int
        Random starts from which a topology is optimised, the best of 64.
    seed : int
    bounds : mapping of "k", "c", "b" to (lower, upper)
        In N/m, N s/m and kg; a kind that is missing is free.
    """

    starts: int
    seed: int = 0
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class Found:
    """The best values found for a topology.

    Attributes
    ----------
    form : Form
    objective : float
        In the metric's unit; infinite if no values were found that meet the constraints.
    values : tuple of float
        Of the elements in the form's order, then of the problem's free vehicle parameters, SI units.
    agreed, starts : int
        How many of the random starts led to the same figure within 0.1 %.
    """

    form: Form
    objective: float
    values: tuple[float, ...]
    agreed: int
    starts: int

    @property
    def feasible(self) -> bool:
        """Whether there is a point at all."""
        return math.isfinite(self.objective)


class Box:
    """Bounds of a topology's unknowns, and where its starts lie; all logarithms."""

    def __init__(self, ground: Ground, form: Form, settings: Settings) -> None:
        kinds = letters(form)
        unit = np.log(ground.scale.units(kinds))
        free = math.log(10.0) * DECADES
        spread = math.log(10.0) * SPREAD
        lower, upper = unit - free, unit + free
        for i, kind in enumerate(kinds):
            if kind in settings.bounds:
                lower[i], upper[i] = np.log(settings.bounds[kind])
        ranges = [ground.problem.free[name] for name in ground.vehicle_names]
        self.lower = np.concatenate([lower, np.log([r.lower for r in ranges])])
        self.upper = np.concatenate([upper, np.log([r.upper for r in ranges])])
        # starts lie about the units, or at whatever part of the bounds is nearest to that
        self.low = np.concatenate([np.clip(unit - spread, lower, upper), self.lower[len(kinds) :]])
        self.high = np.concatenate([np.clip(unit + spread, lower, upper), self.upper[len(kinds) :]])

    def random(self, count: int, rng: np.random.Generator) -> Array:
        """Random starts."""
        return self.low + rng.uniform(size=(count, len(self.low))) * (self.high - self.low)


def generator(seed: int, form: Form) -> np.random.Generator:
    """The random numbers of a topology: the same whichever process draws them, and in whatever order."""
    digest = hashlib.sha256(key(form).encode()).digest()
    return np.random.default_rng([seed, int.from_bytes(digest[:8], "little")])


def logarithm(ground: Ground, form: Form) -> Callable[[Array], tuple[Array, Array]]:
    """log J and its gradient: without a unit, and curved about as much as any other problem's."""

    def function(theta: Array) -> tuple[Array, Array]:
        with np.errstate(all="ignore"):
            J, slope = ground.value_and_gradient(form, theta)
            return np.log(J), slope / J[:, None]

    return function


def coarse(problem: Problem) -> Ground:
    """The grid for screening, good for four digits: finer where the vehicle feeds energy in, and modes are lighter."""
    return ground(problem, 4 if problem.vehicle.passive else 8, trimmed=True)


def is_smooth(problem: Problem) -> bool:
    """Whether a problem is a mean square over a box and no more, for which all starts descend at once."""
    return not problem.constraints and problem.objective != "max_yv"


def best_values(
    problem: Problem,
    form: Form,
    settings: Settings,
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
    if not is_smooth(problem):
        from posreal.topology.constrained import best_constrained_values

        return best_constrained_values(problem, form, settings, warm, limit)
    rough = coarse(problem)
    box = Box(rough, form, settings)
    starts = screened(rough, form, box, settings, warm)
    theta, value = descend(logarithm(rough, form), starts, box.lower, box.upper)
    best = int(np.argmin(value))
    agreed = int(np.sum(value[: settings.starts] <= value[best] + 1e-3))
    point = theta[best]
    if has_light_modes(problem):
        ends = [polished(problem, form, box, theta[i]) for i in apart(value)[:_LOOKED_AT]]
        point, figure = min(ends, key=lambda end: end[1])
        return Found(form, figure, tuple(np.exp(point).tolist()), agreed, settings.starts)
    figure = float(ground(problem, FINE, trimmed=True).value_and_gradient(form, point[None, :])[0][0])
    if figure < limit * (1 - NO_GAIN):
        point, figure = polished(problem, form, box, point)
    return Found(form, figure, tuple(np.exp(point).tolist()), agreed, settings.starts)


def has_light_modes(problem: Problem) -> bool:
    """Whether the open plant's own modes are so light that a coarse grid may not see the closed one's."""
    return problem.place.carried == 0 and hinf_norm.least_damping(problem.plant) < NARROW


def apart(value: Array) -> list[int]:
    """Which of some logarithms of figures differ by more than 1e-4, the least first."""
    kept: list[int] = []
    for i in np.argsort(value, kind="stable").tolist():
        if np.isfinite(value[i]) and (not kept or value[i] > value[kept[-1]] + 1e-4):
            kept.append(i)
    return kept or [int(np.argmin(value))]


def screened(ground: Ground, form: Form, box: Box, settings: Settings, warm: Sequence[Sequence[float]]) -> Array:
    """The best of many random points, and the warm ones."""
    points = box.random(max(_SCREENED, settings.starts), generator(settings.seed, form))
    value, _ = logarithm(ground, form)(points)
    chosen = points[np.argsort(np.where(np.isfinite(value), value, np.inf), kind="stable")[: settings.starts]]
    if not warm:
        return chosen
    return np.vstack([chosen, np.clip(np.log(np.array(warm)), box.lower, box.upper)])


def polished(problem: Problem, form: Form, box: Box, theta: Array) -> tuple[Array, float]:
    """A minimum on a grid that sees its modes, and its figure."""
    here = ground(problem, FINE, trimmed=True)
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


_GROUNDS: dict[tuple[object, ...], Ground] = {}


def ground(problem: Problem, panels: int, *, trimmed: bool = False, metric: str | None = None) -> Ground:
    """The ground of a problem, kept: every topology of a search stands on the same one."""
    name = (problem.vehicle, problem.objective, tuple(problem.free.items()), panels, trimmed, metric)
    if name not in _GROUNDS:
        if len(_GROUNDS) >= 32:
            _GROUNDS.clear()
        _GROUNDS[name] = Ground(problem, panels, trimmed=trimmed, metric=metric)
    return _GROUNDS[name]
