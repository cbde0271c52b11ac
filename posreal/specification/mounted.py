"""A device's network together with the spring that the vehicle has at its place."""

from __future__ import annotations

from fractions import Fraction

from posreal.network import Network, Spring
from posreal.specification.problem import Problem

BUSH, STATIC = "k_bush", "k_static"
NAMES = {"bush": BUSH, "static spring": STATIC}


def mounted(problem: Problem, network: Network) -> Network:
    """A network in the device's place together with the spring that belongs to the strut: the bush behind it, or the
    static spring beside it (not the airspring, which is a part of its own)."""
    for role, name in problem.roles.items():
        spring = Spring(Fraction(getattr(problem.vehicle, name)), NAMES[role])
        network = spring + network if role == "bush" else spring | network
    return network
