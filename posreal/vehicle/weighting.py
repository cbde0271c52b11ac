"""Frequency weightings: how much an acceleration of a frequency disturbs a passenger, as exact rational filters.

    W(s) = Hh Hl Ht Hs,     ωᵢ = 2π fᵢ
    Hh = s²/(s² + (ω1/Q1) s + ω1²)                    Hl = ω2²/(s² + (ω2/Q1) s + ω2²)
    Ht = (1 + s/ω3)/(1 + s/(Q4 ω4) + s²/ω4²)          Hs = κ (1 + s/(Q5 ω5) + s²/ω5²)/(1 + s/(Q6 ω6) + s²/ω6²)

Wb of [EN12299] is not that of [ISO2631]: 13 % more at 16 Hz, 8 % less at 4 Hz. Parameters as used for EN 12299:2009;
the others are those of [ISO8041]. Sperling's weighting B(f) is given as a fraction in f; it is the modulus of

    B = k (√1.911 p + 0.25 p²)/(1 + 1.563 p + 0.277 p² + 0.0368 p³),     p = s/2π   [Sperling1956]
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from posreal.admittance import Rational, exact
from posreal.errors import BadInput, hint, shown
from posreal.plant.plant import Complex, Plant
from posreal.plant.shaping_filter import ShapingFilter, cascade, section

_Q = 1 / math.sqrt(2)


@dataclass(frozen=True)
class _Parameters:
    """f in Hz; no step where `f5` is 0."""

    f3: float
    f4: float
    Q4: float
    source: str
    f5: float = 0.0
    Q5: float = 1.0
    f6: float = 0.0
    Q6: float = 1.0
    kappa: float = 1.0
    f1: float = 0.4
    f2: float = 100.0


_KNOWN = {
    "Wb": _Parameters(16, 16, 0.63, "EN12299, 2009", 2.5, 0.8, 4, 0.8, 0.4),
    "Wb-iso": _Parameters(16, 16, 0.55, "ISO2631, part 4", 2.5, 0.9, 4, 0.95, 0.4),
    "Wk": _Parameters(12.5, 12.5, 0.63, "ISO8041", 2.37, 0.91, 3.35, 0.91, (2.37 / 3.35) ** 2),
    "Wd": _Parameters(2, 2, 0.63, "ISO8041"),
    "Wc": _Parameters(8, 8, 0.63, "ISO8041"),
    "We": _Parameters(1, 1, 0.63, "ISO8041"),
}
NAMES = tuple(_KNOWN)
WEIGHTED, SPERLING = "weighted track", "track after Sperling"
"""Load cases: the random track, body accelerations behind the vehicle's weighting or behind Sperling's."""


@dataclass(frozen=True)
class Weighting:
    """A weighting by name: ``Wb`` (EN 12299), ``Wb-iso``, ``Wk``, ``Wd``, ``Wc`` or ``We``.

    Calling it gives W(s) at complex points, rad/s.

    Raises
    ------
    BadInput
        For a name that is none.

    Examples
    --------
    >>> weighting = Weighting("Wb")
    >>> round(float(weighting.gain(10.0)), 4)
    1.0484
    """

    name: str

    def __post_init__(self) -> None:
        if self.name not in _KNOWN:
            raise BadInput(f"no weighting is called {shown(self.name)}; {hint(self.name, _KNOWN)}")

    def __str__(self) -> str:
        return self.name

    @property
    def source(self) -> str:
        """Reference of its parameters."""
        return _KNOWN[self.name].source

    @cached_property
    def filter(self) -> ShapingFilter:
        """W as a state space of 6 or 8 states."""
        return _filter(self.name)

    @cached_property
    def rational(self) -> Rational:
        """W exactly, as the transfer function of the filter's floats."""
        H = self.filter
        n, d = exact.transfer_function(
            exact.matrix(H.A), exact.matrix(H.B), exact.matrix(H.C), exact.to_fmpq(float(H.D[0, 0]))
        )
        return Rational(n, d)

    def __call__(self, s: Complex) -> Complex:
        """W at complex `s`, rad/s, shape preserved."""
        return self.filter(s)

    def gain(self, hertz: np.ndarray | float) -> np.ndarray:
        """|W| at frequencies in Hz."""
        return np.asarray(np.abs(self.filter(2j * np.pi * np.asarray(hertz, dtype=float))))


@lru_cache
def _filter(name: str) -> ShapingFilter:
    of = _KNOWN[name]
    w1, w2, w3, w4 = (2 * math.pi * f for f in (of.f1, of.f2, of.f3, of.f4))
    parts = [
        section((w4**2, w4**2 / w3, 0.0), (w4**2, w4 / of.Q4, 1.0)),
        section((w2**2, 0.0, 0.0), (w2**2, w2 / _Q, 1.0)),
        section((-(w1**2), -w1 / _Q, 1.0), (w1**2, w1 / _Q, 1.0)),
    ]
    if of.f5:
        w5, w6 = 2 * math.pi * of.f5, 2 * math.pi * of.f6
        step = of.kappa * (w6 / w5) ** 2
        top = (step * (w5**2 - w6**2), step * (w5 / of.Q5 - w6 / of.Q6), step)
        parts.insert(0, section(top, (w6**2, w6 / of.Q6, 1.0)))
    return cascade(parts)


@lru_cache
def sperling(factor: float) -> ShapingFilter:
    """Sperling's comfort weighting, `factor` 0.588 vertical and 0.737 lateral, of accelerations at any frequency."""
    a3, a2, a1 = (value / (2 * math.pi) ** n for value, n in ((0.0368, 3), (0.277, 2), (1.563, 1)))
    b2, b1 = factor * 0.25 / (2 * math.pi) ** 2, factor * math.sqrt(1.911) / (2 * math.pi)
    roots = np.roots([a3, a2, a1, 1.0])
    (real,) = roots[np.abs(roots.imag) < 1e-9 * np.abs(roots)].real
    pair = roots[roots.imag > 0][0]
    slow, fast = float(-real), (float(abs(pair) ** 2), float(-2 * pair.real))
    a0, slope = fast
    top = (-b2 / a3 * a0, b1 / a3 - b2 / a3 * slope, b2 / a3)
    return cascade([section((1.0, 0.0), (slow, 1.0)), section(top, (a0, slope, 1.0))])


def filtered(plant: Plant, through: ShapingFilter, outputs: tuple[str, ...]) -> Plant:
    """A plant of some of its outputs, each behind a filter; see :mod:`posreal.plant.shaping_filter`."""
    rows = [plant.output(name) for name in outputs]
    shaping = through if plant.shaping is None else plant.shaping.then(through)
    return replace(plant, Cz=plant.Cz[rows], Dzw=plant.Dzw[rows], Dzf=plant.Dzf[rows], outputs=outputs, shaping=shaping)
