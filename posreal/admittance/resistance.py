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
    """The least value of Re Y(jω) over 0 ≤ ω ≤ ∞ and the frequency (rad/s) where it is attained."""

    value: float
    omega: float


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
    """The least value of the coprime fraction E/D over 0 ≤ x ≤ ∞; −inf where it falls without limit."""
    candidates: list[tuple[arb, float]] = [(_at_zero(E, D), 0.0)]
    candidates += [(_beside_pole(E, x, power), _omega(x)) for x, power in roots.positive_roots(D)]
    slope = E.derivative() * D - E * D.derivative()
    with roots.precision(roots.FIRST_PRECISION):
        if slope.degree() > 0:
            candidates += [(_ratio(E, D, x), _omega(x)) for x, _ in roots.positive_roots(slope)]
        candidates.append((_at_infinity(E, D), math.inf))
        value, omega = min(candidates, key=lambda pair: float(pair[0]))
    return Minimum(float(value), omega)


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


def _ratio(E: fmpq_poly, D: fmpq_poly, x: arb) -> arb:
    point = roots.midpoint(x)
    bottom = D(point)
    return arb(E(point) / bottom) if bottom != 0 else arb(E(point)) * math.inf


def _beside_pole(E: fmpq_poly, x: arb, power: int) -> arb:
    """Where D is zero and E is not: ±infinity by E's sign, and both if D changes sign."""
    return arb(math.inf) if power % 2 == 0 and E(roots.midpoint(x)) > 0 else arb(-math.inf)


def _at_zero(E: fmpq_poly, D: fmpq_poly) -> arb:
    if D[0] != 0:
        return arb(E[0] / D[0])
    return arb(math.inf) if E[0] > 0 else arb(-math.inf)


def _at_infinity(E: fmpq_poly, D: fmpq_poly) -> arb:
    if E.degree() > D.degree():
        return arb(math.inf) if E.leading_coefficient() > 0 else arb(-math.inf)
    return arb(E.leading_coefficient() / D.leading_coefficient()) if E.degree() == D.degree() else arb(0)
