"""Any network as a flat multigraph: numbered nodes, one edge an element, and levers on three nodes.

Node 1 is the first terminal (the body's side), node 0 the second: held in nodal analysis, ground in SPICE.
"""

from __future__ import annotations

from dataclasses import dataclass

from posreal.network.tree import Element, Network


@dataclass(frozen=True)
class Edge:
    """An element between two nodes, under its resolved name."""

    start: int
    end: int
    name: str
    element: Element


@dataclass(frozen=True)
class Bar:
    """A lever on three nodes, under its resolved name."""

    near: int
    pivot: int
    far: int
    name: str
    lever: Element


@dataclass(frozen=True)
class Circuit:
    """The multigraph of a network."""

    size: int
    edges: tuple[Edge, ...]
    bars: tuple[Bar, ...]


def circuit(network: Network) -> Circuit:
    """Flatten a network into nodes and elements."""
    edges: list[Edge] = []
    bars: list[Bar] = []
    names = network.names
    size, first = 2, 0
    waiting = [(network, 1, 0)]
    while waiting:  # depth first, children in order, so that elements are met in the order of the names
        part, start, end = waiting.pop()
        if isinstance(part, Element):
            edges.append(Edge(start, end, names[first], part))
            first += 1
        else:
            inner = [end, start, *range(size, size + part.size - 2)]
            size += part.size - 2
            waiting.extend((child, inner[u], inner[v]) for u, v, child in reversed(part.branches))
            first_lever = first + sum(len(child) for child in part.children)
            for offset, (a, m, b, lever) in enumerate(part.levers):
                bars.append(Bar(inner[a], inner[m], inner[b], names[first_lever + offset], lever))
    return Circuit(size, tuple(edges), tuple(bars))
