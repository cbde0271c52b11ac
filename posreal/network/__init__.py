"""Networks of springs, dampers and inerters: trees, bridges, levers, and every form in which they show."""

from collections.abc import Callable

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


def _shown(how: str) -> Callable[[Network], str]:
    """A notebook's display hook; what draws is loaded when something is shown."""

    def show(network: Network) -> str:
        from posreal.network import notebook

        return str(getattr(notebook, how)(network))

    return show


Network._repr_html_, Network._repr_svg_, Network._repr_latex_ = map(_shown, ("html", "svg", "latex"))

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
