"""The same search where the vehicle must keep its damping: sequential quadratic programming [Kraft1988].

    minimise J(Y(θ), φ)   subject to   ζᵢ(θ, φ) ≥ ζ_min

over θ of :class:`Chart` and φ, the logarithms of the vehicle parameters that are free (within their ranges);
ζᵢ are the least damped modes at a set of speeds (:mod:`.damping`), each with its slope.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import minimize

from posreal.design.synthesis.chart import Chart
from posreal.design.synthesis.criterion import Candidate, Criterion
from posreal.design.synthesis.damping import Damping

Real = np.ndarray

UNIT = 0.01  # of damping ratio: what the optimiser sees as 1
INSIDE = 1e-8  # of damping ratio, asked for beyond the limit: the optimiser's rounding stays on the right side


def finish_damped(
    criterion: Criterion,
    damping: Damping,
    limit: float,
    chart: Chart,
    start: Candidate,
    *,
    iterations: int = 200,
    tolerance: float = 1e-9,
    taken: Callable[[Candidate, float], None] = lambda candidate, value: None,
) -> Candidate:
    """Improve a candidate to a local optimum that keeps every watched damping ratio at or above `limit`.

    Parameters
    ----------
    criterion : Criterion
    damping : Damping
        The speeds that are watched.
    limit : float
        Least damping ratio.
    chart : Chart
    start : Candidate
        Need not keep the limit.
    iterations : int
    tolerance : float
        Relative change of J at which to stop.
    taken : function of candidate and value
        Called at each iterate that keeps the limit at the watched speeds.

    Returns
    -------
    Candidate
        The last iterate, which may miss the limit by a little, or by far where the optimiser failed: measure it.
    """
    free = criterion.problem.free if damping.primary else {}
    names = tuple(free)
    first = np.array([start.parameters[name] for name in names])
    unknowns = np.concatenate([chart.vector(start.device), np.zeros(len(names))])
    size = chart.size
    unit = criterion.measure(start)

    def at(x: Real) -> dict[str, float]:
        return dict(zip(names, (first * np.exp(x[size:])).tolist(), strict=True))

    def candidate(x: Real) -> Candidate:
        return Candidate(chart.device(x[:size]), at(x))

    def relative(x: Real) -> tuple[float, Real]:
        values = at(x)
        Y, dY = chart.values_and_slopes(x[:size], criterion.s)
        J, g, by = criterion.value_and_slope(Y, values)
        by_theta = np.einsum("ij,j->i", dY, g).real
        return J / unit, np.concatenate([by_theta, [by[name] * values[name] for name in names]]) / unit

    memory: dict[str, Any] = {}

    def margins(x: Real) -> tuple[Real, Real]:
        if "x" not in memory or not np.array_equal(memory["x"], x):
            values = at(x)
            ratio, by_theta, by = damping.ratios_and_slopes(chart, x[:size], values)
            slope = np.vstack([by_theta, *(by[name] * values[name] for name in names)])
            memory.update(x=x.copy(), result=((ratio - limit - INSIDE) / UNIT, slope.T / UNIT))
        return memory["result"]

    def after(x: Real) -> None:
        if margins(x)[0].min() >= 0:
            taken(candidate(x), relative(x)[0] * unit)

    bounds: list[tuple[float | None, float | None]] = [(None, None)] * size + [
        (float(np.log(free[name].lower / f)), float(np.log(free[name].upper / f)))
        for name, f in zip(names, first, strict=True)
    ]
    with np.errstate(all="ignore"):
        try:
            found = minimize(
                relative,
                unknowns,
                jac=True,
                method="SLSQP",
                bounds=bounds,
                constraints={"type": "ineq", "fun": lambda x: margins(x)[0], "jac": lambda x: margins(x)[1]},
                callback=after,
                options={"maxiter": iterations, "ftol": tolerance},
            ).x
        except (np.linalg.LinAlgError, ValueError):  # an iterate ran off to infinity
            return start
    return candidate(np.asarray(found)) if np.all(np.isfinite(found)) else start
