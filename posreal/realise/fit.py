"""Element values of a given network for a given admittance, by least squares and then to many digits.

Minimise Σ |Y_network(jω)/Y(jω) − 1|² over the logarithms of the values (floats, several starts). Where
that meets the device, the float Jacobian drives a Newton iteration on the exact residuals at points of
the positive real line, which gains some ten digits a step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from flint import fmpq
from numpy.typing import NDArray
from scipy.optimize import least_squares

from posreal.admittance import Rational
from posreal.admittance.exact import to_float, to_fmpq, to_fraction
from posreal.errors import BadInput
from posreal.network import Network
from posreal.realise.elements import revalued
from posreal.realise.long import shortened
from posreal.realise.proof import corners

STARTS = 4
REACHED = 1e-9  # misfit of the float stage that makes the exact one worth trying
LARGEST_LOG = 300.0  # values beyond e^±300 are no elements


@dataclass(frozen=True)
class Limits:
    """Least and greatest stiffness (N/m), damping (N s/m) and inertance (kg) that can be built."""

    k_min: float = 0.0
    k_max: float = math.inf
    c_min: float = 0.0
    c_max: float = math.inf
    b_min: float = 0.0
    b_max: float = math.inf

    def __post_init__(self) -> None:
        for kind in "kcb":
            low, high = self.of(kind)
            if not 0 <= low < high:
                raise BadInput(f"{kind}_min = {low:g} and {kind}_max = {high:g} leave no value; give 0 ≤ min < max.")

    def of(self, kind: str) -> tuple[float, float]:
        """(least, greatest) for "k", "c" or "b"."""
        return getattr(self, f"{kind}_min"), getattr(self, f"{kind}_max")

    def logs(self, kinds: list[str]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The same as logarithms, for a list of kinds."""
        with np.errstate(divide="ignore"):
            low, high = np.log(np.array([self.of(kind) for kind in kinds]).T)
        return low, high

    def broken_by(self, network: Network) -> str | None:
        """What a network asks for that cannot be built, or None; a float's last digits are forgiven."""
        for name, part in zip(network.names, network.elements(), strict=True):
            if part.letter in "kcb":
                low, high = self.of(part.letter)
                value = float(part.exact)
                if value < low * (1 - 1e-12) or value > high * (1 + 1e-12):
                    return f"{name} = {value:.4g} {part.unit} is outside {low:.4g} to {high:.4g}"
        return None


def fitted(
    topology: Network,
    y: Rational,
    omega: NDArray[np.float64],
    *,
    limits: Limits | None = None,
    starts: int = STARTS,
    seed: int = 0,
    enough: float = REACHED,
) -> tuple[Network, float]:
    """The best-fitting values found and the largest |Y_network/Y − 1| over the frequencies `omega`.

    Parameters
    ----------
    topology : Network
        Values, if any, are ignored.
    y : Rational
        The device.
    omega : array
        Frequencies in rad/s, ascending.
    limits : Limits, optional
        Least and greatest values of each kind of element.
    starts, seed : int
        How many starts, drawn about the device's own size from this seed.
    enough : float
        Misfit with which to stop trying further starts.
    """
    s, wanted = 1j * omega, y(1j * omega)
    rng = np.random.default_rng(seed)
    kinds = [part.letter for part in topology.elements()]
    power = np.array(["bck".index(kind) - 1 for kind in kinds])  # value ~ |Y| ω^power
    centre = np.mean(np.log(np.abs(wanted))) + power * np.mean(np.log(omega))
    width = 1 + np.log(omega[-1] / omega[0]) / 12
    low, high = (limits or Limits()).logs(kinds)

    def values_of(logs: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.exp(np.clip(logs, -LARGEST_LOG, LARGEST_LOG))

    def misfit(logs: NDArray[np.float64]) -> NDArray[np.float64]:
        ratio = topology.evaluate(values_of(logs), s)[0] / wanted - 1
        return np.concatenate([ratio.real, ratio.imag])

    def slope(logs: NDArray[np.float64]) -> NDArray[np.float64]:
        change = topology.evaluate(values_of(logs), s)[1] / wanted
        return np.concatenate([change.real, change.imag], axis=1).T

    bounded = bool(np.any(np.isfinite([low, high])))
    best, least = centre, np.inf
    for _ in range(starts):
        guess = np.clip(centre + rng.normal(0, width, len(kinds)), low + 1e-9, high - 1e-9)
        found = least_squares(
            misfit,
            guess,
            slope,
            bounds=(low, high),
            method="trf" if bounded else "lm",
            xtol=1e-14,
            ftol=1e-14,
            gtol=1e-14,
            max_nfev=80,
        )
        worst = float(np.max(np.abs(found.fun))) if np.all(np.isfinite(found.fun)) else np.inf
        if worst < least and np.all(np.abs(found.x) < LARGEST_LOG):
            best, least = found.x, worst
        if least < enough:
            break
    values = iter(values_of(best))
    network = revalued(topology, lambda _: Fraction(float(next(values))))
    return network, float(np.max(np.abs(network(s) / wanted - 1)))


def sharpened(network: Network, y: Rational, bits: int = 400, steps: int = 60) -> Network | None:
    """Values to many digits from values to a few, or None if the network does not have this admittance."""
    low, high = corners(y)
    count = len(network) + 3
    points = [to_fmpq(low * 30 * (high / low / 900) ** (i / (count - 1))) for i in range(count)]
    wanted = [y.n(s) / y.d(s) for s in points]
    at = np.array([to_float(s) for s in points])
    slope = (network.sensitivities(at) / network(at)).real.T
    inverse = np.linalg.pinv(slope, rcond=1e-10)
    last = np.inf
    for _ in range(steps):
        found = network.admittance()
        residual = np.array([to_float(found.n(s) / found.d(s) / w - 1) for s, w in zip(points, wanted, strict=True)])
        size = float(np.max(np.abs(residual)))
        if size < 1e-60:
            return network
        if size > last / 2 and last < 1e-3:
            return None
        last = size
        step = iter(inverse @ residual)
        network = revalued(network, lambda part, step=step: _moved(part.exact, float(next(step)), bits))  # type: ignore[misc]
    return None


def _moved(value: Fraction, step: float, bits: int) -> Fraction:
    exact = fmpq(value.numerator, value.denominator)
    return to_fraction(shortened(exact * (1 - to_fmpq(max(min(step, 0.5), -0.5))), bits))
