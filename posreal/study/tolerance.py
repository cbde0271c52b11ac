"""Vehicles as they are built: the spread of every figure when each value is within its tolerance, and what it hangs on.

Values are drawn independently and evenly within their tolerances; the corners of the tolerances are looked at too.
Draws are computed one way; what is printed of them (the nominal, the draws that are percentiles, the worst) is
confirmed by two methods. A percentile is the figure of a draw: of n draws the one of rank ⌈p n⌉.

The share of the variance that is a part's own comes from an additive fit with Legendre polynomials of degree 1 and 2 in
each value, orthogonal under the even distribution: what they leave is due to several values together.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from posreal.errors import BadInput, Infeasible, shown
from posreal.metric import Metric
from posreal.network import Damper
from posreal.numerics.parallel import Workers, workers
from posreal.optimisation.evaluate import evaluate
from posreal.realisation import realise
from posreal.specification.constraint import ROUNDING, Constraint
from posreal.specification.design import Design
from posreal.specification.problem import Problem
from posreal.specification.tolerances import TOLERANCE, Tolerances, tolerances
from posreal.specification.variation import Variation, variation
from posreal.study.tolerance_result import CONFIDENCE, Share, Spread, Tolerance

Real = np.ndarray
DRAWS = 500
MOST = 100_000  # draws
PERCENTILES = {"p5": 0.05, "p50": 0.5, "p95": 0.95}
_ALL_CORNERS = 128  # corners of which every one is looked at; of more, those that an ascent reaches
_CHUNK = 20  # draws a task
_NEAR = 1e-5  # of a limit: a draw that near to it is confirmed before it counts
_ROUNDS = 6  # of an ascent from corner to corner


def tolerance(
    problem_or_design: Problem | Design,
    device: Any = None,
    *,
    tolerance: float | str | Mapping[str, float] = TOLERANCE,
    vehicle: float | str | Mapping[str, float] | None = None,
    draws: int = DRAWS,
    seed: int = 0,
    jobs: int = 1,
    backend: str | None = None,
    scheduler: str | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> Tolerance:
    """The spread of every metric, and the yield of every constraint, over vehicles built within tolerances.

    Parameters
    ----------
    problem_or_design : Problem or Design
        A problem with a `device`, or a design.
    device : as :func:`posreal.evaluate` takes it
        An admittance is realised as a network first.
    tolerance : float, text or mapping
        Relative, of the elements: 0.2 by default; by kind or name ``{"k": 0.1, "c1": 0.3}`` or ``20%,k=10%,c1=30%``.
    vehicle : float, text or mapping, optional
        Of vehicle parameters, likewise. By default 20 % of the spring at the device's place and of what stands in the
        vehicle's other ports (Ksy, Kpy, Cpy of the plan view; the bush of the side view).
    draws : int
        Up to 100 000.
    seed : int
    jobs, backend, scheduler
        As in :func:`posreal.search`; the answer does not depend on them.
    progress : function of str

    Returns
    -------
    Tolerance

    Raises
    ------
    BadInput
        For a tolerance of what does not exist, or if nothing varies.
    Infeasible
        If the design itself is not stable.
    """
    design = problem_or_design if isinstance(problem_or_design, Design) else evaluate(problem_or_design, device)
    said = tolerances(tolerance, vehicle)
    return within(
        design, said, draws=draws, seed=seed, jobs=jobs, backend=backend, scheduler=scheduler, progress=progress
    )


def within(
    design: Design,
    said: Tolerances,
    *,
    draws: int = DRAWS,
    seed: int = 0,
    jobs: int = 1,
    backend: str | None = None,
    scheduler: str | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> Tolerance:
    """As :func:`tolerance`, of a design and tolerances that have been read."""
    if not 1 <= draws <= MOST:
        raise BadInput(f"draws is {shown(draws)}; give from 1 to {MOST}")
    varied = variation(as_network(design), said)
    if not varied.parts:
        raise BadInput("nothing varies: the device has no elements; give vehicle parameters a tolerance")
    points = np.random.default_rng(seed).uniform(-1.0, 1.0, (draws, len(varied.parts)))
    with workers(jobs, backend, scheduler) as pool:
        look = _Draws(varied, pool, progress)
        found = look.at(points, "draw")
        corners = _corners(look, points, found)
        return _summary(look, points, found, *corners, seed)


def as_network(design: Design) -> Design:
    """The design with a network, which is what has tolerances; realised if it has none yet."""
    device = design.device
    if design.network is not None or device is None or device.is_zero():
        return design
    network = Damper(device(1.0).real) if device.degree == 0 else realise(device).network
    if design.whole:
        raise BadInput("a whole strut without a network has no elements; give a layout, a network or an admittance")
    return replace(design, network=network)


class _Draws:
    """Vehicles measured side by side."""

    def __init__(self, varied: Variation, pool: Workers, progress: Callable[[str], None]) -> None:
        self.varied, self.pool, self.progress = varied, pool, progress
        self.names = tuple(varied.design.metrics)
        problem = varied.design.problem
        self.constraints = tuple(c for c in problem.constraints if not c.nominal)
        metrics = problem.vehicle.metrics
        known: list[Metric | None] = [metrics.get(name.partition(" at ")[0]) for name in self.names]
        self.sign = np.array([-1.0 if one is not None and one.better == "more" else 1.0 for one in known])

    def at(self, points: Real, what: str) -> Real:
        """Metrics (points, names), one way; NaN where the vehicle is not stable."""
        chunks = [(i, points[i : i + _CHUNK]) for i in range(0, len(points), _CHUNK)]
        found = np.full((len(points), len(self.names)), np.nan)
        done = 0
        for i, rows in self.pool.each(_chunk, [(self.varied, self.names, *chunk) for chunk in chunks]):
            found[i : i + len(rows)] = rows
            done += len(rows)
            self.progress(f"{what} {done}/{len(points)}")
        return found

    def badness(self, found: Real) -> Real:
        """Larger is worse, and infinite where the vehicle is not stable."""
        return np.where(np.isnan(found), np.inf, self.sign * found)

    def confirm(self, wanted: Mapping[bytes, tuple[Real, set[str]]]) -> dict[tuple[bytes, str], float]:
        """Figures of some vehicles by two methods."""
        tasks = [(self.varied, key, at, sorted(names)) for key, (at, names) in wanted.items()]
        found: dict[tuple[bytes, str], float] = {}
        for number, (key, values) in enumerate(self.pool.each(_one, tasks), 1):
            found |= {(key, name): value for name, value in values.items()}
            self.progress(f"confirming {number}/{len(tasks)}")
        return found


def _chunk(varied: Variation, names: Sequence[str], start: int, points: Real) -> tuple[int, Real]:
    return start, varied.measured(points, names)


def _one(varied: Variation, key: bytes, at: Real, names: Sequence[str]) -> tuple[bytes, dict[str, float]]:
    values = {}
    with suppress(Infeasible):
        values = dict(zip(names, varied.confirmed(at, names), strict=True))
    return key, values


def _corners(look: _Draws, points: Real, found: Real) -> tuple[Real, Real, int]:
    """Corners of the tolerances, their metrics, and how many there are in all.

    Every one where they are few. Otherwise, for each metric, from the corner to which the draws point, one value at a
    time is changed over while that makes it worse.
    """
    n = points.shape[1]
    if 2**n <= _ALL_CORNERS:
        every = np.array(list(itertools.product((-1.0, 1.0), repeat=n)))
        return every, look.at(every, "corner"), 2**n
    bad = look.badness(found)
    towards = np.where(np.isfinite(bad), bad, np.nan)
    centred = np.nan_to_num(towards - np.nanmean(np.where(np.isfinite(towards), towards, np.nan), axis=0))
    best = np.where(points.T @ centred >= 0, 1.0, -1.0).T  # a corner a metric
    known: dict[bytes, tuple[Real, Real]] = {}
    for _ in range(_ROUNDS):
        flips = [corner * np.where(np.arange(n) == i, -1.0, 1.0) for corner in best for i in range(-1, n)]
        fresh = {corner.tobytes(): corner for corner in flips if corner.tobytes() not in known}
        if not fresh:
            break
        stacked = np.array(list(fresh.values()))
        known |= dict(zip(fresh, zip(stacked, look.at(stacked, "corner"), strict=True), strict=True))
        corners = np.array([corner for corner, _ in known.values()])
        worst = look.badness(np.array([row for _, row in known.values()])).argmax(axis=0)
        best = corners[worst]
    return corners, np.array([row for _, row in known.values()]), 2**n


def _summary(look: _Draws, points: Real, found: Real, corners: Real, there: Real, of: int, seed: int) -> Tolerance:
    design, draws = look.varied.design, len(points)
    everywhere, numbers = np.vstack([points, corners]), np.vstack([found, there])
    bad, order = look.badness(numbers), np.argsort(look.sign * look.badness(found), axis=0, kind="stable")
    limited = {c.metric for c in look.constraints} | {design.problem.objective}
    ranks = {name: math.ceil(p * draws) - 1 for name, p in PERCENTILES.items()}
    ends = {name: _interval(p, draws) for name, p in PERCENTILES.items() if name != "p50"}
    rows: dict[tuple[str, str], int] = {}  # which vehicle a printed figure is of
    for j, metric in enumerate(look.names):
        rows |= {(metric, name): int(order[rank, j]) for name, rank in ranks.items()}
        rows[metric, "worst"] = int(bad[:, j].argmax())
        if metric in limited:
            rows |= {
                (metric, f"{name} {side}"): int(order[rank, j])
                for name, both in ends.items()
                if both is not None
                for side, rank in zip(("low", "high"), both, strict=True)
            }
    near = _near_limits(look, found)
    wanted: dict[bytes, tuple[Real, set[str]]] = {}
    for metric, row in [*((metric, row) for (metric, _), row in rows.items()), *near]:
        if np.isfinite(bad[row, look.names.index(metric)]):
            wanted.setdefault(everywhere[row].tobytes(), (everywhere[row], set()))[1].add(metric)
    confirmed = look.confirm(wanted)
    apart = 0.0
    for row, at in enumerate(everywhere):
        for j, metric in enumerate(look.names):
            sure = confirmed.get((at.tobytes(), metric))
            if sure is not None:
                apart = max(apart, abs(numbers[row, j] / sure - 1) if sure else abs(numbers[row, j]))
                numbers[row, j] = sure

    def figure(metric: str, name: str) -> float | None:
        return confirmed.get((everywhere[rows[metric, name]].tobytes(), metric))

    spreads = {}
    for metric in look.names:
        both = {
            name: (figure(metric, f"{name} low"), figure(metric, f"{name} high"))
            for name in ends
            if (metric, f"{name} low") in rows
        }
        spreads[metric] = Spread(
            design.metrics[metric].value,
            figure(metric, "p5"),
            figure(metric, "p50"),
            figure(metric, "p95"),
            figure(metric, "worst"),
            design.metrics[metric].unit,
            look.varied.values(everywhere[rows[metric, "worst"]]),
            {name: (low, high) for name, (low, high) in both.items() if low is not None and high is not None},
        )
    found = numbers[:draws]
    shares, effects = _shares(look, points, found)
    kept = _kept(look, found)
    default = design.problem.default_metrics
    objective = look.names.index(design.problem.objective)
    return Tolerance(
        variation=look.varied,
        draws=draws,
        seed=seed,
        spreads=spreads,
        yields={_name(c, kept): Share(int(one.sum()), draws) for c, one in kept.items()},
        kept=Share(int(np.logical_and.reduce(list(kept.values())).sum()), draws) if kept else None,
        stable=Share(int(np.isfinite(found).all(axis=1).sum()), draws),
        better=None
        if default is None
        else Share(int((found[:, objective] < default[design.problem.objective].value).sum()), draws),
        shares=shares,
        effects=effects,
        corners=len(corners),
        of_corners=of,
        apart=float(apart),
    )


def _interval(p: float, draws: int) -> tuple[int, int] | None:
    """Ranks between which a percentile lies with 95 % confidence; None where the draws are too few."""
    from scipy.special import bdtr

    below = bdtr(np.arange(draws), draws, p)  # of k draws or fewer below the percentile
    low = int(np.searchsorted(below, (1 - CONFIDENCE) / 2, side="right")) - 1
    high = int(np.searchsorted(below, (1 + CONFIDENCE) / 2)) + 1
    return (low, high) if low >= 0 and high < draws else None


def _margins(look: _Draws, found: Real, constraint: Constraint) -> Real:
    slack = found[:, look.names.index(constraint.metric)] - constraint.value
    return slack if constraint.sense == ">=" else -slack


def _near_limits(look: _Draws, found: Real) -> list[tuple[str, int]]:
    """Draws so near to a limit that one way does not decide."""
    return [
        (c.metric, int(row))
        for c in look.constraints
        for row in np.flatnonzero(np.abs(_margins(look, found, c)) <= _NEAR * abs(c.value))
    ]


def _kept(look: _Draws, found: Real) -> dict[Constraint, Real]:
    """Which draws keep each constraint; none that is not stable."""
    with np.errstate(invalid="ignore"):
        return {c: _margins(look, found, c) >= -ROUNDING * abs(c.value) for c in look.constraints}


def _name(constraint: Constraint, among: Mapping[Constraint, Any]) -> str:
    """The metric, or the whole sentence where several constraints limit it."""
    return constraint.metric if [c.metric for c in among].count(constraint.metric) == 1 else str(constraint)


def _shares(look: _Draws, points: Real, found: Real) -> tuple[dict[str, dict[str, float]], dict[str, dict[str, float]]]:
    """Shares of the variance and first-order effects of every part on every metric."""
    good = np.isfinite(found).all(axis=1)
    u, values, n = points[good], found[good], points.shape[1]
    basis = np.hstack([np.ones((len(u), 1)), u, (3 * u**2 - 1) / 2])
    if len(u) < 2 * basis.shape[1]:
        return {}, {}
    fit = np.linalg.lstsq(basis, values, rcond=None)[0]
    own = fit[1 : 1 + n] ** 2 / 3 + fit[1 + n :] ** 2 / 5
    variance = own.sum(axis=0) + (values - basis @ fit).var(axis=0)
    names = [part.name for part in look.varied.parts]
    shares, effects = {}, {}
    for j, metric in enumerate(look.names):
        if variance[j] > (1e-9 * abs(values[:, j]).max()) ** 2:
            shares[metric] = dict(zip(names, (own[:, j] / variance[j]).tolist(), strict=True))
            effects[metric] = dict(zip(names, fit[1 : 1 + n, j].tolist(), strict=True))
    return shares, effects
