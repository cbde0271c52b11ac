"""Elements and legs from exact numbers, and the dual of a network."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from flint import fmpq

from posreal.admittance.exact import to_fraction
from posreal.errors import BadDevice
from posreal.network import Damper, Element, Graph, Inerter, Lever, Network, Parallel, Series, Spring


def spring(stiffness: fmpq) -> Network:
    """A spring of exact stiffness."""
    return Spring(to_fraction(stiffness))


def damper(damping: fmpq) -> Network:
    """A damper of exact damping."""
    return Damper(to_fraction(damping))


def inerter(inertance: fmpq) -> Network:
    """An inerter of exact inertance."""
    return Inerter(to_fraction(inertance))


def revalued(network: Network, value: Callable[[Element], Fraction]) -> Network:
    """The same network with new values."""
    return network.with_values(dict(zip(network.names, map(value, network.elements()), strict=True)))


def scaled(network: Network, factor: fmpq) -> Network:
    """Every element's admittance multiplied by the factor; levers keep their ratios."""
    ratio = to_fraction(factor)
    return revalued(network, lambda part: part.exact if isinstance(part, Lever) else part.exact * ratio)


def dual(network: Network) -> Network:
    """The network whose admittance is this one's impedance.

    Springs and inerters swap (k becomes b = 1/k), dampers invert, series and parallel swap, and so do the
    two arms of a bridge that do not touch the same terminal.

    Raises
    ------
    BadDevice
        For levers and for graphs other than the five-branch bridge.
    """
    if isinstance(network, Spring):
        return Inerter(1 / network.exact)
    if isinstance(network, Inerter):
        return Spring(1 / network.exact)
    if isinstance(network, Damper):
        return Damper(1 / network.exact)
    if isinstance(network, Series):
        return Parallel(tuple(dual(child) for child in network.children))
    if isinstance(network, Parallel):
        return Series(tuple(dual(child) for child in network.children))
    if isinstance(network, Graph) and not network.levers:
        ends = tuple((u, v) for u, v, _ in network.branches)
        if ends == ((1, 2), (1, 3), (2, 3), (2, 0), (3, 0)):
            first, second, cross, third, fourth = (dual(part) for part in network.children)
            return Graph(((1, 2, first), (1, 3, third), (2, 3, cross), (2, 0, second), (3, 0, fourth)))
    raise BadDevice("The dual of a network with levers, or of a graph that is not a bridge, is not formed here.")
