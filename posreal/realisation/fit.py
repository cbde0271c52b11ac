"""Element values of a given network for a given admittance: least Σ |Y_network(jω)/Y(jω) − 1|².

Over the logarithms of the values, in floats, from several starts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from posreal.admittance import Rational
from posreal.errors import BadInput
from posreal.network import Network
from posreal.realisation.elements import revalued

STARTS = 2  # besides the values given
STEPS = 80  # evaluations a start may take
REACHED = 1e-9  # misfit with which to stop trying further starts
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
    network: Network, y: Rational, omega: NDArray[np.float64], limits: Limits | None = None, seed: int = 0
) -> Network:
    """The network with the best-fitting values found.

    Parameters
    ----------
    network : Network
        With values to begin the first start from.
    y : Rational
        The device.
    omega : array
        Frequencies in rad/s, ascending.
    limits : Limits, optional
        Least and greatest values of each kind of element.
    seed : int
        Of the other starts, drawn about the device's own size.
    """
    s, wanted, response = 1j * omega, np.asarray(y(1j * omega)), network.response
    rng = np.random.default_rng(seed)
    kinds = [part.letter for part in network.elements()]
    middle = centre(kinds, wanted, omega)
    low, high = (limits or Limits()).logs(kinds)

    def values_of(logs: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.exp(np.clip(logs, -LARGEST_LOG, LARGEST_LOG))

    def misfit(logs: NDArray[np.float64]) -> NDArray[np.float64]:
        ratio = response(values_of(logs), s) / wanted - 1
        return np.concatenate([ratio.real, ratio.imag])

    def slope(logs: NDArray[np.float64]) -> NDArray[np.float64]:
        change = response.evaluate(values_of(logs), s)[1] / wanted
        return np.concatenate([change.real, change.imag], axis=1).T

    from scipy.optimize import least_squares  # slow to import, and most networks need no fit

    bounded = bool(np.any(np.isfinite([low, high])))
    best, least = middle, np.inf
    guesses = [np.log([float(part.exact) for part in network.elements()])]
    guesses += [middle + rng.normal(0, width(omega), len(kinds)) for _ in range(STARTS)]
    for guess in guesses:
        found = least_squares(
            misfit,
            np.clip(guess, low + 1e-9, high - 1e-9),
            slope,
            bounds=(low, high),
            method="trf" if bounded else "lm",
            xtol=1e-14,
            ftol=1e-14,
            gtol=1e-14,
            max_nfev=STEPS,
        )
        worst = float(np.max(np.abs(found.fun))) if np.all(np.isfinite(found.fun)) else np.inf
        if worst < least and np.all(np.abs(found.x) < LARGEST_LOG):
            best, least = found.x, worst
        if least < REACHED:
            break
    values = iter(values_of(best))
    return revalued(network, lambda _: Fraction(float(next(values))))


def centre(kinds: list[str], wanted: NDArray[np.complex128], omega: NDArray[np.float64]) -> NDArray[np.float64]:
    """Logarithms of the values with which elements are of the device's size amid the band."""
    power = np.array(["bck".index(kind) - 1 for kind in kinds])  # value ~ |Y| ω^power
    middle: NDArray[np.float64] = np.mean(np.log(np.abs(wanted))) + power * np.mean(np.log(omega))
    return middle


def width(omega: NDArray[np.float64]) -> float:
    """How widely starts are spread about there."""
    return float(1 + np.log(omega[-1] / omega[0]) / 12)
