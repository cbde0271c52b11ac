"""A network drawn in text.

::

    body ─┬──────[ k1 ]───────┬─ bogie
          └─[ c1 ]─┬─[ k2 ]─┬─┘
                   └─[ b1 ]─┘

A network is a box of text whose wire enters and leaves on the top row: boxes in series stand side by side,
boxes in parallel under one another, a graph on rails. What is too wide is drawn apart and named: ``( A )``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from posreal.errors import BadInput, shown
from posreal.network import railtext
from posreal.network.graph import Graph
from posreal.network.railtext import Box
from posreal.network.tree import Element, Network, Series
from posreal.units import engineering

NARROWEST = 40  # columns

_ASCII = str.maketrans("─│┬┴┘└├┤┼┌┐═╞╡╪△", "-|+++++++++=+++^")


def diagram(
    network: Network,
    terminals: tuple[str, str] = ("body", "bogie"),
    *,
    width: int = 100,
    ascii: bool = False,
    digits: int = 3,
    legend: bool = True,
) -> str:
    """Draw a network in text, with its values in engineering units below.

    Parameters
    ----------
    network : Network
    terminals : (str, str)
        What the device is fixed to: the left end and the right end.
    width : int
        Columns to keep within, 40 or more. What does not fit is drawn apart under a name: ``( A )``.
    ascii : bool
        Draw with ``- | +`` only.
    digits : int
        Significant digits of the values.
    legend : bool
        Whether to list the values.

    Raises
    ------
    BadInput
        If the width is too small, or a terminal's label cannot be drawn.
    """
    for label in terminals:
        if len(label) > width // 4 or not label.isprintable() or (ascii and not label.isascii()):
            raise BadInput(f"The terminal {shown(label)} cannot be drawn; give up to {width // 4} plain characters.")
    if width < NARROWEST:
        raise BadInput(f"A diagram {width} columns wide cannot be read; give {NARROWEST} or more.")
    left, right = terminals
    margin = 2 + len(left) + 2
    root = _fitted(_part(network, iter(network.names)), width - margin - 2 - len(right))
    if root.listed:
        root = _Drawn("named", [root])
    apart = _named_parts(root)
    names = {id(part): _letters(i) for i, part in enumerate(apart)}
    blocks = [_framed(_box(root, names), f"  {left} ─", f"─ {right}")]
    for part in apart:
        start = f"{names[id(part)]} ".rjust(margin - 1)
        if part.listed:
            blocks.append(_framed(_listing(part, names, width - margin), start + " ", ""))
        else:
            blocks.append(_framed(_box(part, names), start + "─", "─"))
    if legend:
        blocks.append(_legend(network, width, digits, ascii))
    between = "\n\n" if apart else "\n"
    text = between.join("\n".join(row.rstrip() for row in block) for block in blocks if block)
    return text.translate(_ASCII) if ascii else text


@dataclass(eq=False)
class _Drawn:
    """A node of what is drawn: like the network's tree, with parts that are drawn apart."""

    kind: str  # tag, series, parallel, graph, named
    children: list[_Drawn] = field(default_factory=list)
    text: str = ""
    graph: Graph | None = None
    levers: list[str] = field(default_factory=list)
    listed: bool = False  # a graph too wide for rails
    size: int = 0  # columns


def _part(network: Network, names: Iterator[str]) -> _Drawn:
    if isinstance(network, Element):
        return _Drawn("tag", text=f"[ {next(names)} ]")
    children = [_part(child, names) for child in network.children]
    if isinstance(network, Graph):
        return _Drawn("graph", children, graph=network, levers=[f"[ {next(names)} ]" for _ in network.levers])
    return _Drawn("series" if isinstance(network, Series) else "parallel", children)


def _fitted(part: _Drawn, limit: int) -> _Drawn:
    """The part with what makes it wider than the limit taken out and named, from the leaves up."""
    part.children = [_fitted(child, limit) for child in part.children]
    part.children = [_Drawn("named", [child]) if child.listed else child for child in part.children]
    while _size(part) > limit and not part.listed:
        wide = [child for child in part.children if child.kind not in ("tag", "named")]
        if wide:
            widest = max(wide, key=lambda child: child.size)
            part.children[part.children.index(widest)] = _Drawn("named", [widest])
        elif part.kind == "graph":
            part.listed = True
        else:
            part.children = _grouped(part.children, limit)
    return part


def _grouped(children: list[_Drawn], limit: int) -> list[_Drawn]:
    """A chain of tags too long for one row, as a chain of named rows."""
    rows: list[list[_Drawn]] = [[]]
    for child in children:
        if rows[-1] and _size(_Drawn("series", [*rows[-1], child])) > limit:
            rows.append([])
        rows[-1].append(child)
    return [row[0] if len(row) == 1 else _Drawn("named", [_Drawn("series", row)]) for row in rows]


def _size(part: _Drawn) -> int:
    part.size = len(_box(part, {})[0])
    return part.size


def _named_parts(root: _Drawn) -> list[_Drawn]:
    """What is drawn apart, in the order in which a reader meets it."""
    found: list[_Drawn] = []
    level = [root]
    while level:
        names = [inner for part in level for inner in _inside(part)]
        found.extend(names)
        level = names
    return found


def _inside(part: _Drawn) -> Iterator[_Drawn]:
    for child in [part] if part.kind == "named" else part.children:
        if child.kind == "named":
            yield child.children[0]
        else:
            yield from _inside(child)


def _letters(index: int) -> str:
    return chr(65 + index) if index < 26 else chr(65 + (index // 26 - 1) % 26) + chr(65 + index % 26)


def _box(part: _Drawn, names: dict[int, str]) -> Box:
    if part.kind == "tag":
        return [part.text]
    if part.kind == "named":
        return [f"( {names.get(id(part.children[0]), 'AA')} )"]
    boxes = [_box(child, names) for child in part.children]
    if part.kind == "series":
        return _in_series(boxes)
    if part.kind == "parallel":
        return _in_parallel(boxes)
    assert part.graph is not None
    return railtext.drawn(boxes, part.levers, part.graph)


def _listing(part: _Drawn, names: dict[int, str], width: int) -> Box:
    assert part.graph is not None
    return railtext.listing([_box(child, names)[0] for child in part.children], part.levers, part.graph, width)


def _in_series(boxes: list[Box]) -> Box:
    height = max(len(box) for box in boxes)
    filled = [box + [" " * len(box[0])] * (height - len(box)) for box in boxes]
    return [("─" if row == 0 else " ").join(box[row] for box in filled) for row in range(height)]


def _in_parallel(boxes: list[Box]) -> Box:
    inner = max(len(box[0]) for box in boxes)
    rows = []
    for i, box in enumerate(boxes):
        first, last = i == 0, i == len(boxes) - 1
        left, right = ("┬", "┬") if first else ("└", "┘") if last else ("├", "┤")
        spare = inner - len(box[0])
        before = spare // 2 if len(box) == 1 and "─" not in box[0] else 0  # a lone tag stands in the middle
        rows.append(f"{left}─{'─' * before}{box[0]}{'─' * (spare - before)}─{right}")
        edge = " " if last else "│"
        rows += [f"{edge} {row.ljust(inner)} {edge}" for row in box[1:]]
    return rows


def _framed(box: Box, start: str, end: str) -> Box:
    return [start + box[0] + end, *(" " * len(start) + row for row in box[1:])]


def _legend(network: Network, width: int, digits: int, ascii: bool) -> Box:
    branches: list[str] = []
    levers: list[str] = []
    for name, element in zip(network.names, network.elements(), strict=True):
        if element.value is not None:
            text = f"{name} = {engineering(element.value, element.unit, digits, ascii)}"
            if element.letter == "n":
                levers.append(text + " (far arm / near arm)")
            else:
                branches.append(text)
    return _in_columns(branches, width) + _in_columns(levers, width)


def _in_columns(cells: list[str], width: int) -> Box:
    if not cells:
        return []
    cell = max(len(text) for text in cells)
    columns = max(1, (width - 2 + 4) // (cell + 4))
    rows = [cells[i : i + columns] for i in range(0, len(cells), columns)]
    return ["  " + "    ".join(text.ljust(cell) for text in row) for row in rows]
