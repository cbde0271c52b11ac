"""What a network becomes when one of its elements is taken out (opened) or put rigid (shorted).

    |        a child that is open is left out, one that is rigid makes the whole rigid
    +        the other way round
    graph    an open branch is left out, a rigid one makes its two nodes one; what then carries no force, hanging at
             one node or held at both ends, goes as well

What is left of a graph is put together again: branches side by side are a parallel joint, branches end to end at a node
of two a series joint, so a bridge without a branch is a tree.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from itertools import count

import networkx as nx

from posreal.errors import BadDevice
from posreal.network.graph import Graph
from posreal.network.simplify import simplified
from posreal.network.tree import Element, Network, Parallel, Series, parallel, series

OPEN, RIGID = "open", "rigid"
Part = Network | str
Branch = tuple[int, int, Network]


def removed(network: Network, index: int, *, shorted: bool) -> Network | None:
    """The network without its element number `index` (in the order of its names), like elements merged.

    Returns
    -------
    Network or None
        None where nothing, or a rigid link, is left.

    Raises
    ------
    BadDevice
        For a network with levers.

    Examples
    --------
    >>> from posreal.network import parse
    >>> str(removed(parse("k1=2 | (c=1 + k2=3)"), 1, shorted=True))
    'k=5'
    """
    if network.counts.levers:
        raise BadDevice("Elements are not removed from a network with levers; realise it without.")
    left = _left(network, index, RIGID if shorted else OPEN, count())
    return simplified(left.unnamed()).unnamed() if isinstance(left, Network) else None


def _left(part: Network, index: int, becomes: str, number: Iterator[int]) -> Part:
    if isinstance(part, Element):
        return becomes if next(number) == index else part
    if isinstance(part, Graph):
        return _of_graph([(u, v, _left(child, index, becomes, number)) for u, v, child in part.branches])
    assert isinstance(part, Series | Parallel)
    children = [_left(child, index, becomes, number) for child in part.children]
    ends, goes = (OPEN, RIGID) if isinstance(part, Series) else (RIGID, OPEN)
    if ends in children:
        return ends
    kept = [child for child in children if isinstance(child, Network)]
    return (series if isinstance(part, Series) else parallel)(*kept) if kept else goes


def _of_graph(branches: list[tuple[int, int, Part]]) -> Part:
    """A graph of which a branch may be open or rigid."""
    moved: dict[int, int] = {}
    for u, v, part in branches:
        if part == RIGID:
            if {u, v} == {0, 1}:
                return RIGID
            moved = {max(u, v): min(u, v)}
    rest = [(moved.get(u, u), moved.get(v, v), part) for u, v, part in branches if isinstance(part, Network)]
    joined = [branch for branch in rest if branch[0] != branch[1]]
    graph = nx.Graph([(1, 0), *((u, v) for u, v, _ in joined)])
    carrying = next(nodes for nodes in nx.biconnected_components(graph) if {0, 1} <= nodes)
    kept = put_together([branch for branch in joined if {*branch[:2]} <= carrying])
    if not kept:
        return OPEN
    return kept[0][2] if len(kept) == 1 else Graph(tuple(kept))


def put_together(branches: list[Branch]) -> list[Branch]:
    """Branches side by side and end to end put together until no more are."""
    while True:
        beside: dict[frozenset[int], list[Branch]] = defaultdict(list)
        for branch in branches:
            beside[frozenset(branch[:2])].append(branch)
        branches = [(*group[0][:2], parallel(*(part for *_, part in group))) for group in beside.values()]
        at: dict[int, list[int]] = defaultdict(list)
        for i, (u, v, _) in enumerate(branches):
            at[u].append(i)
            at[v].append(i)
        node = next((node for node, found in sorted(at.items()) if node > 1 and len(found) == 2), None)
        if node is None:
            return branches
        first, second = (branches[i] for i in at[node])
        start, end = (u if v == node else v for u, v, _ in (first, second))
        branches = [branch for i, branch in enumerate(branches) if i not in at[node]]
        branches.append((start, end, series(first[2], second[2])))
