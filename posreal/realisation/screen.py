"""Every topology of a size fitted side by side, roughly: which of them come near a device at all.

    min over log θ of  Σ |Y_network(jω)/Y(jω) − 1|²      by Levenberg and Marquardt's method [Marquardt1963]

Topologies that differ only in the kinds of their elements share one form, and the sweep through it takes their
elements' admittances as they come. So all of a form, from all starts and at all frequencies, are one array.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posreal.admittance import Rational
from posreal.network import Network
from posreal.network.response import Response
from posreal.network.topologies import Form, letters, network, valued
from posreal.realisation.fit import LARGEST_LOG, Limits, centre, width

Array = NDArray[np.float64]

POINTS = 12  # frequencies
STARTS = 6  # of each topology
STEPS = 15  # of each start
LONGEST = 3.0  # a step's largest entry: e³ is far enough in one go


def screened(
    forms: Iterable[Form], y: Rational, band: tuple[float, float], limits: Limits | None, seed: int, kept: int
) -> list[tuple[float, Network]]:
    """(largest |Y_network/Y − 1|, network) of the nearest topologies, the nearest first.

    Parameters
    ----------
    forms : iterable of Form
    y : Rational
        The device.
    band : (float, float)
        In rad/s.
    limits : Limits, optional
        Least and greatest values of each kind of element.
    seed : int
        Of the starts.
    kept : int
        How many.
    """
    omega = np.geomspace(*band, POINTS)
    wanted = np.asarray(y(1j * omega))
    rng = np.random.default_rng(seed)
    alike: dict[Form, list[Form]] = {}
    for form in forms:
        alike.setdefault(_blank(form), []).append(form)
    found: list[tuple[float, Form, Array]] = []
    for blank, members in alike.items():
        kinds = [list(letters(form)) for form in members]
        box = np.array([(limits or Limits()).logs(row) for row in kinds]).clip(-LARGEST_LOG, LARGEST_LOG)
        middle = np.array([centre(row, wanted, omega) for row in kinds])
        starts = middle + rng.normal(0, width(omega), (STARTS, *middle.shape))
        powers = np.array([["kcb".index(kind) - 1 for kind in row] for row in kinds])
        theta, misfit = _descended(
            network(blank).response,
            starts.reshape(-1, middle.shape[1]),
            np.tile(box[:, 0], (STARTS, 1)),
            np.tile(box[:, 1], (STARTS, 1)),
            (1j * omega) ** np.tile(powers, (STARTS, 1))[:, :, None],
            wanted,
        )
        for i, form in enumerate(members):
            best = min(range(i, len(theta), len(members)), key=lambda row: misfit[row])
            found.append((float(misfit[best]), form, theta[best]))
    found.sort(key=lambda entry: entry[0])
    return [(misfit, valued(form, np.exp(theta).tolist())) for misfit, form, theta in found[:kept]]


def _blank(form: Form) -> Form:
    """The form with the kinds of its elements left out."""
    return "k" if isinstance(form, str) else (form[0], *map(_blank, form[1:]))


def _descended(
    response: Response, theta: Array, low: Array, high: Array, units: NDArray[np.complex128], wanted: Array
) -> tuple[Array, Array]:
    """θ (B, n) after so many steps in the box, and the largest misfit (B,); units (B, n, N) are Y at θ = 0."""
    count, size = theta.shape

    def misfit(theta: Array) -> tuple[NDArray[Any], NDArray[Any]]:
        branches = np.exp(theta)[:, :, None] * units
        y, dy = response.joined(branches.swapaxes(0, 1).reshape(size, -1))
        r = y.reshape(count, -1) / wanted - 1
        r[~np.isfinite(r)] = np.inf
        return r, dy.reshape(size, count, -1).swapaxes(0, 1) / wanted

    with np.errstate(all="ignore"):  # a start with a pole on a frequency stays where it is
        theta = np.clip(theta, low, high)
        r, slope = misfit(theta)
        mu = np.full(count, 0.01)
        for _ in range(STEPS):
            curvature = np.einsum("bin,bjn->bij", slope.conj(), slope).real
            gradient = np.einsum("bin,bn->bi", slope.conj(), r).real
            steep = np.einsum("bii->bi", curvature)
            damping = mu[:, None] * steep + 1e-12 * steep.max(axis=1, keepdims=True) + 1e-300
            step = -np.linalg.solve(curvature + damping[:, :, None] * np.eye(size), gradient[:, :, None])[:, :, 0]
            step *= np.minimum(1.0, LONGEST / np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-300))
            trial = np.clip(theta + step, low, high)
            r_new, slope_new = misfit(trial)
            better = np.sum(np.abs(r_new) ** 2, axis=1) < np.sum(np.abs(r) ** 2, axis=1)
            theta = np.where(better[:, None], trial, theta)
            r = np.where(better[:, None], r_new, r)
            slope = np.where(better[:, None, None], slope_new, slope)
            mu = np.where(better, mu / 5, mu * 4)
    return theta, np.max(np.abs(r), axis=1)
