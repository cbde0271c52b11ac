"""From a device in floats to one worth writing down: few digits, exactly positive real, and on the face it lies on.

Optimal devices lie on the boundary of positive realness: a pole or zero on the imaginary axis (0 and ∞ included), or
Re Y(jω) = 0 at some frequency. A search ends within 1e-7 to 1e-15 of such a face, never on it, and coefficients that
are rounded one by one leave it, to either side. So what the face fixes is taken out first, by name:

1. poles and zeros within a tolerance of 0 or ∞ are put there;
2. poles of Y on the axis come off, Σ α s/(s² + x) + k/s + b s, those of 1/Y likewise, until there are none; resonances
   first, as without them Y vanishes at 0 and ∞ as before;
3. of what is left, N/D with D Hurwitz, E(x) = |D|² Re Y at x = ω² keeps its double roots double,

       E(x) = Π (x − xᵢ)² F(x),

   and N is solved for: with D given, N ↦ E is linear and one to one, so Re Y ≥ 0 holds exactly as F ≥ 0 does.

The parts, each of few digits, are then put together in exact arithmetic. The largest tolerance is taken at which the
figure is no worse.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from itertools import product
from operator import or_

from flint import acb, fmpq, fmpq_mat, fmpq_poly

from posreal.admittance import Rational, is_positive_real, resistance, roots
from posreal.admittance.exact import even_part, odd_part, rounded, to_fmpq
from posreal.admittance.rational import S
from posreal.errors import BadDevice

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 0.0)  # of roots' distances, and of Re Y; relative
DIGITS = (15, 20, 30, 50)
BITS = 512
X = resistance.X


def presented(Y: Rational, acceptable: Callable[[Rational], bool]) -> tuple[Rational, str]:
    """Y with few digits, exactly positive real and on its face, and a note where that could not be had.

    Parameters
    ----------
    Y : Rational
        Exactly positive real.
    acceptable : function of Rational
        Whether a device does as well as Y.
    """
    for tolerance in TOLERANCES:
        for digits in DIGITS:
            try:
                found = _Rounding(to_fmpq(tolerance), digits).of(Y)
            except (BadDevice, ArithmeticError):  # Y does not lie on that face
                break
            if is_positive_real(found):
                if not tolerance or acceptable(found):
                    return found, ""
                break
    return Y, "coefficients are exact and long: rounding them would lose positive realness"


@dataclass(frozen=True)
class _Rounding:
    """A tolerance within which a device lies on a face, and the significant digits that its parts keep."""

    tolerance: fmpq
    digits: int

    def of(self, Y: Rational) -> Rational:
        """The device on its face."""
        with roots.precision(BITS):
            placed, inside = self._placed(Y)
        short = placed.rounded(self.digits)  # what is zero stays zero
        return placed if inside or not is_positive_real(short) else short

    def _placed(self, Y: Rational) -> tuple[Rational, bool]:
        """The device put together of short parts, and whether it touches the axis at a frequency between 0 and ∞."""
        Y = self._ended(Y)
        for legs_of, inverted in product((self._resonances, self._ends), (False, True)):
            side = Y.inverse() if inverted else Y
            legs, rest = legs_of(side)
            if not legs:
                continue
            inside = legs[0].degree == 2
            if not self._is_nothing(rest, side):
                below, touches = self._placed(rest)
                legs, inside = [*legs, below], inside or touches
            whole = reduce(or_, legs)
            return (whole.inverse() if inverted else whole), inside
        return self._core(Y)

    def _ended(self, Y: Rational) -> Rational:
        """Y with the poles and zeros that lie next to 0 or ∞ put there."""
        sizes = sorted(size for p in (Y.n, Y.d) for root in _roots(p) if (size := _size(root)) > 0)
        if not sizes or not self.tolerance:
            return Y
        low, high = sizes[len(sizes) // 2] * self.tolerance, sizes[len(sizes) // 2] / self.tolerance
        parts = []
        for p in (Y.n, Y.d):
            below = sum(_size(root) < low for root in _roots(p))
            beyond = sum(_size(root) > high for root in _roots(p))
            parts.append(fmpq_poly([fmpq(0)] * below + p.coeffs()[below : len(p.coeffs()) - beyond]))
        return Rational(*parts)

    def _ends(self, side: Rational) -> tuple[list[Rational], Rational]:
        """What a function's poles at 0 and ∞ are, in few digits, and the function without them."""
        k, b = to_fmpq(side.static_stiffness), to_fmpq(side.inertance)
        legs = [*([Rational([self._short(k)], [0, 1])] if k else []), *([Rational([0, self._short(b)])] if b else [])]
        return legs, side.without(Rational([k, 0, b], [0, 1]))

    def _resonances(self, side: Rational) -> tuple[list[Rational], Rational]:
        """The same for the pairs of poles ±jω."""
        legs = []
        for root in _roots(side.d):
            if root.imag > 0 and abs(roots.midpoint(root.real)) <= _size(root) * self.tolerance:
                x = _size(root) ** 2
                factor = S * S + x
                rest = side.d // factor
                (p, q), (u, v) = ((even_part(f)(-x), odd_part(f)(-x)) for f in (side.n, rest))
                alpha = (q * u - p * v) / (u * u + x * v * v)
                side = Rational((side.n - alpha * S * rest) // factor, rest)
                legs.append(Rational([0, self._short(alpha)], [self._short(x), 0, 1]))
        return legs, side

    def _is_nothing(self, rest: Rational, side: Rational) -> bool:
        """Whether what is left of a function is what the tolerance leaves; both are positive at s > 0."""
        sizes = sorted(_size(root) for p in (side.n, side.d) for root in _roots(p))
        s = sizes[len(sizes) // 2] or fmpq(1)
        return rest.is_zero() or abs(rest.n(s) * side.d(s)) <= self.tolerance * abs(side.n(s) * rest.d(s))

    def _core(self, Y: Rational) -> tuple[Rational, bool]:
        """A function without poles or zeros on the axis, and whether its real part touches zero."""
        E, _ = resistance.real_part(Y)
        near = [r for r in _roots(E) if r.real > 0 and roots.midpoint(r.imag) ** 2 <= self.tolerance * _size(r) ** 2]
        if not near:
            return Y.rounded(self.digits), False
        near.sort(key=lambda root: roots.midpoint(root.real))
        places = [roots.midpoint((a.real + b.real) / 2) for a, b in zip(near[::2], near[1::2], strict=True)]
        F, touching = E, fmpq_poly([1])
        for x in places:
            F = F // (X - x) ** 2
            touching *= (X - self._short(x)) ** 2
        d = self._shortened(Y.d)
        return Rational(_numerator(touching * self._shortened(F), d), d), True

    def _short(self, value: fmpq) -> fmpq:
        return rounded(value, self.digits)

    def _shortened(self, p: fmpq_poly) -> fmpq_poly:
        return fmpq_poly([self._short(c) for c in p.coeffs()])


def _numerator(E: fmpq_poly, d: fmpq_poly) -> fmpq_poly:
    """The n of degree at most that of a Hurwitz d with Re(n/d) = E/|d|²."""
    size = d.degree() + 1
    columns = [resistance.real_part(Rational(S**i, d))[0] for i in range(size)]
    entries = fmpq_mat(size, size, [columns[j][i] for i in range(size) for j in range(size)])
    return fmpq_poly(entries.solve(fmpq_mat(size, 1, [E[i] for i in range(size)])).entries())


def _roots(p: fmpq_poly) -> list[acb]:
    """Every root, repeated ones repeated."""
    return [root for root, power in roots.complex_roots(p) for _ in range(power)] if p.degree() > 0 else []


def _size(root: acb) -> fmpq:
    return roots.midpoint(abs(root))
