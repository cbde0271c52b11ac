"""Long arithmetic for synthesis: rational functions whose coefficients keep a set number of bits.

The minimum of Re Y is a double root, so floats lose half their digits there, and factors that cancel on
paper leave phantom poles behind. Here coefficients keep hundreds of digits, factors known to cancel are
divided out by name, and what lies closer together than the tolerance (the fourth root of the rounding
error) is one and the same.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from flint import acb, arb, fmpq, fmpq_poly, fmpz

from posreal.admittance import Rational, resistance, roots
from posreal.admittance.exact import even_part, odd_part, to_fmpq
from posreal.admittance.rational import S


def shortened(value: fmpq, bits: int) -> fmpq:
    """The value cut to so many significant bits."""
    if value.height_bits() <= bits:
        return value
    shift = bits - value.p.height_bits() + value.q.height_bits()
    if shift >= 0:
        return fmpq((value.p * (fmpz(1) << shift)) // value.q, fmpz(1) << shift)
    return fmpq((value.p // (value.q * (fmpz(1) << -shift))) * (fmpz(1) << -shift))


def square_root(value: fmpq, bits: int) -> fmpq:
    """√value to so many bits."""
    with roots.precision(bits):
        return roots.midpoint(arb(value).sqrt())


@dataclass(frozen=True)
class Pair:
    """A conjugate pair of roots on the axis, s² + x = 0, found within the tolerance."""

    x: fmpq

    @property
    def polynomial(self) -> fmpq_poly:
        """s² + x."""
        return S * S + self.x


@dataclass(frozen=True)
class Long:
    """How many bits coefficients keep, and what follows from it."""

    bits: int = 1024
    negligible: fmpq = field(default_factory=fmpq)
    """Part of |Y| under which a least real part counts as zero, if that is more than the tolerance."""
    centre: fmpq = field(default_factory=lambda: fmpq(1))
    """A frequency amid the device's poles and zeros, in rad/s."""

    def around(self, device: Rational) -> Long:
        """The same arithmetic, centred on a device."""
        sizes = sorted(abs(complex(root)) for p in (device.n, device.d) for root in self.roots(p))
        inner = [size for size in sizes if 0 < size < float("inf")]
        return replace(self, centre=to_fmpq(inner[len(inner) // 2])) if inner else self

    @property
    def tolerance(self) -> fmpq:
        """Relative distance under which two numbers are taken for one."""
        return fmpq(1, fmpz(1) << (self.bits // 4))

    def cut(self, p: fmpq_poly) -> fmpq_poly:
        """The polynomial with every coefficient cut to `bits`."""
        return fmpq_poly([shortened(c, self.bits) for c in p.coeffs()])

    def cleaned(self, device: Rational) -> Rational:
        """Cut coefficients, and drop poles that lie on zeros and those further out or in than can be real."""
        device = Rational(self._bounded(self.cut(device.n)), self._bounded(self.cut(device.d)))
        n, d = device.n, device.d
        zeros, poles = self.roots(n), self.roots(d)
        for pole in poles:
            if pole.imag < 0:
                continue
            near = next((zero for zero in zeros if self._same(pole, zero)), None)
            if near is not None:
                factor = self._factor(pole)
                n, d = n // factor, d // factor
                zeros.remove(near)
        return Rational(self.cut(n), self.cut(d)) if n.degree() < device.n.degree() else device

    def is_nothing(self, rest: Rational, device: Rational) -> bool:
        """Whether what is left of a device is rounding only; both are positive on the positive real line."""
        s = self.centre
        return rest.is_zero() or abs(rest.n(s) / rest.d(s)) <= self.tolerance * abs(device.n(s) / device.d(s))

    def roots(self, p: fmpq_poly) -> list[acb]:
        """Every root, repeated ones repeated."""
        if p.degree() < 1:
            return []
        with roots.precision(self.bits):
            return [root for root, power in roots.complex_roots(p) for _ in range(power)]

    def axis_pairs(self, p: fmpq_poly) -> list[Pair]:
        """The pairs of roots whose real part is nothing against their size (0 itself left out)."""
        pairs = []
        for root in self.roots(p):
            with roots.precision(self.bits):
                size = abs(root)
                if root.imag > 0 and abs(root.real) < size * arb(self.tolerance):
                    pairs.append(Pair(shortened(roots.midpoint(size * size), self.bits)))
        return pairs

    def least_real_part(self, device: Rational) -> resistance.Minimum:
        """The minimum of Re Y(jω): zero where that is rounding, at 0 or ∞ where that is no worse."""
        E, D = resistance.coprime(*resistance.real_part(device))
        with roots.precision(self.bits):
            least = resistance.minimum(E, D)
        if isinstance(least.value, float) or not least.inside or least.x is None:
            return least
        end = min(resistance.ends(E, D), key=lambda place: place.rank)
        if not isinstance(end.value, float) and end.value - least.value <= self.tolerance * end.value:
            return end
        part = max(self.tolerance, self.negligible**2)
        if least.value * least.value <= part * squared_size(device, least.x):
            return resistance.Minimum(fmpq(0), least.x)
        return least

    def _bounded(self, p: fmpq_poly) -> fmpq_poly:
        """The polynomial without roots that rounding put near infinity, and those near zero put there."""
        low, high = self.centre * self.tolerance, self.centre / self.tolerance
        with roots.precision(self.bits):
            sizes = [abs(root) for root in self.roots(p)]
            beyond = sum(1 for size in sizes if size > arb(high))
            below = sum(1 for size in sizes if size < arb(low))
        coefficients = p.coeffs()[: len(p.coeffs()) - beyond] if beyond else p.coeffs()
        return fmpq_poly([fmpq(0)] * below + coefficients[below:])

    def _same(self, p: acb, q: acb) -> bool:
        with roots.precision(self.bits):
            return bool(abs(p - q) < abs(p) * arb(self.tolerance))

    def _factor(self, root: acb) -> fmpq_poly:
        real, imag = roots.midpoint(root.real), roots.midpoint(root.imag)
        if root.imag == 0:
            return S - real
        return S * S - 2 * real * S + (real * real + imag * imag)


def at_axis(p: fmpq_poly, x: fmpq) -> tuple[fmpq, fmpq]:
    """(a, b) with p(s) = a + b s at s² = −x."""
    return even_part(p)(-x), odd_part(p)(-x)


def squared_size(device: Rational, x: fmpq) -> fmpq:
    """|Y(jω)|² at ω² = x."""
    (a, b), (c, e) = at_axis(device.n, x), at_axis(device.d, x)
    return (a * a + x * b * b) / (c * c + x * e * e)


def susceptance_slope(device: Rational, x: fmpq) -> fmpq:
    """Im Y(jω)/ω at ω² = x."""
    (a, b), (c, e) = at_axis(device.n, x), at_axis(device.d, x)
    return (b * c - a * e) / (c * c + x * e * e)
