"""Re Y(jω) = E(x)/D(x), x = ω²: the power a device takes in, as an exact function of x.

With n = a(s²) + s b(s²) and d = c(s²) + s e(s²):  E(x) = a c + x b e,  D(x) = c² + x e²  at s² = −x.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from flint import arb, fmpq, fmpq_poly

from posreal.admittance import exact, roots
from posreal.admittance.rational import Rational

X = fmpq_poly([0, 1])


@dataclass(frozen=True)
class Minimum:
    """The least value of Re Y(jω), and x = ω² where it is attained (None at infinity).

    The value is rational, or an infinite float.
    """

    value: fmpq | float
    x: fmpq | None

    @property
    def inside(self) -> bool:
        """Whether it lies at a frequency that is neither 0 nor infinite."""
        return self.x is not None and self.x != 0

    @property
    def omega(self) -> float:
        """The frequency as a float, rad/s."""
        return math.inf if self.x is None else math.sqrt(exact.to_float(self.x))

    @property
    def rank(self) -> tuple[float, fmpq]:
        """Orders exactly by value, infinities included."""
        return (self.value, fmpq(0)) if isinstance(self.value, float) else (0.0, self.value)


def real_part(device: Rational) -> tuple[fmpq_poly, fmpq_poly]:
    """(E, D) with Re Y(jω) = E(ω²)/D(ω²) and D = |d(jω)|² ≥ 0, common factors kept."""
    minus = fmpq_poly([0, -1])
    a, b = exact.even_part(device.n)(minus), exact.odd_part(device.n)(minus)
    c, e = exact.even_part(device.d)(minus), exact.odd_part(device.d)(minus)
    return a * c + X * b * e, c * c + X * e * e


def coprime(E: fmpq_poly, D: fmpq_poly) -> tuple[fmpq_poly, fmpq_poly]:
    """The same fraction without the factors that poles on the axis leave in both."""
    common = E.gcd(D)
    return E // common, D // common


def is_nonnegative(E: fmpq_poly) -> bool:
    """E(x) ≥ 0 for all x > 0: the leading sign is right and no root there is of odd multiplicity."""
    if E.degree() < 0:
        return True
    return bool(E.leading_coefficient() > 0) and not roots.positive_roots(E, odd_only=True)


def minimum(E: fmpq_poly, D: fmpq_poly) -> Minimum:
    """The least value of the coprime fraction E/D over 0 ≤ x ≤ ∞; −inf where it falls without limit.

    The place is exact to the ball-arithmetic precision in force (at least 128 bits); the value, being
    stationary there, to twice that.
    """
    places = ends(E, D)
    for x, power in roots.positive_roots(D):
        falls = power % 2 == 1 or E(roots.midpoint(x)) < 0
        places.append(Minimum(-math.inf if falls else math.inf, roots.midpoint(x)))
    slope = E.derivative() * D - E * D.derivative()
    if slope.degree() > 0:
        points = [roots.midpoint(x) for x, _ in roots.positive_roots(slope)]
        places += [Minimum(E(x) / D(x), x) for x in points if D(x) != 0]
    return min(places, key=lambda place: place.rank)


def ends(E: fmpq_poly, D: fmpq_poly) -> list[Minimum]:
    """E/D at x = 0 and at infinity."""
    return [Minimum(_at_zero(E, D), fmpq(0)), Minimum(_at_infinity(E, D), None)]


def touches(E: fmpq_poly) -> tuple[float, ...]:
    """Frequencies 0 < ω < ∞ (rad/s) where E is zero."""
    return tuple(_omega(x) for x, _ in roots.positive_roots(E)) if E.degree() >= 0 else ()


def negative_frequency(E: fmpq_poly) -> fmpq:
    """The simplest rational ω well inside a band where E(ω²) < 0, the one where E is lowest.

    Raises
    ------
    ValueError
        If there is no such band.
    """
    crossings = roots.positive_roots(E, odd_only=True)
    best: tuple[fmpq, fmpq] | None = None
    for low, high in _bands([ball for ball, _ in crossings]):
        omega = roots.simplest_between((3 * low + high) / 4, (low + 3 * high) / 4)
        while E(omega * omega) == 0:  # a zero of even multiplicity, of which there are few, is no crossing
            low, high = (omega, high) if high - omega > omega - low else (low, omega)
            omega = roots.simplest_between((3 * low + high) / 4, (low + 3 * high) / 4)
        value = E(omega * omega)
        if value < 0 and (best is None or value < best[0]):
            best = value, omega
    if best is None:
        raise ValueError("Re Y is nowhere negative")
    return best[1]


def is_regular(E: fmpq_poly, D: fmpq_poly) -> bool:
    """Whether the least value of E/D ≥ 0 is attained at ω = 0 or ∞."""
    ends = []
    if D[0] != 0:
        ends.append(E[0] / D[0])
    if D.degree() > E.degree():
        ends.append(fmpq(0))
    elif D.degree() == E.degree():
        ends.append(E.leading_coefficient() / D.leading_coefficient())
    return bool(ends) and is_nonnegative(E - min(ends) * D)


def _bands(crossings: list[arb]) -> list[tuple[fmpq, fmpq]]:
    """Rational intervals of ω inside each band between crossings (given in x = ω²)."""
    if not crossings:
        return [(fmpq(1, 2), fmpq(3, 2))]

    def attempt() -> list[tuple[fmpq, fmpq]] | None:
        frequencies = [x.sqrt() for x in crossings]
        ends = [fmpq(0)]
        for w in frequencies:
            ends += [roots.lower_end(w), roots.upper_end(w)]
        ends.append(2 * ends[-1])
        bands = list(zip(ends[0::2], ends[1::2], strict=True))
        return bands if all(low < high for low, high in bands) else None

    return roots.settle(attempt)


def _omega(x: arb) -> float:
    return float(x.sqrt())


def _at_zero(E: fmpq_poly, D: fmpq_poly) -> fmpq | float:
    if D[0] != 0:
        return E[0] / D[0]
    return math.inf if E[0] > 0 else -math.inf


def _at_infinity(E: fmpq_poly, D: fmpq_poly) -> fmpq | float:
    if E.degree() > D.degree():
        return math.inf if E.leading_coefficient() > 0 else -math.inf
    return E.leading_coefficient() / D.leading_coefficient() if E.degree() == D.degree() else fmpq(0)
