"""A device's network together with the spring that the vehicle has at its place."""

from __future__ import annotations

from fractions import Fraction

from posreal.design import Problem
from posreal.network import Network, Spring
from posreal.vehicle import SideView

BUSH, STATIC = "k_bush", "k_static"


def mounted(problem: Problem, network: Network) -> Network:
    """A network in the device's place together with the spring that belongs to the strut: the bush behind it, or the
    static spring beside it (not the airspring, which is a part of its own)."""
    vehicle = problem.vehicle
    if isinstance(vehicle, SideView):
        return Spring(Fraction(vehicle.bush), BUSH) + network
    if "static spring" not in problem.roles:  # a plant of the user's, which knows of no spring by name
        return network
    static = Fraction(getattr(vehicle, problem.roles["static spring"]))
    return Spring(static, STATIC) | network
