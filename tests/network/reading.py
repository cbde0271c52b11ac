"""Reads drawings back: which elements are joined to which, going by the lines alone."""

from __future__ import annotations

import re
from collections.abc import Hashable

from posreal.network import Graph, Network

# For each mark, the directions in which it has a wire: left, right, up, down.
WIRES = {
    "─": "lr", "│": "ud", "┬": "lrd", "┴": "lru", "┼": "lrud", "├": "rud", "┤": "lud",
    "└": "ru", "┘": "lu", "┌": "rd", "┐": "ld",
}  # fmt: skip
STEP = {"l": (0, -1), "r": (0, 1), "u": (-1, 0), "d": (1, 0)}
BACK = {"l": "r", "r": "l", "u": "d", "d": "u"}
TAG = re.compile(r"\[ (\w+) \]|\( ([A-Z]+) \)")


class Joined:
    """Disjoint sets of points that a wire joins."""

    def __init__(self) -> None:
        self._parent: dict[Hashable, Hashable] = {}

    def of(self, point: Hashable) -> Hashable:
        while (above := self._parent.setdefault(point, point)) != point:
            point = above
        return point

    def join(self, a: Hashable, b: Hashable) -> None:
        self._parent[self.of(a)] = self.of(b)


def read_diagram(text: str, elements: dict[str, Network], terminals: tuple[str, str]) -> Graph:
    """The graph that a text diagram without levers shows; parts drawn apart are put in their places."""
    apart: dict[str, Network] = {}
    blocks = text.split("\n\n")
    for block in reversed(blocks[1:]):
        name = block.split()[0]
        apart[name] = _read_block(block, elements | apart, block.index("─"), None)
    first = blocks[0].split("\n")[0]
    start, end = len(f"  {terminals[0]} "), first.rindex(terminals[1]) - 2
    return _read_block(blocks[0], elements | apart, start, end)


def _read_block(block: str, parts: dict[str, Network], start: int, end: int | None) -> Graph:
    rows = block.split("\n")
    end = len(rows[0]) - 1 if end is None else end
    joined = Joined()
    branches = []
    tagged: dict[tuple[int, int], tuple[int, int]] = {}
    for r, row in enumerate(rows):
        for tag in TAG.finditer(row):
            left, right = (r, tag.start()), (r, tag.end() - 1)
            branches.append((left, right, parts[tag[1] or tag[2]]))
            tagged |= dict.fromkeys([(r, c) for c in range(*tag.span())], left)

    def wires(r: int, c: int) -> str:
        mark = rows[r][c] if 0 <= r < len(rows) and 0 <= c < len(rows[r]) else " "
        if (r, c) in tagged:
            return "lr"
        return WIRES.get(mark, "") if start <= c else ""

    def crossed(r: int, c: int) -> bool:
        """A rail with a wire on both sides that does not touch it."""
        return rows[r][c] == "│" and (r, c) not in tagged and "r" in wires(r, c - 1) and "l" in wires(r, c + 1)

    def point(r: int, c: int, direction: str) -> Hashable:
        return (r, c, "across") if direction in "lr" and crossed(r, c) else (r, c)

    for r, row in enumerate(rows):
        for c in range(len(row)):
            for way in wires(r, c) + ("lr" if crossed(r, c) else ""):
                dr, dc = STEP[way]
                near, far = (r, c), (r + dr, c + dc)
                inside = near in tagged and tagged.get(far) == tagged[near]
                facing = wires(*far) if 0 <= far[0] < len(rows) else ""
                if not inside and (BACK[way] in facing or (facing and crossed(*far) and way in "lr")):
                    joined.join(point(r, c, way), point(*far, way))
    ends = (joined.of((0, start)), joined.of((0, end)))
    return Graph(tuple((joined.of(u), joined.of(v), part) for u, v, part in branches), terminals=ends)
