"""When two networks are one: a canonical order of children, and a key for sets and dictionaries.

The order of networks in series or in parallel does not matter, nor which way round a network is put in, nor
how the inner nodes of a graph are numbered. Networks of different form that have the same admittance are
different here; `Network.admittance` finds those.
"""

from __future__ import annotations

from itertools import permutations

from posreal.errors import BadDevice
from posreal.network.graph import Graph
from posreal.network.tree import Element, Network, Parallel, Series
from posreal.network.value import write_value

MOST_INNER = 7  # nodes of a graph whose every numbering is tried


def canonical_key(network: Network, values: bool = False) -> str:
    """Text that is equal for two networks exactly when they differ in order and names only.

    Parameters
    ----------
    network : Network
    values : bool
        Whether values count; by default only the topology does.

    Examples
    --------
    >>> from posreal.network import parse
    >>> canonical_key(parse("(b=3 + c=4) | k=1")), canonical_key(parse("k | (c + b)"))
    ('(b+c)|k', '(b+c)|k')
    """
    if isinstance(network, Element):
        return _element_key(network, values)
    if isinstance(network, Graph):
        return _graph_key(network, values)
    keys = sorted(canonical_key(child, values) for child in network.children)
    sign = "+" if isinstance(network, Series) else "|"
    return sign.join(f"({key})" if any(mark in _outside(key) for mark in "+|") else key for key in keys)


def canonical(network: Network) -> Network:
    """The same network with children in the order of their keys, names kept."""
    if isinstance(network, Series | Parallel):
        children = [canonical(child) for child in network.children]
        return type(network)(
            tuple(sorted(children, key=lambda child: (canonical_key(child), canonical_key(child, True), str(child))))
        )
    if isinstance(network, Graph):
        return Graph(tuple((u, v, canonical(part)) for u, v, part in network.branches), network.levers)
    return network


def isomorphic(a: Network, b: Network, values: bool = False) -> bool:
    """Whether two networks differ in order and names only."""
    return canonical_key(a, values) == canonical_key(b, values)


def _element_key(element: Element, values: bool) -> str:
    if not values or element.value is None:
        return element.letter
    return f"{element.letter}={write_value(element.value)}"


def _outside(key: str) -> str:
    """The part of a key outside all brackets."""
    depth, kept = 0, []
    for mark in key:
        depth += mark in "({"
        if depth == 0:
            kept.append(mark)
        depth -= mark in ")}"
    return "".join(kept)


def _graph_key(graph: Graph, values: bool) -> str:
    inner = range(2, graph.size)
    if len(inner) > MOST_INNER:
        raise BadDevice(f"A graph with {len(inner)} inner nodes is too large to compare; {MOST_INNER} are tried.")
    parts = [(u, v, canonical_key(part, values)) for u, v, part in graph.branches]
    best = None
    for ends in ((0, 1), (1, 0)):
        for order in permutations(inner):
            number = (*ends, *order)
            text = ",".join(
                sorted(f"{min(number[u], number[v])}-{max(number[u], number[v])}:{key}" for u, v, key in parts)
                + sorted(
                    _lever_key(tuple(number[node] for node in nodes), lever, values) for *nodes, lever in graph.levers
                )
            )
            best = text if best is None else min(best, text)
    return "{" + str(best) + "}"


def _lever_key(nodes: tuple[int, ...], lever: Element, values: bool) -> str:
    """Near and far may be exchanged when the ratio is inverted."""
    near, pivot, far = nodes
    value = lever.value if values else None
    if near > far:
        near, far, value = far, near, None if value is None else 1 / value
    return f"{near}-{pivot}-{far}:n" + ("" if value is None else f"={write_value(value)}")
