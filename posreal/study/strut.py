"""A design as something to build: the network of the whole strut, and its own figures."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from posreal.design import Design, Problem
from posreal.network import Network, Spring
from posreal.realisation import Realisation, realise
from posreal.vehicle import SideView


def realised(design: Design, *, method: str = "auto") -> tuple[Design, Realisation]:
    """The design with a network in its device's place, and everything measured again from that network.

    Parameters
    ----------
    design : Design
        With a device.
    method : str
        A realisation method of :func:`posreal.realise`.

    Returns
    -------
    Design
        With the network, and the metrics that its own admittance gives.
    Realisation
    """
    assert design.device is not None
    realisation = realise(design.device, method)
    found = {**design.found, "realised_by": realisation.method, "residual": realisation.residual}
    metrics = design.problem.metrics(design.problem.port(realisation.network.admittance(), whole=design.whole))
    return replace(design, network=realisation.network, metrics=metrics, found=found), realisation


def mounted(problem: Problem, network: Network) -> Network:
    """A network in the device's place together with the spring that belongs to the strut: the bush behind it, or the
    static spring beside it (not the airspring, which is a part of its own)."""
    vehicle = problem.vehicle
    if isinstance(vehicle, SideView):
        return Spring(Fraction(vehicle.bush), "k_bush") + network
    if "static spring" not in problem.roles:  # a plant of the user's, which knows of no spring by name
        return network
    static = Fraction(getattr(vehicle, problem.roles["static spring"]))
    return Spring(static, "k_static") | network


def terminals(problem: Problem) -> tuple[str, str]:
    """What a strut stands between."""
    ends = {"quarter-car": ("body", "wheel"), "plant": ("+", "-")}
    return ends.get(problem.vehicle.name, ("body", "bogie"))


def degree(design: Design) -> int:
    """McMillan degree of the whole strut, bush or static spring included."""
    if design.device is None:
        return 0
    if design.whole:
        return design.device.degree
    mounting = design.problem.mounting
    return (design.device if mounting.behind is None else mounting.behind + design.device).degree + (
        mounting.behind is None
    )


def strut(design: Design) -> Network | None:
    """The network of the whole strut, bush or static spring included; None where there is no network."""
    if design.network is None:
        return None
    return design.network if design.whole else mounted(design.problem, design.network)
