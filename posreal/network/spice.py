"""A network as a SPICE deck, by the force–current analogy [Smith2002].

    velocity ↔ voltage        spring k ↔ inductor 1/k        inerter b ↔ capacitor b
    force ↔ current           damper c ↔ resistor 1/c        lever ↔ ideal transformer

so that the admittance F/v is the electrical one, I/V.

SPICE adds up admittances at each node in doubles, and a small one next to large ones is lost: in b₁ + b₂ + c the sum
b₁ s + b₂ s + … keeps nothing of a c that is 1e16 times smaller, though it alone is felt at the terminals. Rounding the
sum at node a by δ changes Y by δ (v_a/v₁)², so what is lost in all is about

    2⁻⁵³ Σ |Y_e| (|v_a|² + |v_b|²)/(|v₁|² |Y|),      over elements e between nodes a and b.

Where that is little, the deck is the network itself. Where it is not, the series joints stand apart: the force through
one is the voltage of a node of its own, to which each element in series adds its mobility (damper c as R = c, spring k
as C = 1/k, inerter b as L = b), tied to the joint's ends by a gyrator, two controlled sources of gain one:

    V(m) = F,     Σ V(m)/Y_e + Σ v_part = v_a − v_b,     F from a to b.

Then every sum is one of admittances in parallel or of mobilities in series, as in `Network.__call__`. Graphs keep their
nodes, with elements between inner nodes behind gyrators too; the force through a graph is what arrives at its node 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from posreal.errors import BadInput, shown
from posreal.network.circuit import Circuit, circuit
from posreal.network.graph import Graph
from posreal.network.response import Array
from posreal.network.tree import Element, Network, Parallel, Series

LOST = 1e-9
"""Estimated part of Y lost to rounding above which series joints stand apart."""
POINTS = 4  # in each decade, where that is estimated

_HEADER = """\
* {title}
* A mechanical network by the force-current analogy:
*   volt = m/s (velocity), ampere = N (force), so admittance I/V = F/v in N s/m
*   inductor L = 1/k (spring, N/m)   resistor R = 1/c (damper, N s/m)   capacitor C = b (inerter, kg)
* Node 1 is the first terminal, node 0 the second. One volt drives node 1: V(y) is Y(j omega).
"""
_APART = """\
* The values spread too far to be added up at nodes in doubles. So parts in series stand apart:
*   V(m1), V(m2) ... are the forces through them, 1 V = 1 N; an element there is a mobility to ground,
*   R = c, C = 1/k or L = b, and a pair of sources G ties the force to the velocity across the parts.
"""
WRITTEN = "* As posreal writes it: "
"""Begins the comment that has the network in one line."""
_SOURCE = """
Vport 1 0 DC 0 AC 1
Hport y 0 Vport -1
"""
END_OF_CIRCUIT = "* Linear and driven by AC alone"
_ANALYSIS = """\
* Linear and driven by AC alone: no operating point is needed, and none need exist.
* An analysis for each decade: pivots are chosen anew in each, and strictly, or digits are lost.
.options noopac pivrel=0.9 pivtol=1e-30
.control
set numdgt=15
{analyses}
quit 0
.endc
.end
"""


def spice(
    network: Network,
    title: str = "mechanical network",
    frequencies: tuple[float, float] = (1e-3, 1e3),
    per_decade: int = 20,
) -> str:
    """The deck, with AC analyses that print the real and the imaginary part of Y(jω).

    Parameters
    ----------
    network : Network
        Every element valued.
    title : str
        Its first line.
    frequencies : (float, float)
        Range of the analyses in Hz.
    per_decade : int
        Points in each decade of frequency; more where the range would have none between its ends.

    Raises
    ------
    BadDevice
        If an element has no value.
    BadInput
        If the range is not one, or the title is more than one line.
    """
    low, high = frequencies
    if not 0 < low < high < float("inf") or per_decade < 1:
        raise BadInput(f"{low:g} … {high:g} Hz is no range of frequencies; give two positive ones, the lower first.")
    if not title.isprintable():
        raise BadInput(f"The title {shown(title)} is not one line of text; give one.")
    flat = circuit(network)
    decades = math.log10(high / low)
    omega = 2 * np.pi * np.geomspace(low, high, 2 + int(POINTS * decades))
    deck = _Deck()
    header = _HEADER.format(title=title) + f"{WRITTEN}{network}\n"
    if _lost(flat, 1j * omega) < LOST:
        for edge in flat.edges:
            deck.element(edge.name, edge.element, str(edge.start), str(edge.end))
        for bar in flat.bars:
            deck.lever(bar.name, bar.lever, str(bar.near), str(bar.pivot), str(bar.far))
    else:
        header += _APART
        deck.place(network, iter(network.names), "1", "0")
    ends = [float(end) for end in np.geomspace(low, high, 1 + math.ceil(decades - 1e-9))]
    ends[0], ends[-1] = float(low), float(high)
    # ngspice never returns from a range shorter than its step
    steps = max(per_decade, math.ceil(1 / math.log10(ends[1] / ends[0])))
    analyses = "\n".join(f"ac dec {steps} {first!r} {last!r}\nprint vr(y) vi(y)" for first, last in pairwise(ends))
    return header + _SOURCE + "\n".join(deck.lines) + "\n" + _ANALYSIS.format(analyses=analyses)


def _lost(flat: Circuit, s: Array) -> float:
    """The part of Y that rounding costs where admittances are added up at the nodes; see the module."""
    graph = Graph(
        tuple((edge.start, edge.end, edge.element) for edge in flat.edges),  # type: ignore[misc]
        tuple((bar.near, bar.pivot, bar.far, bar.lever) for bar in flat.bars),  # type: ignore[misc]
    )
    elements = [edge.element for edge in flat.edges]
    y = np.array([float(part.exact) * s ** ("kcb".index(part.letter) - 1) for part in elements])
    ratios = np.array([float(bar.lever.exact) for bar in flat.bars])
    with np.errstate(all="ignore"):
        velocity, _ = graph._step(0, slice(0, len(y)), 0).motion(y, ratios)
        starts, ends, _ = zip(*graph.branches, strict=True)
        u, v = velocity[:, starts].T, velocity[:, ends].T
        sums = np.sum(np.abs(y) * (np.abs(u) ** 2 + np.abs(v) ** 2), axis=0)
        power = np.abs(np.sum(y * (u - v) ** 2, axis=0))  # Y, by reciprocity
    return float(np.max(2.0**-53 * sums / power))


@dataclass
class _Deck:
    """The lines of a deck as they are written."""

    lines: list[str] = field(default_factory=list)
    _used: set[str] = field(default_factory=set)
    _nodes: int = 0

    def element(self, name: str, element: Element, start: str, end: str) -> None:
        """An element between two nodes."""
        value = element.exact
        kind, number = {"k": ("L", 1 / value), "c": ("R", 1 / value), "b": ("C", value)}[element.letter]
        self.lines.append(f"{self._label(kind, name)} {start} {end} {float(number)!r}")

    def lever(self, name: str, lever: Element, near: str, pivot: str, far: str) -> None:
        """An ideal transformer on three nodes."""
        ratio = float(lever.exact)
        label = self._label("", name)
        self.lines += [
            f"* lever {name}: v({far},{pivot}) = {ratio!r} v({near},{pivot})",
            f"V{label} {far} {label}x 0",
            f"E{label} {label}x {pivot} {near} {pivot} {ratio!r}",
            f"F{label} {near} {pivot} V{label} {-ratio!r}",
        ]

    def place(self, part: Network, names: Iterator[str], start: str, end: str) -> None:
        """A part between two nodes, its series joints apart."""
        if isinstance(part, Series):
            self._series(part.children, names, start, end)
        elif isinstance(part, Parallel):
            for child in part.children:
                self.place(child, names, start, end)
        elif isinstance(part, Graph):
            self._graph(part, names, start, end)
        else:
            self.element(next(names), part.elements()[0], start, end)

    def _series(self, parts: Sequence[Network], names: Iterator[str], start: str, end: str) -> None:
        force = self._node()
        self._gyrator(force, start, end)
        for part in parts:
            if isinstance(part, Element):
                value = part.exact
                kind, number = {"k": ("C", 1 / value), "c": ("R", value), "b": ("L", value)}[part.letter]
                self.lines.append(f"{self._label(kind, next(names))} {force} 0 {float(number)!r}")
            else:
                inner = self._node()
                self._gyrator(force, inner, "0", sign=-1)
                self.place(part, names, inner, "0")

    def _graph(self, graph: Graph, names: Iterator[str], start: str, end: str) -> None:
        nodes = [self._node() for _ in range(graph.size)]
        label = nodes[0]
        self.lines += [
            f"* a graph between {nodes[1]} and {nodes[0]}, which take the velocities of {start} and {end}",
            f"E{label} {nodes[1]} 0 {start} {end} 1",
            f"V{label} {nodes[0]} 0 0",
            f"F{label} {start} {end} V{label} 1",
        ]
        for u, v, part in graph.branches:
            if min(u, v) > 1 and not isinstance(part, Series):
                self._series([part], names, nodes[u], nodes[v])
            else:
                self.place(part, names, nodes[u], nodes[v])
        for near, pivot, far, lever in graph.levers:
            self.lever(next(names), lever, nodes[near], nodes[pivot], nodes[far])

    def _gyrator(self, force: str, start: str, end: str, sign: int = 1) -> None:
        """V(force) amperes from `start` to `end`, and the velocity across them into the node `force`."""
        label = self._label("", f"{force}{start}")
        self.lines += [f"G{label} {start} {end} {force} 0 {sign}", f"G{label}v {force} 0 {start} {end} {-sign}"]

    def _node(self) -> str:
        self._nodes += 1
        return f"m{self._nodes}"

    def _label(self, kind: str, name: str) -> str:
        """SPICE does not tell k1 from K1, so a name met before gets a tail."""
        label = kind + name
        while label.lower() in self._used:
            label += "_"
        self._used.add(label.lower())
        return label
