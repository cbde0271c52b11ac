"""The smallest network that is close enough, within values that can be built.

Series–parallel networks and bridges are fitted in order of size,

    min over values of  max |Y_network(jω)/Y(jω) − 1|  over a band,

and the first size that meets the tolerance wins, the best fit among it. All topologies of a size are fitted side by
side at a few frequencies first, and those that come near are fitted well.
"""

from __future__ import annotations

from fractions import Fraction
from functools import partial

import numpy as np
from numpy.typing import NDArray

from posreal.admittance import Rational
from posreal.admittance.exact import rounded, to_fmpq, to_fraction
from posreal.errors import BadInput, Infeasible
from posreal.network import Element, Network
from posreal.network.topologies import topologies
from posreal.realisation.elements import revalued
from posreal.realisation.fit import Limits, fitted
from posreal.realisation.proof import corners
from posreal.realisation.screen import screened

LARGEST = 5  # elements
POINTS = 40  # frequencies over the band, for fitting
DENSE = 400  # for measuring the misfit of what was fitted
NEAR = 5  # times the tolerance: the misfit up to which screened networks are fitted well,
KEPT = 12  # of each size at most


def close_network(
    y: Rational,
    tolerance: float,
    band: tuple[float, float] | None = None,
    limits: Limits | None = None,
    largest: int = LARGEST,
    seed: int = 0,
) -> tuple[Network, float]:
    """The smallest network found within a relative tolerance, and its largest misfit over the band.

    Parameters
    ----------
    y : Rational
        The device.
    tolerance : float
        Largest |Y_network/Y − 1| allowed.
    band : (float, float), optional
        In rad/s; from a decade under the lowest corner of Y to one over the highest if not given.
    limits : Limits, optional
        Values that can be built.
    largest : int
        Elements at most.

    Raises
    ------
    Infeasible
        If no network of that size is close enough, with the best misfit found.
    BadInput
        For a tolerance or band that makes no sense.
    """
    low, high = band or (corners(y)[0] * 10, corners(y)[1] / 10)
    if not 0 < tolerance < 1:
        raise BadInput(f"A tolerance of {tolerance:g} makes no sense; give a part of |Y| between 0 and 1.")
    if not 0 < low < high < np.inf:
        raise BadInput(f"The band {low:g} to {high:g} rad/s makes no sense; give 0 < low < high.")
    omega, dense = (np.geomspace(low, high, count) for count in (POINTS, DENSE))
    best = np.inf
    for size in range(1, largest + 1):
        found = screened(topologies(size), y, (low, high), limits, seed, KEPT)
        refined = []
        for order, (rough, network) in enumerate(found):
            if rough <= NEAR * tolerance:
                network = fitted(network, y, omega, limits, seed + 1)
                refined.append((_misfit(network, y, dense), order, network))
        if not refined:
            best = min(best, found[0][0])
            continue
        misfit, _, network = min(refined)
        best = min(best, misfit)
        if misfit <= tolerance:
            return _shortened(network, y, dense, misfit, tolerance, limits)
    raise Infeasible(
        f"no network of {largest} elements or fewer was found within {tolerance:g} of it over {low:.4g} to "
        f"{high:.4g} rad/s" + (f" (the best is off by {best:.2g})" if best < np.inf else "")
    )


def _shortened(
    network: Network,
    y: Rational,
    omega: NDArray[np.float64],
    misfit: float,
    tolerance: float,
    limits: Limits | None,
) -> tuple[Network, float]:
    """The fewest significant digits that cost little of the tolerance and stay within the limits."""
    allowed = min(tolerance, misfit + tolerance / 20)
    for digits in (3, 4, 5, 6, 8, 12):
        short = revalued(network, partial(_rounded, digits))
        rough = _misfit(short, y, omega)
        if rough <= allowed and (limits is None or limits.broken_by(short) is None):
            return short, rough
    return network, misfit


def _misfit(network: Network, y: Rational, omega: NDArray[np.float64]) -> float:
    s = 1j * omega
    return float(np.max(np.abs(np.asarray(network(s)) / np.asarray(y(s)) - 1)))


def _rounded(digits: int, part: Element) -> Fraction:
    return to_fraction(rounded(to_fmpq(part.exact), digits))
