"""Fewer elements, the same admittance: like elements side by side or end to end are one.

k1 | k2 = k(k1 + k2),     k1 + k2 = k(1/(1/k1 + 1/k2)),     and so for dampers and inerters.
"""

from __future__ import annotations

from fractions import Fraction

from posreal.network.graph import Graph
from posreal.network.tree import Element, Network, Parallel, Series, parallel, series


def simplified(network: Network) -> Network:
    """The network with like elements of one joint merged, everywhere in it; values stay exact.

    The first of those merged gives its name. Where one of them has no value, neither has the merged one.

    Examples
    --------
    >>> from posreal.network import parse
    >>> str(simplified(parse("k1=2 | c=1 | k2=3")))
    'k1=5 | c=1'
    """
    if isinstance(network, Graph):
        return Graph(tuple((u, v, simplified(part)) for u, v, part in network.branches), network.levers)
    if not isinstance(network, Series | Parallel):
        return network
    merged: list[Network] = []
    place: dict[str, int] = {}
    for child in type(network)(tuple(simplified(child) for child in network.children)).children:
        if isinstance(child, Element):
            if child.letter in place:
                i = place[child.letter]
                merged[i] = _one(merged[i], child, isinstance(network, Series))
                continue
            place[child.letter] = len(merged)
        merged.append(child)
    return series(*merged) if isinstance(network, Series) else parallel(*merged)


def _one(first: Network, second: Element, in_series: bool) -> Network:
    assert isinstance(first, Element)
    a, b = first.value, second.value
    value: Fraction | None = None
    if a is not None and b is not None:
        value = a * b / (a + b) if in_series else a + b
    return first.altered(value, first.name)
