"""The best values of one topology where something must hold: SLSQP from several starts, then on a fine grid.

    min log J(θ)   subject to   ζ_i(θ) ≥ ζ₀ for the least damped modes at the watched speeds,   log M(θ) ≤ log M₀

All figures have exact gradients but the curve's peak, whose response is differenced at the instant of the peak. Starts
are ranked by how far they are from the damping floor, then by J: an undamped vehicle is no start. What comes out is
measured at all speeds; where the floor is broken the speed is added and the polishing repeated.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import minimize

from posreal.errors import BadInput, listed
from posreal.network.topologies import Form, letters, valued
from posreal.specification.constraint import Constraint, damping_spare
from posreal.specification.problem import Problem
from posreal.topology.batch import Array
from posreal.topology.ground import Ground, mean_square_metrics
from posreal.topology.lateral import LateralLoop
from posreal.topology.values import (
    FINE,
    GRIDS,
    NO_GAIN,
    SETTLED,
    Box,
    Found,
    Settings,
    coarse,
    generator,
    ground,
    has_light_modes,
    logarithm,
)
from posreal.vehicle import PlanView
from posreal.vehicle.metrics import SPEEDS, lateral_rms

SAFETY = 1e-7  # constraints are asked for with this relative margin, so that rounding leaves them satisfied
_FEW = SPEEDS[[0, 27, -1]]
_WATCHED = np.array([SPEEDS[0], *SPEEDS[9::15], SPEEDS[-1]])
_SCREENED = 64

Slack = Callable[[Array], tuple[Array, Array]]  # θ ↦ values that must be ≥ 0, and their gradients


def require_smooth(problem: Problem) -> None:
    """Refuse an objective or a constraint of which the search has no gradient."""
    if problem.points or problem.goal is not None or problem.objective.startswith("gain_"):
        raise BadInput(
            f"a search minimises one mean square or peak at one operating point, not {problem.objective!r}; "
            "optimise and synthesise take it"
        )
    if len(problem.plant.shares) > 1:
        raise BadInput("a search takes one white process, and this plant has several; optimise and synthesise take it")
    lateral = ("Ldmp", "max_yv") if isinstance(problem.vehicle, PlanView) else ()
    accepted = (*mean_square_metrics(problem), *lateral)
    for constraint in problem.constraints:
        if constraint.metric not in accepted:
            raise BadInput(f"a search cannot limit {constraint.metric!r}; it can limit {listed(accepted)}")


@dataclass(frozen=True)
class _Watch:
    """Speeds at which damping is watched, and by how much a metric exceeds the smooth figure that stands for it."""

    speeds: Array
    correction: dict[str, float] = field(default_factory=dict)


class _Program:
    """A problem and a topology as functions of θ on one grid."""

    def __init__(self, problem: Problem, form: Form, here: Ground) -> None:
        self.problem, self.form, self.ground = problem, form, here
        lateral = isinstance(problem.vehicle, PlanView)
        self.loop = _loop(problem) if lateral else None

    def figure(self, metric: str | None) -> Callable[[Array], tuple[float, Array]]:
        """log of a metric (None: of the objective) and its gradient."""
        if (metric or self.problem.objective) == "max_yv":
            return self._peak
        own = metric in (None, self.problem.objective) or (metric == "Macc" and self.problem.objective == "max_yv")
        here = self.ground
        if not own and here.light:
            here = Ground(self.problem, here.panels, light=here.light, metric=metric)
        elif not own:
            here = ground(self.problem, here.panels, trimmed=True, metric=metric)
        batch = logarithm(here, self.form)

        def one(theta: Array) -> tuple[float, Array]:
            value, slope = batch(theta[None, :])
            return float(value[0]), slope[0]

        return one

    def _peak(self, theta: Array) -> tuple[float, Array]:
        assert self.loop is not None
        value, slope = self.loop.peak_gradient(self.form, theta)
        return math.log(1e3 * value), slope / value

    def slack(self, constraint: Constraint, watch: _Watch) -> Slack:
        """A constraint, scaled to order one."""
        if constraint.metric == "Ldmp":
            floor = constraint.value / 100
            loop = self.loop
            assert loop is not None

            def damped(theta: Array) -> tuple[Array, Array]:
                zeta, slope = loop.ratios(self.form, theta, watch.speeds)
                return damping_spare(zeta, slope.T, floor, SAFETY * floor) / floor, slope / floor

            return damped
        function = self.figure(constraint.metric)
        ceiling = math.log(constraint.value * (1 - SAFETY) / watch.correction.get(constraint.metric, 1.0))

        def limited(theta: Array) -> tuple[Array, Array]:
            value, slope = function(theta)
            return np.array([ceiling - value]), -slope[None, :]

        return limited

    def solve(self, start: Array, box: Box, watch: _Watch, *, iterations: int, tolerance: float) -> Array:
        """SLSQP from one start."""
        constraints = []
        for constraint in self.problem.constraints:
            kept = _Kept(self.slack(constraint, watch))
            constraints.append({"type": "ineq", "fun": kept.value, "jac": kept.gradient})
        objective = self.figure(None)
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            # SLSQP says so when a line search leaves the bounds by rounding and is clipped
            warnings.filterwarnings("ignore", message="Values in x were outside bounds", category=RuntimeWarning)
            result = minimize(
                objective,
                start,
                jac=True,
                method="SLSQP",
                bounds=list(zip(box.lower, box.upper, strict=True)),
                constraints=constraints,
                options={"maxiter": iterations, "ftol": tolerance},
            )
        point = np.clip(np.asarray(result.x, dtype=float), box.lower, box.upper)
        return point if np.all(np.isfinite(point)) else start

    def shortfall(self, theta: Array, watch: _Watch) -> float:
        """By how much the worst constraint is broken, relative; 0 where all hold."""
        with np.errstate(all="ignore"):
            worst = [float(self.slack(c, watch)(theta)[0].min()) for c in self.problem.constraints]
        return max(0.0, -min(worst, default=0.0)) if np.all(np.isfinite(worst)) else math.inf


class _Kept:
    """A slack that remembers its last point, since SLSQP asks for value and gradient one after the other."""

    def __init__(self, function: Slack) -> None:
        self._function = function
        self._theta: Array | None = None
        self._last: tuple[Array, Array] | None = None

    def _at(self, theta: Array) -> tuple[Array, Array]:
        if self._last is None or self._theta is None or not np.array_equal(self._theta, theta):
            self._theta, self._last = theta.copy(), self._function(theta)
        return self._last

    def value(self, theta: Array) -> Array:
        return self._at(theta)[0]

    def gradient(self, theta: Array) -> Array:
        return self._at(theta)[1]


def best_constrained_values(
    problem: Problem, form: Form, settings: Settings, warm: Sequence[Sequence[float]] = (), limit: float = math.inf
) -> Found:
    """As :func:`posreal.topology.values.best_values`, for a problem with constraints or a peak to minimise."""
    rough = _Program(problem, form, coarse(problem))
    fine = _Program(problem, form, ground(problem, FINE, trimmed=True))
    box = Box(rough.ground, form, settings)
    few = _Watch(_FEW)
    ends: list[tuple[float, int, Array]] = []
    objective = fine.figure(None)
    for number, start in enumerate(_starts(rough, box, settings, warm, few)):
        theta = rough.solve(start, box, few, iterations=60, tolerance=1e-7)
        value = objective(theta)[0]
        if rough.shortfall(theta, few) < 1e-3 and math.isfinite(value):
            ends.append((value, number, theta))
    ends.sort(key=lambda end: end[:2])
    agreed = sum(n < settings.starts and value <= ends[0][0] + 1e-3 for value, n, _ in ends)
    for value, _, theta in ends[:3]:
        if not has_light_modes(problem) and value >= math.log(limit * (1 - NO_GAIN)):
            # fewer speeds are watched here than there are, and still it is no better than its limit
            return Found(form, math.exp(value), tuple(np.exp(theta).tolist()), agreed, settings.starts)
        found = _polished(fine, box, theta)
        if found is not None:
            figure, point = found
            return Found(form, figure, tuple(np.exp(point).tolist()), agreed, settings.starts)
    return Found(form, math.inf, (), 0, settings.starts)


def _starts(
    program: _Program, box: Box, settings: Settings, warm: Sequence[Sequence[float]], few: _Watch
) -> list[Array]:
    """The random points nearest to what must hold, then of least ride figure, and the warm ones."""
    points = box.random(max(_SCREENED, settings.starts), generator(settings.seed, program.form))
    value, _ = logarithm(program.ground, program.form)(points)
    value = np.where(np.isfinite(value), value, np.inf)
    order = np.argsort(value, kind="stable")[: max(_SCREENED // 2, settings.starts)]
    least = value[order[0]]
    rank = []
    for i in order:
        short = 0.0
        if program.loop is not None:
            floor = next((c.value for c in program.problem.constraints if c.metric == "Ldmp"), 0.0) / 100
            short = max(0.0, floor - float(program.loop.least_ratios(program.form, points[i], few.speeds).min()))
        rank.append(short + 1e-2 * (value[i] - least))
    chosen = [points[order[i]] for i in np.argsort(rank, kind="stable")[: settings.starts]]
    return chosen + [np.clip(np.log(np.array(values)), box.lower, box.upper) for values in warm]


def _polished(fine: _Program, box: Box, theta: Array) -> tuple[float, Array] | None:
    """A minimum at which all constraints hold at all speeds, and its figure, on a grid that sees its modes."""
    lateral = fine.loop is not None
    watch = _Watch(_WATCHED if lateral else np.array([]), _corrections(fine, theta))
    for _ in range(GRIDS):
        theta = fine.solve(theta, box, watch, iterations=150, tolerance=1e-12)
        closer = _Program(fine.problem, fine.form, fine.ground.closer(fine.form, theta))
        everywhere = _Watch(SPEEDS if lateral else watch.speeds, _corrections(closer, theta))
        seen, there = fine.figure(None)(theta)[0], closer.figure(None)(theta)[0]
        if closer.shortfall(theta, everywhere) <= SAFETY / 2 and abs(there - seen) <= SETTLED:
            return math.exp(there), theta
        speeds = watch.speeds
        if fine.loop is not None:
            floor = next((c.value for c in fine.problem.constraints if c.metric == "Ldmp"), 0.0) / 100
            speeds = np.union1d(speeds, SPEEDS[fine.loop.least_ratios(fine.form, theta, SPEEDS) < floor])
        fine, watch = closer, _Watch(speeds, everywhere.correction)
    return None


def _corrections(program: _Program, theta: Array) -> dict[str, float]:
    """The paper's sum against the Gauss rule, for a limited lateral ride figure."""
    problem, form = program.problem, program.form
    limited = [c.metric for c in problem.constraints if c.metric in ("Macc", "J1y")]
    if not limited or not isinstance(problem.vehicle, PlanView):
        return {}
    count = len(letters(form))
    values = np.exp(theta)
    tuned = problem.with_vehicle(dict(zip(problem.free, values[count:].tolist(), strict=True)))
    assert isinstance(tuned.vehicle, PlanView)
    port = tuned.port(valued(form, values[:count].tolist()).admittance())
    at = {"Macc": tuned.vehicle.at(float(SPEEDS[-1])), "J1y": tuned.vehicle}
    return {metric: lateral_rms(at[metric], port) / math.exp(program.figure(metric)(theta)[0]) for metric in limited}


_LOOPS: dict[tuple[object, ...], LateralLoop] = {}


def _loop(problem: Problem) -> LateralLoop:
    name = (problem.vehicle, tuple(problem.free.items()), problem.objective)
    if name not in _LOOPS:
        if len(_LOOPS) >= 8:
            _LOOPS.clear()
        _LOOPS[name] = LateralLoop(problem, coarse(problem).scale)
    return _LOOPS[name]
