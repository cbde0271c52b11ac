"""Hypothesis strategies that draw networks: positive real by construction, with exact values.

``decades`` is how far element values are spread, ``kinds`` which elements may occur: "kc" draws springs and
dampers.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cache, lru_cache

from hypothesis import strategies as st

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
