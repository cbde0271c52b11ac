"""Mean squares by frequency: J² = ∫ |z(jω)|² S dω over a band, and the paper's own sum.

The integrand has resonances (narrow on a logarithmic axis) and the ripple of the wheel delays (even on a linear
one, with period 2π/τ). The rule is Gauss–Legendre on panels that are no wider than either allows.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from posreal.plant.plant import Complex, Real

BAND = 40 * math.pi
"""Upper end of the paper's band, rad/s (20 Hz)."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True)
class Quadrature:
    """Nodes `omega` (N,) in rad/s and `weight` (N,): ∫ f dω ≈ Σ weight f(omega)."""

    omega: Real
    weight: Real

    def rms(self, z: Complex, density: float) -> float:
        """√(∫ |z|² S dω)."""
        return math.sqrt(density * float(self.weight @ np.abs(z) ** 2))


def gauss(longest_delay: float, *, start: float = 0.0, stop: float = BAND, per_decade: int = 12) -> Quadrature:
    """Gauss–Legendre panels for an integrand with delays up to `longest_delay` (s) on [start, stop] rad/s.

    Parameters
    ----------
    longest_delay : float
        Panels are at most 2π/longest_delay wide, so that 8 nodes see the ripple.
    start, stop : float
        The band; `start` may be 0.
    per_decade : int
        Panels a decade where the logarithmic spacing is the finer one.
    """
    low = max(start, stop * 1e-5)
    count = max(2, math.ceil(per_decade * math.log10(stop / low)) + 1)
    edges = [np.geomspace(low, stop, count)]
    if longest_delay > 0:
        ripple = 2 * math.pi / longest_delay
        edges.append(np.linspace(low, stop, math.ceil((stop - low) / ripple) + 1))
    if start < low:
        edges.append(np.array([start]))
    edge = np.unique(np.concatenate(edges))
    half, middle = np.diff(edge) / 2, (edge[1:] + edge[:-1]) / 2
    return Quadrature((middle[:, None] + half[:, None] * _NODES).ravel(), (half[:, None] * _WEIGHTS).ravel())


def lateral_sum() -> Quadrature:
    """The sum of [Jiang2012] for J1y: Δω Σ over ω = 0.01, 0.02, … up to 40π rad/s."""
    step = 0.01
    omega = step * np.arange(1, math.floor(BAND / step + 1e-9) + 1)
    return Quadrature(omega, np.full(len(omega), step))


def refined(mean_square: Callable[[int], float], *, tolerance: float = 1e-9) -> float:
    """Mean square with panels halved until it is settled to `tolerance`, for devices with sharp resonances.

    Parameters
    ----------
    mean_square : function of the number of panels a decade
    tolerance : float
        Relative change that counts as settled. Halving stops at 1536 panels a decade: a resonance narrower than
        that has a quality factor beyond any mechanical damper's, and its whole-band figure should be asked for.
    """
    panels = 12
    value = mean_square(panels)
    while panels < 1536:
        panels *= 2
        finer = mean_square(panels)
        if abs(finer - value) <= tolerance * abs(finer):
            return finer
        value = finer
    return value


def whole_line(
    scale: float, *, longest_delay: float = 0.0, ripple: float = math.inf, per_decade: int = 12
) -> Quadrature:
    """Gauss–Legendre panels for 0 < ω < ∞, for integrands that fall off like 1/ω² or faster.

    Six decades around `scale` (rad/s) in logarithmic panels, and the rest of the axis by ω → 1/ω.

    Parameters
    ----------
    scale : float
    longest_delay : float
        Seconds; its ripple is followed up to `ripple` (rad/s), where what it does beyond averages out.
    ripple : float
    per_decade : int
    """
    top = scale * 1e3
    x, weight = (_NODES + 1) / 2, _WEIGHTS / 2  # ω = top/x on (top, ∞)
    parts = [gauss(longest_delay, stop=min(ripple, top), per_decade=per_decade)]
    if ripple < top:
        parts.append(gauss(0.0, start=ripple, stop=top, per_decade=per_decade))
    parts.append(Quadrature(top / x, weight * top / x**2))
    return Quadrature(np.concatenate([p.omega for p in parts]), np.concatenate([p.weight for p in parts]))
