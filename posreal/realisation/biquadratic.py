"""Biquadratics with the fewest elements, decided in closed form [JiangSmith2011] [MorelliSmith2019].

A regular one (least Re Y or Re 1/Y at 0 or ∞) comes apart in the Foster preamble: two springs or
inerters, at most three dampers. A non-regular one takes more than five elements unless it is one of

    bridges     {1-2: b, 1-3: c, 2-3: k, 2-0: c, 3-0: c}         five values for five coefficients
    quartet     (b | c) + k | b + c                              a common factor drops out: one condition
    bridges     {1-2: c, 1-3: k, 2-3: b, 2-0: k, 3-0: c}         the same

or what these become under Y(1/s) (springs and inerters swap) and 1/Y (the dual). No other network of five
elements is non-regular: with one damper c, Y(0) and Y(∞) are 0, ∞ or c, which makes a function regular, and the
77 networks with two springs and inerters and the 210 with three have been gone through one by one. Minimum functions
are among them only where Y(0)/Y(∞) is 1/4 or 4 [Hughes2017].

Each form turns into a polynomial in one unknown, whose positive roots are isolated with certainty. So the
answer "no five elements" is as sure as the arithmetic is long.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from flint import fmpq, fmpq_poly

from posreal.admittance import Rational, is_regular, roots
from posreal.admittance.exact import to_float
from posreal.errors import DoesNotApply
from posreal.network import Network, bridge, parallel, series
from posreal.realisation.elements import damper, dual, inerter, spring
from posreal.realisation.frequency_inversion import turned_device, turned_network
from posreal.realisation.multiprecision import Long, shortened, square_root
from posreal.realisation.preamble import CycleMethod, Recurse
from posreal.realisation.proof import branch_residual

T = fmpq_poly([0, 1])
LEAST = 1e-250  # of an element's value; what comes out smaller is zero up to rounding


def fewest(y: Rational, arithmetic: Long) -> Network:
    """The fewest-element network of a biquadratic.

    Raises
    ------
    DoesNotApply
        If the degree is not two, or no five elements serve.
    """
    if y.degree != 2:
        raise DoesNotApply(f"This method serves functions of degree 2 and this one has degree {y.degree}.")
    if is_regular(y):
        return CycleMethod(_no_cycle, arithmetic)(y)
    for network in _five_elements(y, arithmetic):
        if branch_residual(network, y) < float(arithmetic.tolerance):
            return network
    raise DoesNotApply("This biquadratic is not regular and no five elements have it; use reza-pantell.")


def _no_cycle(y: Rational, x: object, arithmetic: Long, recurse: Recurse) -> Network:
    raise DoesNotApply("A minimum function is left inside, which a regular biquadratic does not have.")


def _five_elements(y: Rational, arithmetic: Long) -> Iterator[Network]:
    """Candidates with positive values; those that miss a condition of their form do not have the admittance."""
    forms: tuple[Callable[[Rational, int], Iterator[Network]], ...] = (_two_stores, _three_stores, _series_parallel)
    for form in forms:
        for turn in (False, True):
            device = turned_device(y) if turn else y
            for network in form(device, arithmetic.bits):
                yield turned_network(network) if turn else network
            if form is _series_parallel:  # the bridges are their own duals, up to a turn
                for network in form(device.inverse(), arithmetic.bits):
                    yield dual(turned_network(network) if turn else network)


def _two_stores(y: Rational, bits: int) -> Iterator[Network]:
    """The bridge {1-2: b, 1-3: p, 2-3: k, 2-0: q, 3-0: r} for Y = (A s² + B s + C)/(D s² + E s + F).

    With h = A/D, g = C/F, q = h − u and r = t − h + u its five equations come down to

        (t − g) u² + (t − g)(t − h) u − g t (t − h) = 0,
        (B − E u)(E t − B) u² + D F (u − g)(t − u)² (t − h) = 0,

    and their resultant, a polynomial in t.
    """
    C, B, A = (y.n[i] for i in range(3))
    F, E, D = (y.d[i] for i in range(3))
    if 0 in (A, C, D, F):
        return
    h, g = A / D, C / F
    a2, a1, a0 = T - g, (T - g) * (T - h), -g * T * (T - h)
    m, n = E * T - B, D * F * (T - h)
    q3, q2, q1, q0 = n - E * m, B * m - n * (2 * T + g), n * T * (T + 2 * g), -g * n * T * T
    # the second less multiples of the first: e1 u + e0
    first, second = a2 * q2 - q3 * a1, a2 * q1 - q3 * a0
    e1, e0 = a2 * second - first * a1, a2 * a2 * q0 - first * a0
    resultant = a2 * e0 * e0 - a1 * e0 * e1 + a0 * e1 * e1
    for t in _positive(resultant, bits, known=(g, h)):
        if t < max(g, h):
            continue
        p = g * t / (t - g)
        u = (square_root((t - h) * (t - h) + 4 * p * (t - h), bits) - (t - h)) / 2
        q, r = h - u, t - h + u
        if not (q > 0 and r > 0 and E * t != B):
            continue
        size = q * r * r * (t - u) / ((t - h) * (E * t - B))
        b = size * D / (p + r)
        k = (size * E - q * r * r / (t - h)) / b if b > 0 else b
        if values := _sound((b, p, k, q, r), bits):
            b, p, k, q, r = values
            yield bridge(inerter(b), damper(p), spring(k), damper(q), damper(r))


def _three_stores(y: Rational, bits: int) -> Iterator[Network]:
    """The bridge {1-2: c, 1-3: k, 2-3: b, 2-0: k', 3-0: c'}, whose numerator and denominator share a factor s + z.

    c and c' follow from c + c' = g and c c' = g h. With λ the scale of the coefficients, b = λ D/g and
    k + k' = σ, two equations are left, both linear in z; their resultant is a polynomial in λ.
    """
    C, B, A = (y.n[i] for i in range(3))
    F, E, D = (y.d[i] for i in range(3))
    if 0 in (A, C, D, F):
        return
    h, g = A / D, C / F
    if g < 4 * h:
        return
    split = square_root(g * g - 4 * g * h, bits)
    left, right = D * E / g * T * T + (A - g * D) * T, (g * E - B) * T - g * g * h - D * F / g * T * T
    other, value = g * h * A / D + (h * E - B) * T + D * F / g * T * T, (C - h * F) * T - fmpq_poly([g * h * B / D])
    for size in _positive(left * value - right * other, bits):
        slope, rest = (left(size), right(size)) if left(size) != 0 else (other(size), value(size))
        if slope == 0 or rest / slope <= 0:
            continue
        z = rest / slope
        total, product = size / g * (F + E * z) + (B + A * z) / D, size * F * z
        apart = total * total - 4 * product
        step = square_root(max(apart, fmpq(0)), bits)
        b = size * D / g
        for c, k in (((g + split) / 2, (total + step) / 2), ((g + split) / 2, (total - step) / 2)):
            if values := _sound((c, k, b, total - k, g - c), bits):
                c1, k1, b1, k2, c2 = values
                yield bridge(damper(c1), spring(k1), inerter(b1), spring(k2), damper(c2))


def _series_parallel(y: Rational, bits: int) -> Iterator[Network]:
    """(b | c) + k | b' + c' with poles −p and −p' of the first branch and −p of the second."""
    C, A = y.n[0], y.n[2]
    F, E, D = (y.d[i] for i in range(3))
    apart = E * E - 4 * D * F
    if 0 in (A, C, D, F) or apart <= 0:
        return
    step = square_root(apart, bits)
    for p in ((E + step) / (2 * D), (E - step) / (2 * D)):
        total, product = E / D, F / D
        k = C / F * product / total
        b, c = k / product, k / product * total
        if values := _sound((k, b, c, A / D / p, A / D), bits):
            k, b, c, b2, c2 = values
            yield parallel(series(parallel(inerter(b), damper(c)), spring(k)), series(inerter(b2), damper(c2)))


def _sound(values: tuple[fmpq, ...], bits: int) -> list[fmpq] | None:
    """The values cut to so many bits, if all are positive and of a size that elements can have."""
    sound = all(value > 0 and LEAST < to_float(value) < 1 / LEAST for value in values)
    return [shortened(value, bits) for value in values] if sound else None


def _positive(p: fmpq_poly, bits: int, known: tuple[fmpq, ...] = ()) -> list[fmpq]:
    """The positive roots of p, those known to mean nothing left out."""
    for root in known:
        while p.degree() > 0 and p(root) == 0:
            p = p // (T - root)
    if p.degree() < 1:
        return []
    with roots.precision(bits + 64):
        return [roots.midpoint(root) for root, _ in roots.positive_roots(p)]
