"""One line of text for a network: ``k=2.45e5 | (c=21 kN s/m + b=1.53e4)``.

    network   =  branch { "|" branch }                     parallel
    branch    =  part { "+" part }                         series, binds tighter
    part      =  element | "(" network ")" | "{" edge { "," edge } "}"
    element   =  name [ "=" number [ unit ] ]              first letter: k spring, c damper, b inerter
    edge      =  node "-" node ":" network  |  node "-" node "-" node ":" lever
    lever     =  name [ "=" number ]                       near - pivot - far: n, the ratio far/near

Braces hold a graph whose terminals are 1 and 0: a bridge is ``{1-2: k, 1-3: c, 2-3: b, 2-0: c, 3-0: k}``.
Without "=" an element is free. A number is a decimal or p/q. Text is read by this grammar, never evaluated.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, NoReturn

from posreal.errors import BadDevice, plain, shown
from posreal.network.graph import Graph, Lever
from posreal.network.tree import (
    DEEPEST,
    Damper,
    Element,
    Inerter,
    Network,
    Spring,
    parallel,
    read_quantity,
    series,
)

LONGEST = 100_000  # characters
MOST = 2_000  # elements

_KINDS: dict[str, type[Element]] = {"k": Spring, "c": Damper, "b": Inerter, "n": Lever}

_TOKEN = re.compile(
    r"\s*(?:(?P<element>[A-Za-z]\w*)(?:\s*=\s*(?P<value>(?:[^|+(){},:]|(?<=[\d.][eE])\+(?=\d))*))?"
    r"|(?P<mark>[|+(){}])|(?P<stray>\S))",
    re.ASCII,
)
_ENDS = re.compile(r"\s*(\w+)\s*-\s*(\w+)(?:\s*-\s*(\w+))?\s*:", re.ASCII)


def parse(text: str) -> Network:
    """Read a network; ``parse(str(network)) == network``.

    Raises
    ------
    BadDevice
        With the position and what would be accepted there.

    Examples
    --------
    >>> network = parse("k=2.45e5 | (c=21 kN s/m + b)")
    >>> str(network), network.is_valued
    ('k=245000 | c=21000 + b', False)
    """
    if not isinstance(text, str):
        raise BadDevice(f"{shown(text)} is not text; write a network such as 'k=2e5 | (c=2e4 + b=300)'.")
    if len(text) > LONGEST:
        raise BadDevice(f"This text has {len(text)} characters; a network is read up to {LONGEST}.")
    return _NotationReader(text).whole()


@dataclass
class _NotationReader:
    """Recursive descent, one character position at a time."""

    text: str
    at: int = 0
    depth: int = 0
    count: int = 0

    def whole(self) -> Network:
        network = self.network()
        if self.peek():
            self.wrong("'|', '+' or the end")
        return network

    def network(self) -> Network:
        self.depth += 1
        if self.depth > DEEPEST:
            raise BadDevice(f"Parentheses are more than {DEEPEST} deep at position {self.at}; write it flatter.")
        branches = [self.branch()]
        while self.take("|"):
            branches.append(self.branch())
        self.depth -= 1
        return parallel(*branches)

    def branch(self) -> Network:
        parts = [self.part()]
        while self.take("+"):
            parts.append(self.part())
        return series(*parts)

    def part(self) -> Network:
        if self.take("("):
            inner = self.network()
            if not self.take(")"):
                self.wrong("')'")
            return inner
        if self.take("{"):
            return self.graph()
        element = self.element("an element such as 'k=2e5', 'c' or 'b1', '(' or '{'")
        if not isinstance(element, Network):
            raise BadDevice(
                f"The lever {plain(element.name or 'n', 32)} stands on three nodes; write it in braces, '1-2-3: n=0.5'."
            )
        return element

    def graph(self) -> Graph:
        branches: list[Any] = []
        levers: list[Any] = []
        while True:
            ends = _ENDS.match(self.text, self.at)
            if ends is None:
                self.wrong("an edge such as '1-2: k' or a lever such as '1-2-3: n=0.5'")
            self.at = ends.end()
            u, v, w = (int(node) if node and node.isdigit() else node for node in ends.groups())
            if w is None:
                branches.append((u, v, self.network()))
            else:
                lever = self.element("a lever such as 'n=0.5'")
                if not isinstance(lever, Lever):
                    raise BadDevice(
                        f"{plain(ends.group().strip(), 60)} names three nodes, which takes a lever such as 'n=0.5'."
                    )
                levers.append((u, v, w, lever))
            if self.peek() == "}":
                break
            if self.peek() != ",":
                self.wrong("',' or '}'")
            self.at = self.text.index(",", self.at) + 1
        self.take("}")
        return Graph(tuple(branches), tuple(levers))

    def element(self, wanted: str) -> Element:
        match = _TOKEN.match(self.text, self.at)
        if match is None or match["element"] is None:
            self.wrong(wanted)
        name, value = match["element"], match["value"]
        kind = _KINDS.get(name[0])
        if kind is None:
            self.wrong(f"a name beginning with k (spring), c (damper) or b (inerter), not {shown(name)}")
        self.count += 1
        if self.count > MOST:
            raise BadDevice(f"This network has more than {MOST} elements; that is as many as are read.")
        self.at = match.end()
        if value is None:
            return kind(None, name)  # type: ignore[call-arg]
        try:
            return kind(read_quantity(value.strip(), kind), name)  # type: ignore[call-arg]
        except BadDevice as error:
            raise BadDevice(f"{plain(name, 32)} at position {match.start('element')}: {error}") from None

    def peek(self) -> str:
        while self.at < len(self.text) and self.text[self.at].isspace():
            self.at += 1
        return self.text[self.at : self.at + 1]

    def take(self, mark: str) -> bool:
        if self.peek() != mark:
            return False
        self.at += 1
        return True

    def wrong(self, wanted: str) -> NoReturn:
        found = self.peek()
        what = f"{shown(found)} at position {self.at}" if found else "the end"
        raise BadDevice(f"A network was read up to {what}, where {wanted} would be accepted.")
