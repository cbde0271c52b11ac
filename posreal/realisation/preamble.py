"""Foster preamble [Brune1931]: everything that comes off a positive-real function without a trick.

In turn, as long as anything comes off: poles of Y on the imaginary axis (0 and ∞ included) are parallel legs,

    Y = k/s + b s + Σ α s/(s² + ω²) + rest,      α s/(s² + ω²) = spring α in series with inerter α/ω²;

poles of 1/Y the dual legs in series; then the least value of Re Y or of Re 1/Y is a damper. If that least
value lies at 0 or ∞, a zero appears there and the degree falls; if it lies between on both sides, what is
left is a minimum function and goes to a cycle (Bott–Duffin, Brune, …) that takes its degree down by two.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import combinations
from operator import or_

from flint import fmpq, fmpq_poly

from posreal.admittance import Rational, resistance
from posreal.admittance.rational import S
from posreal.errors import BadDevice, DoesNotApply
from posreal.network import Network, parallel, series
from posreal.realisation.elements import damper, dual, inerter, spring
from posreal.realisation.multiprecision import Long, at_axis, squared_size

Recurse = Callable[[Rational], Network]
Small = Callable[[Rational, int], Network | None]
"""(admittance, most elements) → a network found otherwise."""
Cycle = Callable[[Rational, fmpq, Long, Recurse], Network]
"""(admittance of a minimum function, ω₀², arithmetic, recursion) → network."""

MOST = 600  # elements; Bott and Duffin's method doubles them with every second degree
TRY_BOTH = 4  # up to this degree, dampers are tried on both sides of a minimum and the smaller network kept


@dataclass(frozen=True)
class CycleMethod:
    """The preamble, with the cycle that takes over at minimum functions; `small` is asked first, of every remainder."""

    cycle: Cycle
    arithmetic: Long
    small: Small | None = None

    def __call__(self, device: Rational) -> Network:
        """A network with this admittance, which must be positive real and not zero.

        Raises
        ------
        DoesNotApply
            If there would be more elements than anybody builds, or than can be proven in reasonable time.
        """
        network = self._of(device)
        if len(network) > MOST:
            raise DoesNotApply(f"This method takes more than {MOST} elements here; allow levers (method brune).")
        return network

    def _of(self, device: Rational) -> Network:
        y = self.arithmetic.cleaned(device)
        if y.degree == 0:
            return damper(y.n[0])
        few = self.small(y, MOST) if self.small is not None else None
        if few is not None:
            return few
        for side, inverted in ((y, False), (y.inverse(), True)):
            legs, rest = axis_legs(side, self.arithmetic)
            if legs:
                network = self._without_legs(side, legs, rest, inverted)
                return self._fewer(side, legs, rest, inverted, network)
        return self._without_resistance(y)

    def _without_legs(self, side: Rational, legs: Sequence[Network], rest: Rational, inverted: bool) -> Network:
        inner = [] if self.arithmetic.is_nothing(rest, side) else [self(rest.inverse() if inverted else rest)]
        return series(*map(dual, legs), *inner) if inverted else parallel(*legs, *inner)

    def _fewer(
        self, side: Rational, legs: Sequence[Network], rest: Rational, inverted: bool, network: Network
    ) -> Network:
        """The network, or a smaller one in which a small network keeps some of the legs' poles to itself."""
        if self.small is None:
            return network
        for count in range(1, len(legs)):
            for off in combinations(range(len(legs)), count):
                kept = reduce(or_, (leg.admittance() for i, leg in enumerate(legs) if i not in off), rest)
                outside = [legs[i] for i in off]
                few = self.small(kept.inverse() if inverted else kept, len(network) - 1 - sum(map(len, outside)))
                if few is not None:
                    network = series(*map(dual, outside), few) if inverted else parallel(*outside, few)
        return network

    def _without_resistance(self, y: Rational) -> Network:
        sides: list[tuple[Rational, bool, fmpq, resistance.Minimum]] = []
        for side, inverted in ((y, False), (y.inverse(), True)):
            least = self.arithmetic.least_real_part(side)
            if isinstance(least.value, float):
                raise BadDevice("A pole on the axis was not recognised; raise the precision.")
            sides.append((side, inverted, least.value, least))
        ends = [entry for entry in sides if not entry[3].inside]
        choices = ends or sides
        if self.small is not None:  # which may find more in what an end leaves, or in what a minimum inside does
            choices = sorted(sides, key=lambda entry: entry[3].inside)
        choices = choices if y.degree <= TRY_BOTH else choices[:1]
        if all(c == 0 for _, _, c, _ in choices):
            choices = choices[:1]
        networks = []
        for side, inverted, c, least in choices:
            rest = side.without(Rational([c]))
            if least.x is None or not least.inside:
                inner = self(rest.inverse() if inverted else rest)
            elif squared_size(rest, least.x) <= self.arithmetic.tolerance * squared_size(side, least.x):
                inner = self(_with_zero(rest, least.x, inverted))
            else:
                inner = self._minimum_function(rest.inverse() if inverted else rest, least.x)
            if c != 0:
                inner = series(damper(1 / c), inner) if inverted else parallel(damper(c), inner)
            networks.append(inner)
        return min(networks, key=len)

    def _minimum_function(self, y: Rational, x: fmpq) -> Network:
        return self.cycle(Rational(self.arithmetic.cut(y.n), self.arithmetic.cut(y.d)), x, self.arithmetic, self)


def _with_zero(rest: Rational, x: fmpq, inverted: bool) -> Rational:
    """The rest, which vanishes at ±jω₀ altogether, with that zero made exact; inverted if so asked."""
    factor = S * S + x
    exactly = Rational(factor * (rest.n // factor), rest.d)
    return exactly.inverse() if inverted else exactly


def axis_legs(y: Rational, arithmetic: Long) -> tuple[list[Network], Rational]:
    """The parallel legs that Y's poles on the imaginary axis are, and Y without them."""
    legs: list[Network] = []
    if y.static_stiffness:
        k = y.n[0] / y.d[1]
        legs.append(spring(k))
        y = y.without(Rational([k], [0, 1]))
    if y.inertance:
        b = y.n.leading_coefficient()
        legs.append(inerter(b))
        y = y.without(Rational([0, b]))
    for pair in arithmetic.axis_pairs(y.d):
        alpha, y = without_resonance(y, pair.x, arithmetic)
        legs.append(series(spring(alpha), inerter(alpha / pair.x)))
    return legs, y


def without_resonance(y: Rational, x: fmpq, arithmetic: Long) -> tuple[fmpq, Rational]:
    """(α, Y − α s/(s² + x)), the factor s² + x divided out by name."""
    factor = S * S + x
    rest = y.d // factor
    (a, b), (c, e) = at_axis(y.n, x), at_axis(rest, x)
    alpha = (b * c - a * e) / (c * c + x * e * e)
    top: fmpq_poly = (y.n - alpha * S * rest) // factor
    return alpha, Rational(arithmetic.cut(top), arithmetic.cut(rest))
