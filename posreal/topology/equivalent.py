"""Whether a topology can be a given device, decided by fitting it.

    min Σ_k |Y(s_k)/Y₀(s_k) − 1|²      over the element values

to zero, from many starts. A device of degree n is fixed by 2n + 1 numbers, and there are many more points than that, so
what agrees on them to eight digits is the same admittance. The points lie on a ray into the right half-plane, where a
positive-real function has neither pole nor zero: on the axis a resonance that is not yet in its place would hide the
way to it.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import least_squares

from posreal.network.topologies import Form, letters
from posreal.numerics.batched_descent import descend
from posreal.real_elements import RealElements
from posreal.topology.batch import Array, Grid, admittance
from posreal.topology.ground import Units

AGREE = 1e-8  # largest relative difference of admittances that are called equal
_POINTS, _DECADES, _STARTS = 60, 2.5, 24
_ANGLE = math.pi / 3  # of the ray


def fitted(
    form: Form,
    target: Array,
    points: Array,
    scale: Units,
    rng: np.random.Generator,
    elements: RealElements | None = None,
) -> tuple[float, ...] | None:
    """Values with which a topology has the admittance `target` at `points`, or None.

    Parameters
    ----------
    form : Form
    target, points : (N,) complex
        As :func:`sample` gives them.
    scale : Scale
        The vehicle's units, about which starts lie.
    rng : Generator
    elements : RealElements or None
        What comes with each element.
    """
    kinds = letters(form)
    grid = Grid.at(points, elements)
    unit = np.log(scale.units(kinds))
    starts = unit + math.log(10.0) * rng.uniform(-2.0, 2.0, size=(_STARTS, len(kinds)))

    def misfit(theta: Array) -> tuple[Array, Array]:
        with np.errstate(all="ignore"):
            Y, pull = admittance(form, theta, grid)
            r = Y / target - 1
            return (np.abs(r) ** 2).sum(axis=1), pull(2 * r.conj() / target)

    bounds = unit - 18.0, unit + 18.0
    theta, value = descend(misfit, starts, *bounds, iterations=80)
    for i in np.argsort(value, kind="stable")[:3]:
        result = least_squares(
            lambda x: _stacked(admittance(form, x[None, :], grid)[0][0] / target - 1),
            np.clip(theta[i], bounds[0] + 1e-9, bounds[1] - 1e-9),
            bounds=bounds,
            x_scale="jac",
            xtol=1e-15,
            ftol=1e-15,
            gtol=1e-15,
            max_nfev=200,
        )
        if np.abs(result.fun).max() <= AGREE:
            return tuple(np.exp(result.x).tolist())
    return None


def sample(scale: Units) -> Array:
    """Points about the vehicle's frequency at which admittances are compared."""
    return np.exp(1j * _ANGLE) * scale.omega0 * np.geomspace(10**-_DECADES, 10**_DECADES, _POINTS)


def _stacked(r: Array) -> Array:
    return np.concatenate([r.real, r.imag])
