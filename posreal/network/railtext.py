"""A graph in text, on rails.

::

    ─┬─[ k1 ]─┬─[ b ]─┬─[ k2 ]─┬─
     └─[ c1 ]─│───────┘        │
              └─────────[ c2 ]─┘

A row that crosses a rail without touching it leaves the rail's own symbol: ``─│─``. A lever is a bar,
``╞1═[ n ]═△══n╡``, with its near arm 1, its pivot △ and its far arm n.
"""

from __future__ import annotations

from posreal.network.graph import Graph
from posreal.network.rails import Plan, Span, plan

Box = list[str]

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
}


def drawn(boxes: list[Box], levers: list[str], graph: Graph) -> Box:
    """The graph's box of text, its wire entering and leaving on the top row."""
    texts = [*boxes, *([text] for text in levers)]
    sizes = [(len(box[0]), len(box)) for box in texts]
    arranged = plan(graph, sizes[: len(boxes)], sizes[len(boxes) :], margin=1, narrowest=3)
    columns = [int(column) for column in arranged.columns(thickness=1)]
    canvas = [[" "] * (columns[-1] + 1) for _ in range(int(arranged.rows))]
    for rail, column in enumerate(columns):
        _draw_rail(canvas, arranged, rail, column)
    for span, box in zip(arranged.spans, texts, strict=True):
        _draw_span(canvas, span, box, columns)
    return ["".join(row) for row in canvas]


def listing(branches: list[str], levers: list[str], graph: Graph, width: int) -> Box:
    """The graph as a list of its branches by node number, for where rails would be too wide."""
    cells = [f"{u}─{text}─{v}" for (u, v, _), text in zip(graph.branches, branches, strict=True)]
    cells += [f"{a}╞1═{text}═△{m}═n╡{b}" for (a, m, b, _), text in zip(graph.levers, levers, strict=True)]
    rows = ["from node 1 to node 0:"]
    for cell in cells:
        if len(rows) == 1 or len(rows[-1]) + 3 + len(cell) > width:
            rows.append(cell)
        else:
            rows[-1] += "   " + cell
    return rows


def _draw_rail(canvas: list[list[str]], arranged: Plan, rail: int, column: int) -> None:
    joints = arranged.joints(rail)
    top, bottom = int(min(joints)), int(max(joints))
    for row in range(top, bottom + 1):
        left, right = joints.get(row, (False, False))
        canvas[row][column] = _JOINT[int(row > top), int(row < bottom), int(left), int(right)]


def _draw_span(canvas: list[list[str]], span: Span, box: Box, columns: list[int]) -> None:
    row = int(span.row)
    for column in range(columns[span.first] + 1, columns[span.last]):
        if canvas[row][column] == " ":
            canvas[row][column] = "═" if span.lever else "─"
    start = (columns[span.gap] + columns[span.gap + 1] - len(box[0]) + 1) // 2
    for offset, text in enumerate(box):
        canvas[row + offset][start : start + len(text)] = text
    if span.lever is None:
        return
    near, pivot, far = span.lever
    for rail, mark in ((near, "1"), (far, "n")):
        canvas[row][columns[rail] + (1 if rail < span.last else -1)] = mark
        canvas[row][columns[rail]] = "╞" if rail == span.first else "╡" if rail == span.last else "╪"
    canvas[row][columns[pivot]] = "△"
