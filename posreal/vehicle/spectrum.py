"""Spectra of track irregularity over the wavelength, one-sided, and rational filters that have them.

    variance of the profile = ∫₀^∞ S(Ω) dΩ,     S in m²/(rad/m),  Ω = 2π/λ in rad/m,  n = Ω/2π in 1/m,  S_n = 2π S(2πn)

At speed V the profile is shaken out at ω = Ω V with S(ω/V)/V per rad/s. A law that is a fraction in Ω², g Π(Ω² + z²)/
Π(Ω² + p²), is the density of white noise through √(g V^{2(np−nz)−1}) Π(s + zV)/Π(s + pV), exactly; of any other law a
fraction that comes near it has to be found, and its error is said in dB.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Protocol

import numpy as np
from scipy.integrate import quad
from scipy.optimize import least_squares

from posreal.admittance import Rational, exact
from posreal.errors import BadInput, Unsettled
from posreal.plant.figures import settled
from posreal.plant.plant import Real
from posreal.plant.shaping_filter import ShapingFilter, cascade, section

_POINTS = 400  # of a fit, evenly over ln Ω
_STARTS, _SEED = 12, 1
_GOOD_DB = 0.35  # r.m.s. error at which a fraction of fewer poles is kept
_ORDERS = ((1, 3), (2, 4), (3, 5))  # zeros and poles that are tried in turn
_EVERYWHERE = (0.01, 1e7)  # m: less than 1e-6 of a ride lies outside at any speed of a train
ERRI = (0.0206, 0.8246)
"""Corners Ωr and Ωc of the spectra of [ERRI1989], rad/m."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)


class Law(Protocol):
    """S as a function of Ω > 0, hashable."""

    def __hash__(self) -> int: ...

    def __call__(self, Omega: Real) -> Real:
        """m²/(rad/m) at each Ω, rad/m."""

    @property
    def corners(self) -> tuple[float, ...]:
        """Ω at which it is not smooth, rad/m."""


@dataclass(frozen=True)
class RationalLaw:
    """gain Π(Ω² + z²)/Π(Ω² + p²); poles and zeros in rad/m, a pole may be 0."""

    gain: float
    zeros: tuple[float, ...]
    poles: tuple[float, ...]
    corners: tuple[float, ...] = ()

    def __call__(self, Omega: Real) -> Real:
        """m²/(rad/m) at each Ω, rad/m."""
        x = np.asarray(Omega, dtype=float) ** 2
        value = np.full_like(x, self.gain)
        for zero in self.zeros:
            value = value * (x + zero**2)
        for pole in self.poles:
            value = value / (x + pole**2)
        return value

    def least_derivative(self) -> int:
        """The least derivative of the profile, with respect to time, that has a filter without an integrator."""
        return self.poles.count(0.0)

    def filter(self, speed: float, derivative: int) -> tuple[ShapingFilter | None, float]:
        """White noise of single-sided density 1 per rad/s to a derivative of the profile at `speed`, m/s.

        Returns
        -------
        ShapingFilter or None, and the density by which its output is multiplied: where no pole is left, the derivative
        is white by itself.

        Raises
        ------
        ValueError
            If that derivative has an integrator left, or grows without end.
        """
        integrators = self.poles.count(0.0)
        differentiators = derivative - integrators
        poles = [pole * speed for pole in self.poles if pole > 0]
        zeros = [0.0] * differentiators + [zero * speed for zero in self.zeros]
        if differentiators < 0 or len(zeros) > len(poles):
            raise ValueError(f"no filter has derivative {derivative} of this spectrum")
        power = 2 * (len(self.poles) - len(self.zeros)) - 1
        gain = self.gain * speed**power
        if not poles:
            return None, gain
        # real poles: first-order sections, each with a zero or none, the gain in the first
        parts = []
        root = math.sqrt(gain)
        for i, pole in enumerate(sorted(poles)):
            if i < len(zeros):
                zero = sorted(zeros)[i]
                parts.append(section((root * (zero - pole), root), (pole, 1.0)))
            else:
                parts.append(section((root, 0.0), (pole, 1.0)))
            root = 1.0
        return cascade(parts), 1.0


@dataclass(frozen=True)
class PowerLaw:
    """S_n = A n^−k in mm²/(1/m), of another A and k in each interval between `breaks`, 1/m."""

    breaks: tuple[float, ...]
    A: tuple[float, ...]
    k: tuple[float, ...]

    @property
    def corners(self) -> tuple[float, ...]:
        """Ω at which it is not smooth, rad/m."""
        return tuple(2 * math.pi * n for n in self.breaks)

    def __call__(self, Omega: Real) -> Real:
        """m²/(rad/m) at each Ω, rad/m."""
        n = np.asarray(Omega, dtype=float) / (2 * np.pi)
        piece = np.searchsorted(self.breaks, n)
        return np.asarray(1e-6 * np.array(self.A)[piece] * n ** -np.array(self.k)[piece] / (2 * np.pi))


@dataclass(frozen=True)
class HyperbolicLaw:
    """S_n = A/(1 + n/n0)³, A in m²/(1/m), n0 in 1/m."""

    A: float
    n0: float
    corners: tuple[float, ...] = ()

    def __call__(self, Omega: Real) -> Real:
        """m²/(rad/m) at each Ω, rad/m."""
        n = np.asarray(Omega, dtype=float) / (2 * np.pi)
        return np.asarray(self.A / (1 + n / self.n0) ** 3 / (2 * np.pi))


@dataclass(frozen=True)
class TableLaw:
    """Values at Ω (rad/m), straight in ln S over ln Ω between them and on from the last ones."""

    Omega: tuple[float, ...]
    S: tuple[float, ...]

    @property
    def corners(self) -> tuple[float, ...]:
        """Ω at which it is not smooth, rad/m."""
        return self.Omega

    def __call__(self, Omega: Real) -> Real:
        """m²/(rad/m) at each Ω, rad/m."""
        return np.asarray(np.exp(np.interp(np.log(Omega), np.log(self.Omega), np.log(self.S))))


@dataclass(frozen=True)
class Fit:
    """A fraction that comes near a law: r.m.s. and largest error over the band, in dB of S."""

    law: RationalLaw
    rms_db: float
    max_db: float


@dataclass(frozen=True)
class Spectrum:
    """A law with the wavelengths for which it is stated.

    Attributes
    ----------
    law : Law
    band : (float, float)
        The shortest and the longest wavelength, m, for which it is stated.
    ends : bool
        Whether it is nothing outside of the band; otherwise its formula goes on.
    """

    law: Law
    band: tuple[float, float]
    ends: bool = False

    def density(self, Omega: Real) -> Real:
        """S at each Ω > 0 (rad/m), one-sided, m²/(rad/m)."""
        Omega = np.asarray(Omega, dtype=float)
        value = self.law(Omega)
        if not self.ends:
            return value
        low, high = self.support
        return np.where((Omega >= low) & (Omega <= high), value, 0.0)

    @property
    def support(self) -> tuple[float, float]:
        """The least and the greatest Ω, rad/m, at which it is anything that matters."""
        shortest, longest = self.band if self.ends else _EVERYWHERE
        return 2 * math.pi / longest, 2 * math.pi / shortest

    def between(self, shortest: float, longest: float) -> Spectrum:
        """What it has between two wavelengths, m, and nothing else.

        Raises
        ------
        BadInput
            If they are none, or nothing is left.
        """
        if not 0 < shortest < longest < math.inf:
            raise BadInput(f"wavelengths {shortest:g} to {longest:g} m are none; give the shorter first, such as 1:150")
        band = (shortest, longest)
        if self.ends:
            band = max(shortest, self.band[0]), min(longest, self.band[1])
            if band[0] >= band[1]:
                raise BadInput(
                    f"nothing is left between {shortest:g} and {longest:g} m of a spectrum from {self.band[0]:g} to "
                    f"{self.band[1]:g} m"
                )
        return replace(self, band=band, ends=True)

    @property
    def extended(self) -> Spectrum:
        """The same where it is known; beyond, its own law, or ERRI's of the same r.m.s. where it is no formula."""
        if not self.ends:
            return self
        if not isinstance(self.law, TableLaw):
            return replace(self, ends=False)
        shape = Spectrum(RationalLaw(1.0, (), ERRI), self.band, ends=True)
        gain = (self.rms(*self.band) / shape.rms(*self.band)) ** 2
        return Spectrum(RationalLaw(gain, (), ERRI), self.band)

    def rms(self, shortest: float, longest: float) -> float:
        """Root mean square of the profile between two wavelengths, m: by two rules of quadrature that agree."""
        low, high = 2 * math.pi / longest, 2 * math.pi / shortest
        inside = [corner for corner in (*self.law.corners, *self.support) if low < corner < high]
        edges = np.log(np.unique([low, *inside, high]))

        def integrand(x: float) -> float:
            return float(self.density(np.array([math.exp(x)]))[0]) * math.exp(x)

        def adaptive() -> float:
            parts = (quad(integrand, a, b, epsrel=1e-10, limit=400)[0] for a, b in itertools.pairwise(edges))
            return math.sqrt(sum(parts))

        def gauss() -> float:
            panels = np.unique(np.concatenate([np.linspace(a, b, 33) for a, b in itertools.pairwise(edges)]))
            half, middle = np.diff(panels) / 2, (panels[1:] + panels[:-1]) / 2
            x = middle[:, None] + half[:, None] * _NODES
            return math.sqrt(float(np.sum(half[:, None] * _WEIGHTS * self.density(np.exp(x)) * np.exp(x))))

        if not np.any(self.density(np.exp(np.linspace(edges[0], edges[-1], 50)))):
            return 0.0
        return settled("the r.m.s. of the track", (adaptive, gauss)).value

    @property
    def exact(self) -> bool:
        """Whether a rational filter has it exactly."""
        return isinstance(self.law, RationalLaw) and not self.ends

    def fitted(self) -> Fit:
        """The law itself where it is a fraction, or one of few poles that comes near it in its band.

        Raises
        ------
        Unsettled
            If no fit converges.
        """
        if isinstance(self.law, RationalLaw):
            return Fit(self.law, 0.0, 0.0)
        return _fitted(self.law, self.band)

    def shaping(self, speed: float, order: int | None = None, *, derivative: int = 1) -> tuple[Rational, float]:
        """The filter from white noise of density 1 per rad/s to a derivative of the profile, and its error, dB r.m.s.

        Parameters
        ----------
        speed : float
            m/s.
        order : int, optional
            Poles of a fit; as many as it takes by default.
        derivative : int
            1: the velocity of the profile under a wheel; 2: its acceleration.

        Raises
        ------
        BadInput
            Where that derivative has no proper filter without an integrator.
        """
        if not (math.isfinite(speed) and speed > 0):
            raise BadInput(f"speed is {speed:g} m/s; it must be finite and greater than 0")
        whole = order is None or isinstance(self.law, RationalLaw)
        fit = self.fitted() if whole else fitted(self.law, self.band, order or 0)
        try:
            H, density = fit.law.filter(speed, derivative)
        except ValueError:
            raise BadInput(f"derivative {derivative} of this profile has no proper filter; give another") from None
        if H is None:
            return Rational([math.sqrt(density)]), fit.rms_db
        n, d = exact.transfer_function(
            exact.matrix(H.A), exact.matrix(H.B), exact.matrix(H.C), exact.to_fmpq(float(H.D[0, 0]))
        )
        return Rational(n, d), fit.rms_db


@lru_cache(maxsize=32)
def _fitted(law: Law, band: tuple[float, float]) -> Fit:
    found = [_least_squares(law, band, *order) for order in _ORDERS[:1]]
    for order in _ORDERS[1:]:
        if found[-1].rms_db <= _GOOD_DB:
            break
        found.append(_least_squares(law, band, *order))
    return min(found, key=lambda fit: fit.rms_db)


@lru_cache(maxsize=32)
def fitted(law: Law, band: tuple[float, float], poles: int) -> Fit:
    """The fraction of so many poles, and two zeros fewer, that comes nearest to a law in its band.

    Raises
    ------
    BadInput
        For fewer than two poles or more than eight.
    """
    if not 2 <= poles <= 8:
        raise BadInput(f"a fit has from 2 to 8 poles, not {poles}")
    return _least_squares(law, band, poles - 2, poles)


def _least_squares(law: Law, band: tuple[float, float], zeros: int, poles: int) -> Fit:
    """Least squares of ln S over ln Ω in the logarithms of zeros and poles, from several starts."""
    shortest, longest = band
    rough = isinstance(law, TableLaw)  # an estimate, whose own scatter is larger than what more work would gain
    points, starts, steps = (120, 3, 40) if rough else (_POINTS, _STARTS, 200)
    Omega = np.geomspace(2 * math.pi / longest, 2 * math.pi / shortest, points)
    value = law(Omega)
    target, x = np.log(value), Omega**2
    if not np.all(np.isfinite(target)):
        raise Unsettled("a spectrum that is 0 inside its band has no fit")

    def shape(theta: Real) -> Real:
        places = np.exp(2 * theta)
        terms = np.log(x[:, None] + places[None, :])
        return np.asarray(terms[:, :zeros].sum(axis=1) - terms[:, zeros:].sum(axis=1))

    def residual(theta: Real) -> Real:
        off = shape(theta) - target
        return np.asarray(off - off.mean())  # the gain is what is best for the rest

    sign = np.array([1.0] * zeros + [-1.0] * poles)

    def slope(theta: Real) -> Real:
        places = np.exp(2 * theta)
        each = sign * 2 * places / (x[:, None] + places[None, :])
        return np.asarray(each - each.mean(axis=0))

    rng = np.random.default_rng(_SEED)
    low, high = math.log(Omega[0]) - 1.0, math.log(Omega[-1]) + 1.0
    begun = (rng.uniform(low, high, zeros + poles) for _ in range(starts))
    found = [least_squares(residual, start, slope, bounds=(low - 4, high + 4), max_nfev=steps) for start in begun]
    best = min(found, key=lambda one: float(one.cost))
    off = residual(best.x) * 10 / math.log(10)
    gain = math.exp(float((target - shape(best.x)).mean()))
    places = np.exp(best.x)
    fraction = RationalLaw(gain, tuple(map(float, np.sort(places[:zeros]))), tuple(map(float, np.sort(places[zeros:]))))
    return Fit(fraction, float(np.sqrt(np.mean(off**2))), float(np.abs(off).max()))
