"""Where a graph's parts stand when every node is a vertical rail and every branch a row between two rails.

Terminal 1 is the first rail and 0 the last; the inner ones stand in the order that keeps branches short. The
text diagram and the pictures draw the same plan, each in units of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

from posreal.network.graph import Graph

Size = tuple[float, float]  # width, rows

MOST_SORTED = 6  # inner nodes whose order is searched; more stand as they come


@dataclass
class Span:
    """A branch or a lever laid over the rails first … last."""

    first: int
    last: int
    size: Size
    lever: tuple[int, int, int] | None = None  # rails of near, pivot, far
    gap: int = 0  # the gap between rails in which its box or tag stands
    row: float = 0

    @property
    def touched(self) -> tuple[int, ...]:
        """The rails to which it is joined."""
        return self.lever or (self.first, self.last)


@dataclass
class Plan:
    """The gaps' widths and the spans: branches in the graph's order, then levers in theirs."""

    gaps: list[float]
    spans: list[Span]

    @property
    def rows(self) -> float:
        """The height of the whole."""
        return max(span.row + span.size[1] for span in self.spans)

    def columns(self, thickness: float = 0) -> list[float]:
        """Where each rail stands, given how wide a rail is drawn."""
        return [sum(self.gaps[:i]) + i * thickness for i in range(len(self.gaps) + 1)]

    def joints(self, rail: int) -> dict[float, tuple[bool, bool]]:
        """The rows at which something joins a rail, and whether it does from the left and from the right.

        The network's own wire joins the first and the last rail on row 0.
        """
        found: dict[float, tuple[bool, bool]] = {}
        if rail in (0, len(self.gaps)):
            found[0] = (rail == 0, rail != 0)
        for span in self.spans:
            if rail in span.touched:
                left, right = found.get(span.row, (False, False))
                found[span.row] = (left or rail > span.first, right or rail < span.last)
        return found


def plan(graph: Graph, branches: Sequence[Size], levers: Sequence[Size], margin: float, narrowest: float) -> Plan:
    """Lay out a graph.

    Parameters
    ----------
    graph : Graph
    branches, levers : sequence of (width, rows)
        What each takes up, in the graph's order.
    margin : float
        Wire on each side of a branch's box; a lever's tag has twice as much.
    narrowest : float
        The least gap between rails.
    """
    place = _order(graph)
    spans = []
    for (u, v, _), size in zip(graph.branches, branches, strict=True):
        spans.append(Span(min(place[u], place[v]), max(place[u], place[v]), size))
    for (*nodes, _), size in zip(graph.levers, levers, strict=True):
        near, pivot, far = (place[node] for node in nodes)
        spans.append(Span(min(near, pivot, far), max(near, pivot, far), size, (near, pivot, far)))
    gaps = [narrowest] * (len(place) - 1)
    for span in sorted(spans, key=lambda span: span.last - span.first):
        span.gap = max(range(span.first, span.last), key=lambda gap: (gaps[gap], -gap))
        gaps[span.gap] = max(gaps[span.gap], span.size[0] + (4 if span.lever else 2) * margin)
    _stack(spans)
    return Plan(gaps, spans)


def _stack(spans: list[Span]) -> None:
    """Give every span the first row where it overlaps nothing; short ones first, so that they share rows."""
    laid: list[Span] = []
    for span in sorted(spans, key=lambda span: (span.lever is not None, span.last - span.first)):
        while any(_overlap(span, other) for other in laid):
            span.row += 1
        laid.append(span)


def _overlap(a: Span, b: Span) -> bool:
    rows = a.row < b.row + b.size[1] and b.row < a.row + a.size[1]
    return rows and a.first < b.last and b.first < a.last


def _order(graph: Graph) -> dict[int, int]:
    """Where each node's rail stands: the order with the shortest branches in all."""
    inner = tuple(range(2, graph.size))
    candidates = permutations(inner) if len(inner) <= MOST_SORTED else [inner]
    pairs = [(u, v) for u, v, _ in graph.branches]
    pairs += [pair for a, m, b, _ in graph.levers for pair in ((a, m), (m, b), (a, b))]

    def placed(order: tuple[int, ...]) -> dict[int, int]:
        return {node: i for i, node in enumerate((1, *order, 0))}

    def length(order: tuple[int, ...]) -> int:
        place = placed(order)
        return sum(abs(place[u] - place[v]) for u, v in pairs)

    return placed(min(candidates, key=length))
