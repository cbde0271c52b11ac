"""The same search where something must be kept: sequential quadratic programming [Kraft1988].

    minimise maxᵢ Fᵢ(θ, φ)   subject to   every margin(θ, φ) ≥ 0

over θ of :class:`Chart` and φ, the logarithms of the vehicle parameters that are free (within their ranges). F are the
objective's figures (:mod:`.figure`); where it is more than one number, a bound t on all of them is minimised in their
place. Margins are those of figures below their limits and of damping ratios above theirs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from scipy.optimize import minimize

from posreal.optimisation.coordinates import Coordinates
from posreal.optimisation.damping import Damping
from posreal.optimisation.figure import Figure, Slopes
from posreal.specification.constraint import Range, damping_spare

Real = np.ndarray

UNIT = 0.01  # of damping ratio: what the optimiser sees as 1
INSIDE = 1e-8  # of damping ratio and of figures, relative: the optimiser's rounding stays on the right side


class Requirement(Protocol):
    """Something to be kept: margins in units of their own, not negative where it is."""

    def margins(self, chart: Coordinates, theta: Real, parameters: Mapping[str, float]) -> Slopes:
        """The margins and their slopes."""


@dataclass(frozen=True)
class AtMost:
    """A figure not above its limit."""

    metric: str
    figure: Figure
    limit: float

    def margins(self, chart: Coordinates, theta: Real, parameters: Mapping[str, float]) -> Slopes:
        """1 − F/limit."""
        found = self.figure.slopes(chart, theta, parameters)
        unit = self.limit if self.limit > 0 else 1.0
        return Slopes(
            (self.limit - found.values) / unit - INSIDE,
            -found.by_theta / unit,
            {name: -slope / unit for name, slope in found.by.items()},
        )


@dataclass(frozen=True)
class AtLeast:
    """A figure not below its limit, which is above 0."""

    metric: str
    figure: Figure
    limit: float

    def margins(self, chart: Coordinates, theta: Real, parameters: Mapping[str, float]) -> Slopes:
        """F/limit − 1."""
        found = self.figure.slopes(chart, theta, parameters)
        return Slopes(
            found.values / self.limit - 1 - INSIDE,
            found.by_theta / self.limit,
            {name: slope / self.limit for name, slope in found.by.items()},
        )


@dataclass(frozen=True)
class Damped:
    """Every watched mode with at least a damping ratio, and `spare` of it, relative, more."""

    damping: Damping
    limit: float
    spare: float = 0.0

    def margins(self, chart: Coordinates, theta: Real, parameters: Mapping[str, float]) -> Slopes:
        """(ζ − limit)/UNIT."""
        ratio, by_theta, by = self.damping.ratios_and_slopes(chart, theta, parameters)
        slopes = np.vstack([by_theta, *(slope * parameters[name] for name, slope in by.items())])
        spare = damping_spare(ratio, slopes, self.limit, self.limit * self.spare + INSIDE)
        return Slopes(spare / UNIT, by_theta / UNIT, {name: slope / UNIT for name, slope in by.items()})


@np.errstate(all="ignore")
def finish_constrained(
    objective: Sequence[Figure],
    requirements: Sequence[Requirement],
    free: Mapping[str, Range],
    chart: Coordinates,
    start: Real,
    parameters: Mapping[str, float],
    *,
    iterations: int = 200,
    tolerance: float = 1e-9,
) -> list[tuple[Real, dict[str, float]]]:
    """Improve a device to a local optimum that keeps what is required.

    Parameters
    ----------
    objective : sequence of Figure
        The largest of all their numbers is minimised.
    requirements : sequence of Requirement
    free : mapping of vehicle parameter to Range
    chart : Coordinates
    start, parameters : vector of the chart, and mapping of free vehicle parameter to value
        Need not keep the requirements.
    iterations : int
    tolerance : float
        Relative change of the objective at which to stop.

    Returns
    -------
    list of (vector of the chart, free vehicle parameters)
        The last iterate, which may miss a requirement by a little, or by far where the optimiser failed, and the best
        iterate that missed none, if there was one: measure them.
    """
    names = tuple(free)
    first = np.array([parameters[name] for name in names])
    size, count = chart.size, len(names)

    def at(x: Real) -> dict[str, float]:
        return dict(zip(names, (first * np.exp(x[size : size + count])).tolist(), strict=True))

    def stacked(parts: Sequence[Slopes], values: Mapping[str, float]) -> tuple[Real, Real]:
        """Values (m,) and their slopes (m, size + count) in the unknowns."""
        by = [np.hstack([part.by[name] * values[name] for part in parts])[None, :] for name in names]
        return np.hstack([part.values for part in parts]), np.vstack([np.hstack([p.by_theta for p in parts]), *by]).T

    memory: dict[str, Any] = {}

    def figures(x: Real) -> tuple[Real, Real]:
        """Objective numbers relative to the start's."""
        key = x[: size + count].tobytes()
        if memory.get("figures at") != key:
            values = at(x)
            found, slope = stacked([f.slopes(chart, x[:size], values) for f in objective], values)
            unit = memory.setdefault("unit", float(found.max()))
            memory.update({"figures at": key, "figures": (found / unit, slope / unit)})
        return memory["figures"]

    def margins(x: Real) -> tuple[Real, Real]:
        key = x[: size + count].tobytes()
        if memory.get("margins at") != key:
            values = at(x)
            found = stacked([r.margins(chart, x[:size], values) for r in requirements], values)
            memory.update({"margins at": key, "margins": found})
        return memory["margins"]

    x0 = np.concatenate([start, np.zeros(count)])
    if not np.all(np.isfinite(figures(x0)[0])):  # undamped to the last digit, say
        return []
    many = len(figures(x0)[0]) > 1
    if many:
        x0 = np.append(x0, figures(x0)[0].max())

    def target(x: Real) -> tuple[float, Real]:
        if many:
            return float(x[-1]), np.append(np.zeros(size + count), 1.0)
        values, slope = figures(x)
        return float(values[0]), slope[0]

    def slack(x: Real) -> tuple[Real, Real]:
        parts = [margins(x)] if requirements else []
        if many:
            values, slope = figures(x)
            parts = [(v, np.hstack([s, np.zeros((len(v), 1))])) for v, s in parts]
            parts.append((x[-1] - values, np.hstack([-slope, np.ones((len(values), 1))])))
        return np.concatenate([v for v, _ in parts]), np.vstack([s for _, s in parts])

    kept: list[tuple[float, Real]] = []

    def after(x: Real) -> None:
        if not requirements or margins(x)[0].min() >= 0:
            value = float(figures(x)[0].max())
            if not kept or value < kept[0][0]:
                kept[:] = [(value, np.array(x))]

    bounds: list[tuple[float | None, float | None]] = [
        *chart.bounds,
        *(
            (float(np.log(free[name].lower / f)), float(np.log(free[name].upper / f)))
            for name, f in zip(names, first, strict=True)
        ),
    ]
    bounds += [(None, None)] * many
    try:
        found = minimize(
            target,
            x0,
            jac=True,
            method="SLSQP",
            bounds=bounds,
            constraints={"type": "ineq", "fun": lambda x: slack(x)[0], "jac": lambda x: slack(x)[1]}
            if requirements or many
            else (),
            callback=after,
            options={"maxiter": iterations, "ftol": tolerance},
        ).x
    except (np.linalg.LinAlgError, ValueError):  # an iterate ran off to infinity
        found = x0
    last = [np.asarray(found)] if np.all(np.isfinite(found)) else []
    return [(x[:size], at(x)) for x in [*last, *(x for _, x in kept)]]
