"""A network step by step: the implicit midpoint rule as the companion model of each element.

With h the step and bars for means over it, a spring has f̄ = k e + (k h/2) v̄, a damper f̄ = c v̄, an inerter
f̄ = (2 b/h)(v̄ − u), with e its elongation and u its velocity at the begin; then e → e + h v̄ and u → 2 v̄ − u. Each is a
conductance g and a known force r, so that the forces at massless nodes give their velocities by nodal analysis,

    v̄ = a v_t + B (r + λ),      f̄_t = g_t v_t + aᵀ (r + λ),

for the velocity v_t between the terminals and forces λ beside the elements. Any network has this form: bridges, nodes
between springs, inerters in series.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from posreal.errors import BadDevice, BadInput
from posreal.network import Network
from posreal.network.circuit import circuit

Real = np.ndarray


@dataclass(frozen=True)
class Companion:
    """A network's elements over one step.

    Attributes
    ----------
    names : of the E elements
    letters : k, c or b of each
    values : (E,) N/m, N s/m, kg
    terminal : (E,)
        a: velocity of each element for one between the terminals.
    inner : (E, E)
        B: its velocity for forces beside the elements.
    conductance : float
        g_t, N s/m.
    """

    names: tuple[str, ...]
    letters: str
    values: Real
    terminal: Real
    inner: Real
    conductance: float


def _incidence(network: Network) -> tuple[tuple[str, ...], str, Real, Real]:
    """Names, letters, values, and by how much each element stretches with each node but the held one (E, nodes)."""
    flat = circuit(network)
    if flat.bars:
        raise BadInput("a network with levers cannot be simulated; realise the device without them")
    rows = np.zeros((len(flat.edges), flat.size))
    for row, edge in zip(rows, flat.edges, strict=True):
        row[edge.start] += 1.0
        row[edge.end] -= 1.0
    values = np.array([float(edge.element.exact) for edge in flat.edges])
    letters = "".join(edge.element.letter for edge in flat.edges)
    return tuple(edge.name for edge in flat.edges), letters, values, rows[:, 1:]


def companion(network: Network, step: float) -> Companion:
    """The companion model of a network for a step (s)."""
    names, letters, values, rows = _incidence(network)
    per = {"k": step / 2, "c": 1.0, "b": 2 / step}
    g = values * [per[letter] for letter in letters]
    outer, inner = rows[:, :1], rows[:, 1:]
    nodes = inner.T @ (g[:, None] * inner)
    try:
        give = np.linalg.solve(nodes, inner.T) if nodes.size else np.zeros((0, len(g)))
    except np.linalg.LinAlgError:
        raise BadDevice(f"the network {network} has a node that nothing holds") from None
    inside = -inner @ give  # B
    terminal = (outer + inside @ (g[:, None] * outer))[:, 0]
    conductance = float((outer.T @ (g * terminal)).item())
    return Companion(names, letters, values, terminal, inside, conductance)


def element_velocities(network: Network, s: np.ndarray) -> np.ndarray:
    """Velocity of every element for one between the terminals, (E, N) at the points `s` (N,)."""
    _, letters, values, rows = _incidence(network)
    power = np.array(["kcb".index(letter) - 1 for letter in letters])
    y = values[:, None] * s ** power[:, None]
    outer, inner = rows[:, 0], rows[:, 1:]
    if not inner.size:
        return np.repeat(outer[:, None], len(s), axis=1).astype(complex)
    nodes = np.einsum("ei,en,ej->nij", inner, y, inner)
    right = np.einsum("ei,en,e->ni", inner, y, outer)
    moved = -np.linalg.solve(nodes, right[:, :, None])[:, :, 0]
    return np.asarray(outer[:, None] + inner @ moved.T)
