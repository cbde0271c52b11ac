"""Two-terminal networks that are no tree: bridges, and levers.

A `Graph` joins networks between nodes. Terminal 1 is the first (the body's side), terminal 0 the second;
inner nodes are 2, 3, …. A `Lever` is a rigid massless bar on three nodes, arm – pivot – arm, which keeps

    v_far − v_pivot = n (v_near − v_pivot),      F_near + n F_far = 0,      F_near + F_pivot + F_far = 0:

an ideal transformer with a common terminal. With one inerter or spring beside it, it is the perfectly
coupled pair that Brune's method asks for.

The response follows from nodal analysis: with L the Laplacian of the branch admittances, node 0 held,
A x = 0 the lever equations and λ the forces they need,

    [[L, Aᵀ], [A, 0]] (x, λ) = (e₁, 0),     Y = 1/x₁,
    ∂Y/∂Y_branch = (v_branch/x₁)²,          ∂Y/∂n = 2 λ (v_pivot − v_near)/x₁².
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any

from posreal.admittance.rational import Rational
from posreal.errors import BadDevice, shown
from posreal.network.nodal import nodal_admittance
from posreal.network.response import NodalStep
from posreal.network.tree import DEEPEST, Element, Network, refuse_twins


@dataclass(frozen=True, eq=False, repr=False)
class Lever(Element):
    """A rigid massless bar on three nodes of a `Graph`; its value is the ratio v_far/v_near about the pivot.

    A ratio above zero has both arms on one side of the pivot, one below zero has the pivot between them.
    """

    value: Any = None
    name: str | None = None

    kind, letter, unit = "lever", "n", ""

    def __post_init__(self) -> None:
        self._check()

    def _accept(self, number: Fraction) -> None:
        if number == 0:
            raise BadDevice(f"{self._title} has ratio 0, which holds its far end to the pivot; give any other number.")


@dataclass(frozen=True, eq=False, repr=False)
class Graph(Network):
    """Networks between the nodes of a graph, and levers on them.

    Parameters
    ----------
    branches : sequence of (node, node, Network)
        Nodes may be any labels; inner ones are renumbered 2, 3, … in the order in which they appear.
    levers : sequence of (near, pivot, far, Lever)
    terminals : (node, node)
        Which labels are the two terminals; 1 and 0 if not given.

    Raises
    ------
    BadDevice
        If a branch begins and ends at one node, or a part of the graph hangs at one node only.
    """

    branches: tuple[tuple[int, int, Network], ...]
    levers: tuple[tuple[int, int, int, Lever], ...] = ()
    terminals: tuple[Hashable, Hashable] = field(default=(1, 0))

    def __post_init__(self) -> None:
        number: dict[Hashable, int] = {self.terminals[0]: 1, self.terminals[1]: 0}
        if len(number) < 2:
            raise BadDevice(f"Both terminals are node {shown(self.terminals[0])}; a device has two.")
        branches, levers = [], []
        for *ends, part in self.branches:
            if len(ends) != 2 or not isinstance(part, Network):
                raise BadDevice(f"{shown((*ends, part))} is not a branch; give (node, node, Network).")
            u, v = (number.setdefault(end, len(number)) for end in ends)
            if u == v:
                raise BadDevice(f"The branch {part} begins and ends at node {shown(ends[0])}; give it two nodes.")
            branches.append((u, v, part))
        for *ends, lever in self.levers:
            if len(ends) != 3 or len(set(ends)) != 3 or not isinstance(lever, Lever):
                raise BadDevice(f"{shown((*ends, lever))} is not a lever; give (near, pivot, far, Lever), three nodes.")
            a, m, b = (number.setdefault(end, len(number)) for end in ends)
            levers.append((a, m, b, lever))
        object.__setattr__(self, "branches", tuple(branches))
        object.__setattr__(self, "levers", tuple(levers))
        object.__setattr__(self, "terminals", (1, 0))
        if self.depth > DEEPEST:
            raise BadDevice(f"This network is nested more than {DEEPEST} levels deep; write it flatter.")
        refuse_twins(self.elements())
        self._refuse_loose_parts()

    def _refuse_loose_parts(self) -> None:
        """Every node must lie on a way between the terminals: with a port edge the graph is 2-connected."""
        import networkx as nx

        graph = nx.Graph([(1, 0), *((u, v) for u, v, _ in self.branches)])
        for a, m, b, _ in self.levers:
            graph.add_edges_from([(a, m), (m, b), (a, b)])
        blocks = list(nx.biconnected_components(graph))
        if len(blocks) != 1:
            loose = sorted(set(graph) - next(block for block in blocks if {0, 1} <= block))
            raise BadDevice(f"Node {loose[0]} is on no way from terminal 1 to terminal 0; join it up or leave it out.")

    @property
    def children(self) -> tuple[Network, ...]:  # type: ignore[override]
        """The networks on the branches."""
        return tuple(part for _, _, part in self.branches)

    @cached_property
    def size(self) -> int:  # type: ignore[override]
        """The number of nodes."""
        ends = [node for u, v, _ in self.branches for node in (u, v)]
        return 1 + max([1, *ends, *(node for *triple, _ in self.levers for node in triple)])

    def elements(self) -> tuple[Element, ...]:
        return self._elements

    @cached_property
    def _elements(self) -> tuple[Element, ...]:
        inside = (element for part in self.children for element in part.elements())
        return (*inside, *(lever for *_, lever in self.levers))

    @cached_property
    def depth(self) -> int:
        return 1 + max((part.depth for part in self.children), default=0)

    def admittance(self) -> Rational:
        return nodal_admittance(self)

    def _rebuilt(self, elements: Iterable[Element]) -> Graph:
        source: Iterator[Any] = iter(elements)
        branches = tuple((u, v, part._rebuilt(source)) for u, v, part in self.branches)
        return Graph(branches, tuple((a, m, b, next(source)) for a, m, b, _ in self.levers))

    def _form(self) -> tuple[Any, ...]:
        branches = ((u, v, part._form()) for u, v, part in self.branches)
        return ("graph", *branches, *((a, m, b, lever.value) for a, m, b, lever in self.levers))

    def _written(self, names: Iterator[str]) -> str:
        parts = [f"{u}-{v}: {part._written(names)}" for u, v, part in self.branches]
        parts += [f"{a}-{m}-{b}: {lever._text(next(names))}" for a, m, b, lever in self.levers]
        return "{" + ", ".join(parts) + "}"

    def _step(self, slot: int, children: slice, first_lever: int) -> NodalStep:
        ends = [(u, v) for u, v, _ in self.branches]
        return NodalStep(slot, children, self.size, ends, [(a, m, b) for a, m, b, _ in self.levers], first_lever)


def bridge(first: Network, second: Network, cross: Network, third: Network, fourth: Network) -> Graph:
    """The five-branch bridge.

    ::

        1 ─┬─ first ──┬─ third ──┬─ 0
           │        cross        │
           └─ second ─┴─ fourth ─┘
    """
    return Graph(((1, 2, first), (1, 3, second), (2, 3, cross), (2, 0, third), (3, 0, fourth)))
