"""Mean squares by frequency: J² = ∫ |z(jω)|² S dω over a band, and the paper's own sum.

The integrand has resonances (narrow on a logarithmic axis) and the ripple of the wheel delays (even on a linear
one, with period 2π/τ). The rule is Gauss–Legendre on panels that are no wider than either allows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from posreal.plant.plant import Complex, Real

BAND = 40 * math.pi
"""Upper end of the paper's band, rad/s (20 Hz)."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_FINE, _FINE_WEIGHTS = np.polynomial.legendre.leggauss(16)
CLEAR = 1.6
"""Half-widths from a panel's middle to the next pole."""
_PHASE = 8.0  # rad, of the delays' ripple over half a panel


@dataclass(frozen=True, eq=False)
class Quadrature:
    """Nodes `omega` (N,) in rad/s and `weight` (N,): ∫ f dω ≈ Σ weight f(omega)."""

    omega: Real
    weight: Real

    def rms(self, z: Complex, density: float) -> float:
        """√(∫ |z|² S dω)."""
        return math.sqrt(density * float(self.weight @ np.abs(z) ** 2))


@lru_cache(maxsize=256)
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


@lru_cache(maxsize=1)
def lateral_sum() -> Quadrature:
    """The sum of [Jiang2012] for J1y: Δω Σ over ω = 0.01, 0.02, … up to 40π rad/s."""
    step = 0.01
    omega = step * np.arange(1, math.floor(BAND / step + 1e-9) + 1)
    return Quadrature(omega, np.full(len(omega), step))


def placed(
    poles: Complex, longest_delay: float, start: float, stop: float, corners: Sequence[float] = (), clear: float = CLEAR
) -> Quadrature:
    """Gauss–Legendre panels on [start, stop] rad/s for an integrand whose poles are known, settled to rounding.

    A panel is halved until every pole keeps a distance of 1.6 half-widths from its middle: in that ellipse 16 nodes
    leave an error below 1e-14 of the integrand's size, so a resonance of any sharpness gets panels of its own. The
    ripple of the delays stays within what 16 nodes integrate exactly.

    Parameters
    ----------
    poles : (n,) complex, rad/s
        Of the response; its square has their mirror images as well, at the same distances.
    longest_delay : float
        Seconds.
    start, stop : float
    corners : sequence of float
        rad/s, where the integrand is not smooth: no panel goes across. Panels then go down to `start` by powers of two.
    clear : float
        Half-widths from a panel's middle to the next pole.
    """
    low = max(start, stop * 1e-3)
    edge = [np.array([start]), np.geomspace(low, stop, max(2, math.ceil(math.log2(stop / low)) + 1))]
    if longest_delay > 0:
        edge.append(np.linspace(start, stop, math.ceil((stop - start) * longest_delay / (2 * _PHASE)) + 1))
    if len(corners):
        inside = np.array([corner for corner in corners if start < corner < stop])
        edge += (
            [inside, np.geomspace(start, low, max(1, math.ceil(math.log2(low / start))) + 1)] if start > 0 else [inside]
        )
    edges = np.unique(np.concatenate(edge))
    a, b = edges[:-1], edges[1:]
    kept: list[Real] = []
    near = poles[poles.imag >= 0]
    while len(a):
        half, middle = (b - a) / 2, (b + a) / 2
        close = np.abs(np.subtract.outer(1j * middle, near)).min(axis=1, initial=math.inf) < clear * half
        close &= half > 1e-13 * middle
        kept.append(np.stack([middle[~close], half[~close]]))
        middle, a, b = middle[close], a[close], b[close]
        a, b = np.concatenate([a, middle]), np.concatenate([middle, b])
    middle, half = np.concatenate(kept, axis=1)
    return Quadrature((middle[:, None] + half[:, None] * _FINE).ravel(), (half[:, None] * _FINE_WEIGHTS).ravel())


def beyond(poles: Complex, start: float) -> Quadrature:
    """The same on [start, ∞) by ω = start/x, for an integrand without delays that falls off like 1/ω² or faster."""
    inner = placed(start / poles[poles != 0].conj(), 0.0, 0.0, 1.0)
    return Quadrature(start / inner.omega, inner.weight * start / inner.omega**2)


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
