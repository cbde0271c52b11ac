"""Turning the frequency axis round: Y(1/s), in which springs and inerters change places with their numbers."""

from __future__ import annotations

from flint import fmpq_poly

from posreal.admittance import Rational
from posreal.network import Damper, Graph, Inerter, Network, Parallel, Series, Spring


def turned_device(y: Rational) -> Rational:
    """Y(1/s)."""
    n, d = (fmpq_poly([p[y.degree - i] for i in range(y.degree + 1)]) for p in (y.n, y.d))
    return Rational(n, d)


def turned_network(network: Network) -> Network:
    """The network whose admittance is this one's at 1/s; levers stay as they are."""
    if isinstance(network, Spring):
        return Inerter(network.exact)
    if isinstance(network, Inerter):
        return Spring(network.exact)
    if isinstance(network, Damper):
        return network
    if isinstance(network, Graph):
        return Graph(tuple((u, v, turned_network(part)) for u, v, part in network.branches), network.levers)
    assert isinstance(network, Series | Parallel)
    return type(network)(tuple(turned_network(child) for child in network.children))
