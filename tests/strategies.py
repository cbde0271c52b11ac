"""Hypothesis strategies that draw networks and admittances: positive real by construction, with exact values.

``decades`` is how far element values are spread, ``kinds`` which elements may occur: "kc" draws springs and
dampers.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cache, lru_cache

import numpy as np
from flint import fmpq_mat, fmpq_poly
from hypothesis import strategies as st

from posreal.admittance import Rational, random_port_hamiltonian
from posreal.admittance.exact import at_minus_s, of_square, to_fmpq
from posreal.network import Damper, Graph, Inerter, Lever, Network, Parallel, Series, Spring, bridge

KINDS = {"k": Spring, "c": Damper, "b": Inerter}


_between = lru_cache(maxsize=None)(st.integers)  # hypothesis is slow at making strategies, not at drawing from them
_one_of = lru_cache(maxsize=None)(st.sampled_from)


@cache
def values(decades: int = 4) -> st.SearchStrategy[Fraction]:
    """Three-digit numbers, their powers of ten spread evenly over so many decades around one."""
    low = -(decades // 2)
    return st.builds(
        lambda digits, power: Fraction(digits, 100) * Fraction(10) ** power,
        st.integers(100, 999),
        st.integers(low, low + max(decades - 1, 0)),
    )


@cache
def elements(kinds: str = "kcb", decades: int = 4) -> st.SearchStrategy[Network]:
    """One spring, damper or inerter."""
    return st.builds(lambda kind, value: KINDS[kind](value), st.sampled_from(kinds), values(decades))


@st.composite
def trees(
    draw: st.DrawFn, most: int = 8, kinds: str = "kcb", decades: int = 4, least: int = 1, joint: int = 0
) -> Network:
    """A series–parallel tree of `least` to `most` elements.

    `joint` is +1 (series), −1 (parallel) or 0 (either) at the root; below it the two alternate.
    """
    return _grown(draw, draw(_between(least, most)), kinds, decades, joint or draw(_one_of((1, -1))))


def _grown(draw: st.DrawFn, count: int, kinds: str, decades: int, joint: int) -> Network:
    if count == 1:
        return draw(elements(kinds, decades))
    parts: list[Network] = []
    while count:
        size = draw(_between(1, count if parts else count - 1))
        parts.append(_grown(draw, size, kinds, decades, -joint))
        count -= size
    return Series(tuple(parts)) if joint > 0 else Parallel(tuple(parts))


def _small(draw: st.DrawFn, most: int, kinds: str, decades: int) -> Network:
    return _grown(draw, draw(_between(1, most)), kinds, decades, draw(_one_of((1, -1))))


@st.composite
def bridges(draw: st.DrawFn, most: int = 2, kinds: str = "kcb", decades: int = 4) -> Graph:
    """A bridge of five branches, each a tree of up to `most` elements."""
    return bridge(*(_small(draw, most, kinds, decades) for _ in range(5)))


@st.composite
def lever_networks(draw: st.DrawFn, most: int = 2, decades: int = 4) -> Graph:
    """What one cycle of Brune's method leaves: a lever, one element beside it, a leg and a load."""
    beside, leg, load = (_small(draw, most, "kcb", decades) for _ in range(3))
    ratio = draw(values(2)) * draw(_one_of((1, -1)))
    return Graph(((1, 2, beside), (2, 0, leg), (3, 0, load)), ((1, 2, 3, Lever(ratio)),))


@st.composite
def networks(draw: st.DrawFn, most: int = 6, decades: int = 4) -> Network:
    """Any network: a tree, a bridge, one with a lever, or two of them joined."""
    first = draw(_part(most, decades))
    joint = draw(_one_of(("alone", "series", "parallel")))
    if joint == "alone":
        return first
    second = draw(_part(most, decades))
    return first + second if joint == "series" else first | second


@cache
def _part(most: int, decades: int) -> st.SearchStrategy[Network]:
    return st.one_of(trees(most, decades=decades), bridges(1, decades=decades), lever_networks(1, decades))


@st.composite
def port_hamiltonians(draw: st.DrawFn, most: int = 8, decades: tuple[int, ...] = (0, 4, 10)) -> Rational:
    """A device of a drawn port-Hamiltonian form, its time scales spread over so many decades."""
    rng = np.random.default_rng(draw(_between(0, 2**32 - 1)))
    return random_port_hamiltonian(draw(_between(0, most)), rng, draw(_one_of(decades))).rational()


@st.composite
def lossless(draw: st.DrawFn, most: int = 8, decades: int = 4) -> Rational:
    """k/s + b s + Σ α s/(s² + x), or its dual: springs and inerters alone, no frequency a rational number."""
    y = draw(elements("kb", decades)).admittance()
    while y.degree + 2 <= most and draw(st.booleans()):
        alpha, x = draw(values(decades)), draw(values(decades))
        y = y | Rational([0, alpha], [x, 0, 1])
    return draw(_one_of((y, y.dual)))


@st.composite
def touching(draw: st.DrawFn, most: int = 8, decades: int = 2) -> Rational:
    """A device on the boundary: Re Y(jω) = p(ω²)²/|d(jω)|² with one or more exact zeros, at ω² rational.

    With d drawn Hurwitz, the numerator n follows from  n(s) d(−s) + n(−s) d(s) = 2 p(−s²)²  (linear in n).
    """
    d = fmpq_poly([1])
    for _ in range(draw(_between(1, most // 2))):
        d *= fmpq_poly([to_fmpq(draw(values(decades))), to_fmpq(draw(values(decades))), 1])
    square = fmpq_poly([1])
    for _ in range(draw(_between(1, d.degree() // 2))):
        square *= fmpq_poly([to_fmpq(draw(values(decades))), 1]) ** 2  # in z = s²
    return Rational(_with_even_part(d, square), d)


def _with_even_part(d: fmpq_poly, target: fmpq_poly) -> fmpq_poly:
    """n of d's degree whose n(s) d(−s) has the even part `target` in s²."""
    size = d.degree() + 1
    mirrored, wanted = at_minus_s(d), of_square(target)
    columns = [fmpq_poly([0] * power + [1]) * mirrored for power in range(size)]
    system = fmpq_mat(size, size, [column[2 * i] for i in range(size) for column in columns])
    return fmpq_poly(system.solve(fmpq_mat(size, 1, [wanted[2 * i] for i in range(size)])).entries())
