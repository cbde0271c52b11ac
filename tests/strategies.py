"""Hypothesis strategies that draw networks: positive real by construction, with exact values.

``decades`` is how far element values are spread, ``kinds`` which elements may occur: "kc" draws springs and
dampers.
"""

from __future__ import annotations

from fractions import Fraction

from hypothesis import strategies as st

from posreal.network import Damper, Graph, Inerter, Lever, Network, Parallel, Series, Spring, bridge

KINDS = {"k": Spring, "c": Damper, "b": Inerter}


def values(decades: int = 4) -> st.SearchStrategy[Fraction]:
    """Three-digit numbers, their powers of ten spread evenly over so many decades around one."""
    low = -(decades // 2)
    return st.builds(
        lambda digits, power: Fraction(digits, 100) * Fraction(10) ** power,
        st.integers(100, 999),
        st.integers(low, low + max(decades - 1, 0)),
    )


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
    count = draw(st.integers(least, most))
    return draw(_tree(count, kinds, decades, joint))


@st.composite
def _tree(draw: st.DrawFn, count: int, kinds: str, decades: int, joint: int) -> Network:
    if count == 1:
        return draw(elements(kinds, decades))
    joint = joint or draw(st.sampled_from((1, -1)))
    parts = []
    while count:
        part = draw(st.integers(1, count if parts else count - 1))
        parts.append(draw(_tree(part, kinds, decades, -joint)))
        count -= part
    return Series(tuple(parts)) if joint > 0 else Parallel(tuple(parts))


@st.composite
def bridges(draw: st.DrawFn, most: int = 2, kinds: str = "kcb", decades: int = 4) -> Graph:
    """A bridge of five branches, each a tree of up to `most` elements."""
    return bridge(*(draw(trees(most, kinds, decades)) for _ in range(5)))


@st.composite
def lever_networks(draw: st.DrawFn, most: int = 2, decades: int = 4) -> Graph:
    """What one cycle of Brune's method leaves: a lever, one element beside it, a leg and a load."""
    beside, leg, load = (draw(trees(most, decades=decades)) for _ in range(3))
    ratio = draw(values(2)) * draw(st.sampled_from((1, -1)))
    return Graph(((1, 2, beside), (2, 0, leg), (3, 0, load)), ((1, 2, 3, Lever(ratio)),))


@st.composite
def networks(draw: st.DrawFn, most: int = 6, decades: int = 4) -> Network:
    """Any network: a tree, a bridge, one with a lever, or two of them joined."""
    part = st.one_of(trees(most, decades=decades), bridges(1, decades=decades), lever_networks(1, decades))
    first = draw(part)
    joint = draw(st.sampled_from(("alone", "series", "parallel")))
    if joint == "alone":
        return first
    second = draw(part)
    return first + second if joint == "series" else first | second
