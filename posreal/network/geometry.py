"""Where everything stands in a picture of a network: the one geometry behind schemdraw and LaTeX.

x runs to the right and an element is two long; y runs down and each row of the network is one. Parallel
branches stand under one another, series ones side by side, a graph on rails as in the text diagram.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from posreal.network import rails
from posreal.network.graph import Graph, Lever
from posreal.network.tree import Element, Network, Series

LENGTH = 2.0  # of an element
MARGIN = 0.4  # of wire between a rail and what hangs on it

Point = tuple[float, float]


@dataclass(frozen=True)
class Placed:
    """An element from (x, y) to (x + LENGTH, y)."""

    x: float
    y: float
    name: str
    element: Element


@dataclass(frozen=True)
class Beam:
    """A lever: its near, pivot and far points at height y."""

    near: float
    pivot: float
    far: float
    y: float
    name: str
    lever: Lever


@dataclass
class Geometry:
    """A picture's parts; the network's wire enters at (0, 0) and leaves at (width, 0)."""

    width: float
    rows: float
    elements: list[Placed] = field(default_factory=list)
    beams: list[Beam] = field(default_factory=list)
    wires: list[tuple[Point, Point]] = field(default_factory=list)
    dots: list[Point] = field(default_factory=list)


def geometry(network: Network) -> Geometry:
    """Place every element, wire, junction and lever of a network."""
    width, rows = _size(network)
    picture = Geometry(width + 2 * MARGIN, rows)
    picture.wires += [((0, 0), (MARGIN, 0)), ((MARGIN + width, 0), (picture.width, 0))]
    _place(network, iter(network.names), picture, MARGIN, 0, width)
    return picture


def _size(network: Network) -> rails.Size:
    if isinstance(network, Element):
        return LENGTH, 1
    if isinstance(network, Graph):
        plan = _plan(network)
        return sum(plan.gaps), plan.rows
    sizes = [_size(child) for child in network.children]
    if isinstance(network, Series):
        return sum(width for width, _ in sizes) + MARGIN * (len(sizes) - 1), max(rows for _, rows in sizes)
    return max(width for width, _ in sizes) + 2 * MARGIN, sum(rows for _, rows in sizes)


def _plan(graph: Graph) -> rails.Plan:
    branches = [_size(part) for part in graph.children]
    return rails.plan(graph, branches, [(0.0, 1.0)] * len(graph.levers), MARGIN, LENGTH + 2 * MARGIN)


def _place(network: Network, names: Iterator[str], picture: Geometry, x: float, y: float, width: float) -> None:
    """Draw a network on a stretch of wire from (x, y), as wide as it needs or wider."""
    spare = width - _size(network)[0]
    if isinstance(network, Element):
        picture.elements.append(Placed(x + spare / 2, y, next(names), network))
        _wire(picture, x, x + spare / 2, y)
        _wire(picture, x + spare / 2 + LENGTH, x + width, y)
    elif isinstance(network, Graph):
        _place_graph(network, names, picture, x, y)
        _wire(picture, x + width - spare, x + width, y)
    elif isinstance(network, Series):
        share = spare / len(network.children)
        for i, child in enumerate(network.children):
            own = _size(child)[0] + share
            _place(child, names, picture, x, y, own)
            x += own
            if i < len(network.children) - 1:
                _wire(picture, x, x + MARGIN, y)
                x += MARGIN
    else:
        _place_parallel(network, names, picture, x, y, width)


def _place_parallel(
    network: Network, names: Iterator[str], picture: Geometry, x: float, y: float, width: float
) -> None:
    children = network.children
    row = y
    for i, child in enumerate(children):
        _place(child, names, picture, x + MARGIN, row, width - 2 * MARGIN)
        for end in (x, x + width):
            _wire(picture, *((end, end + MARGIN) if end == x else (end - MARGIN, end)), row)
            if i < len(children) - 1:
                picture.dots.append((end, row))
        last = row
        row += _size(child)[1]
    picture.wires += [((end, y), (end, last)) for end in (x, x + width)]


def _place_graph(graph: Graph, names: Iterator[str], picture: Geometry, x: float, y: float) -> None:
    plan = _plan(graph)
    columns = [x + column for column in plan.columns()]
    for rail, column in enumerate(columns):
        joints = plan.joints(rail)
        top, bottom = min(joints), max(joints)
        if bottom > top:
            picture.wires.append(((column, y + top), (column, y + bottom)))
        for row, (left, right) in joints.items():
            if left + right + (row > top) + (row < bottom) > 2:
                picture.dots.append((column, y + row))
    for span, part in zip(plan.spans, graph.children, strict=False):
        width = _size(part)[0]
        start = (columns[span.gap] + columns[span.gap + 1] - width) / 2
        _wire(picture, columns[span.first], start, y + span.row)
        _place(part, names, picture, start, y + span.row, width)
        _wire(picture, start + width, columns[span.last], y + span.row)
    for span, (*_, lever) in zip(plan.spans[len(graph.branches) :], graph.levers, strict=True):
        assert span.lever is not None
        near, pivot, far = (columns[rail] for rail in span.lever)
        picture.beams.append(Beam(near, pivot, far, y + span.row, next(names), lever))


def _wire(picture: Geometry, start: float, end: float, y: float) -> None:
    if end - start > 1e-9:
        picture.wires.append(((start, y), (end, y)))
