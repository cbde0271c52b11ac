"""Networks of springs, dampers and inerters: trees, bridges, levers, and every form in which they show."""

from posreal.network.bridge import Graph, Lever, bridge
from posreal.network.nodal import nodal_admittance, nodal_value
from posreal.network.notation import parse
from posreal.network.tree import (
    Counts,
    Damper,
    Element,
    Inerter,
    Network,
    Parallel,
    Series,
    Spring,
    parallel,
    series,
)

__all__ = [
    "Counts",
    "Damper",
    "Element",
    "Graph",
    "Inerter",
    "Lever",
    "Network",
    "Parallel",
    "Series",
    "Spring",
    "bridge",
    "nodal_admittance",
    "nodal_value",
    "parallel",
    "parse",
    "series",
]
