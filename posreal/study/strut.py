"""A design as something to build: the network of the whole strut, and its own figures."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from posreal.design import Design, Problem
from posreal.network import Network, Spring
from posreal.realise import Realisation, realise
from posreal.vehicle import SideView


def realised(design: Design, *, method: str = "auto") -> tuple[Design, Realisation]:
    """The design with a network in its device's place, and everything measured again from that network.

    Parameters
    ----------
    design : Design
        With a device.
    method : str
        A realisation method of :func:`posreal.realise.realise`.

    Returns
    -------
    Design
        Whose device is the network's admittance, recomputed, and whose metrics are the network's.
    Realisation
    """
    assert design.device is not None
    realisation = realise(design.device, method)
    network = realisation.network
    device = network.admittance()
    port = design.problem.mounting.port(device)
    return (
        replace(
            design,
            port=port,
            device=device,
            network=network,
            metrics=design.problem.metrics(port),
            found={**design.found, "realised_by": realisation.method, "residual": realisation.residual},
        ),
        realisation,
    )


def mounted(problem: Problem, network: Network) -> Network:
    """A network in the device's place together with the spring that belongs to the strut: the bush behind it, or the
    static spring beside it (not the airspring, which is a part of its own)."""
    vehicle = problem.vehicle
    if isinstance(vehicle, SideView):
        return Spring(Fraction(vehicle.bush), "k_bush") + network
    static = Fraction(getattr(vehicle, problem.roles["static spring"]))
    return Spring(static, "k_static") | network


def strut(design: Design) -> Network | None:
    """The network of the whole strut, bush or static spring included; None where there is no network."""
    if design.network is None:
        return None
    whole = design.problem.layout_mounting.port(design.network.admittance()) == design.port
    return design.network if whole else mounted(design.problem, design.network)
