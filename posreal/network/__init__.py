"""Networks of springs, dampers and inerters: trees, bridges, levers, and every form in which they show."""

from posreal.network.canonical import canonical_key, isomorphic
from posreal.network.graph import Graph, Lever, bridge
from posreal.network.nodal import nodal_admittance, nodal_value
from posreal.network.notation import parse
from posreal.network.simplify import simplified
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
    "canonical_key",
    "isomorphic",
    "nodal_admittance",
    "nodal_value",
    "parallel",
    "parse",
    "series",
    "simplified",
]
