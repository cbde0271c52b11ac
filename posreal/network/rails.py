"""A graph in text: every node a vertical rail, every branch a row between two rails.

::

    ┬─[ k1 ]─┬─[ b ]─┬─[ k2 ]─┬
    ├────────│─[ c1 ]┤        │
             └───────│─[ c2 ]─┘

Terminal 1 is the first rail and 0 the last. A row that crosses a rail without touching it breaks the rail's symbol
(``─│─``). A lever is a bar ``╞1═[ n ]═△══n╡``: near arm 1, pivot △, far arm n.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

from posreal.network.bridge import Graph

Box = list[str]

MOST_SORTED = 6  # inner nodes whose order is searched; more stand as they come

_JOINT = {  # (up, down, left, right)
    (0, 1, 1, 1): "┬",
    (1, 0, 1, 1): "┴",
    (1, 1, 1, 1): "┼",
    (1, 1, 0, 1): "├",
    (1, 1, 1, 0): "┤",
    (1, 0, 0, 1): "└",
    (1, 0, 1, 0): "┘",
    (0, 1, 0, 1): "┌",
    (0, 1, 1, 0): "┐",
    (0, 0, 1, 1): "─",
    (1, 1, 0, 0): "│",
    (0, 0, 0, 1): "─",
    (0, 0, 1, 0): "─",
    (1, 0, 0, 0): "│",
    (0, 1, 0, 0): "│",
}


@dataclass
class _Span:
    """A branch or lever laid over the rails first … last (positions, not nodes)."""

    first: int
    last: int
    box: Box
    lever: tuple[int, int, int] | None = None
    gap: int = 0  # where the box stands
    row: int = 0


def drawn(boxes: list[Box], levers: list[str], graph: Graph) -> Box:
    """The graph's box of text, its wire entering and leaving on the top row."""
    place = _order(graph)
    spans = [
        _Span(*sorted((place[u], place[v])), box)
        for (u, v, _), box in zip(graph.branches, boxes, strict=True)
    ]
    for (*ends, _), text in zip(graph.levers, levers, strict=True):
        near, pivot, far = (place[node] for node in ends)
        spans.append(_Span(min(near, pivot, far), max(near, pivot, far), [text], (near, pivot, far)))
    widths = _gaps(spans, len(place))
    _stack(spans)
    columns = [sum(widths[:i]) + i for i in range(len(place))]
    height = max(span.row + len(span.box) for span in spans)
    canvas = [[" "] * (columns[-1] + 1) for _ in range(height)]
    _draw_rails(canvas, spans, columns)
    for span in spans:
        _draw_span(canvas, span, columns)
    return ["".join(row) for row in canvas]


def listing(texts: tuple[list[str], list[str]], graph: Graph | None, width: int) -> Box:
    """The graph as a list of its branches by node number, for where rails are too wide."""
    assert graph is not None
    branches, levers = texts
    cells = [f"{u}─{text}─{v}" for (u, v, _), text in zip(graph.branches, branches, strict=True)]
    cells += [
        f"{a}╞1═{text}═△{m}═n╡{b}" for (a, m, b, _), text in zip(graph.levers, levers, strict=True)
    ]
    rows = ["from node 1 to node 0:"]
    for cell in cells:
        if len(rows) == 1 or len(rows[-1]) + 3 + len(cell) > width:
            rows.append(cell)
        else:
            rows[-1] += "   " + cell
    return rows


def padded(text: str, width: int, centred: bool) -> str:
    """Text filled with wire to a width."""
    spare = width - len(text)
    before = spare // 2 if centred else 0
    return "─" * before + text + "─" * (spare - before)


def _order(graph: Graph) -> dict[int, int]:
    """Where each node's rail stands: the order with the shortest branches in all."""
    inner = list(range(2, graph.size))
    candidates = permutations(inner) if len(inner) <= MOST_SORTED else [tuple(inner)]
    pairs = [(u, v) for u, v, _ in graph.branches]
    pairs += [pair for a, m, b, _ in graph.levers for pair in ((a, m), (m, b), (a, b))]

    def placed(order: tuple[int, ...]) -> dict[int, int]:
        return {node: i for i, node in enumerate((1, *order, 0))}

    def length(order: tuple[int, ...]) -> int:
        place = placed(order)
        return sum(abs(place[u] - place[v]) for u, v in pairs)

    return placed(min(candidates, key=length))


def _gaps(spans: list[_Span], count: int) -> list[int]:
    """The widths between rails; a longer branch stands in the gap that is widest already."""
    widths = [3] * (count - 1)
    for span in sorted(spans, key=lambda span: span.last - span.first):
        need = len(span.box[0]) + (4 if span.lever else 2)
        span.gap = max(range(span.first, span.last), key=lambda gap: (widths[gap], -gap))
        widths[span.gap] = max(widths[span.gap], need)
    return widths


def _stack(spans: list[_Span]) -> None:
    """Give every span the first row on which it overlaps nothing; short ones first, so that they share rows."""
    laid: list[_Span] = []
    for span in sorted(spans, key=lambda span: (span.lever is not None, span.last - span.first)):
        while any(
            span.row < other.row + len(other.box)
            and other.row < span.row + len(span.box)
            and span.first < other.last
            and other.first < span.last
            for other in laid
        ):
            span.row += 1
        laid.append(span)


def _touches(span: _Span) -> tuple[int, ...]:
    return span.lever or (span.first, span.last)


def _draw_rails(canvas: list[list[str]], spans: list[_Span], columns: list[int]) -> None:
    last = len(columns) - 1
    for rail, column in enumerate(columns):
        joints = {span.row: [0, 0] for span in spans if rail in _touches(span)}
        if rail in (0, last):
            joints.setdefault(0, [0, 0])[0 if rail == 0 else 1] = 1
        for span in spans:
            if rail in _touches(span):
                joints[span.row][0] |= rail > span.first
                joints[span.row][1] |= rail < span.last
        top, bottom = min(joints), max(joints)
        for row in range(top, bottom + 1):
            left, right = joints.get(row, (0, 0))
            canvas[row][column] = _JOINT[int(row > top), int(row < bottom), int(left), int(right)]


def _draw_span(canvas: list[list[str]], span: _Span, columns: list[int]) -> None:
    wire = "═" if span.lever else "─"
    for column in range(columns[span.first] + 1, columns[span.last]):
        if canvas[span.row][column] == " ":
            canvas[span.row][column] = wire
    left, right = columns[span.gap] + 1, columns[span.gap + 1]
    start = left + 1 + (right - left - 2 - len(span.box[0])) // 2
    for offset, text in enumerate(span.box):
        for i, mark in enumerate(text):
            canvas[span.row + offset][start + i] = mark
    if span.lever is None:
        return
    near, pivot, far = span.lever
    for rail, mark in ((near, "1"), (far, "n")):
        canvas[span.row][columns[rail] + (1 if rail < span.last else -1)] = mark
        canvas[span.row][columns[rail]] = "╞" if rail == span.first else "╡" if rail == span.last else "╪"
    canvas[span.row][columns[pivot]] = "△"
