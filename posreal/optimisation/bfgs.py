"""Quasi-Newton over devices that are positive real by construction, for problems without constraints.

    minimise J(Y(θ)),   dJ/dθ = Re Σₖ gₖ ∂Y(sₖ)/∂θ,   g = dJ/dY

with θ in :class:`Chart` and g from the closed vehicle's port, delays exact. The positive-real inequality
with P = I is a square here, so nothing constrains the search and it converges superlinearly [NocedalWright2006].
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import minimize

from posreal.optimisation.coordinates import Chart
from posreal.optimisation.criterion import Candidate, Criterion

Real = np.ndarray


def finish(
    criterion: Criterion,
    chart: Chart,
    start: Candidate,
    *,
    iterations: int = 500,
    tolerance: float = 1e-9,
    taken: Callable[[Candidate, float], None] = lambda candidate, value: None,
) -> Candidate:
    """Improve a device to a local optimum.

    Parameters
    ----------
    criterion : Criterion
    chart : Chart
        Order, and whether a spring and an inerter may stand beside the device.
    start : Candidate
        Its device of at most the chart's order.
    iterations : int
    tolerance : float
        Relative slope of J at which to stop.
    taken : function of candidate and value
        Called after each step that improved.

    Returns
    -------
    Candidate
        Its value is never above the start's.
    """
    theta0 = chart.vector(start.device)
    unit, _, _ = criterion.value_and_slope(chart.values(theta0, criterion.s))

    def relative(theta: Real) -> tuple[float, Real]:
        Y, dY = chart.values_and_slopes(theta, criterion.s)
        J, g, _ = criterion.value_and_slope(Y)
        if not np.isfinite(J):
            return np.inf, np.zeros_like(theta)
        return J / unit, np.einsum("ij,j->i", dY, g).real / unit

    best: list[tuple[float, Real]] = [(1.0, theta0)]

    def after(intermediate_result: object) -> None:
        value, theta = float(intermediate_result.fun), intermediate_result.x  # type: ignore[attr-defined]
        if value < best[0][0]:
            best[0] = (value, np.array(theta))
            taken(Candidate(chart.device(theta)), value * unit)

    with np.errstate(all="ignore"):
        minimize(
            relative,
            theta0,
            jac=True,
            method="BFGS",
            callback=after,
            options={"maxiter": iterations, "gtol": tolerance},
        )
    return Candidate(chart.device(best[0][1]))
