"""Elements with something beside them."""

from __future__ import annotations

from collections.abc import Mapping

from posreal.network.tree import Damper, Element, Network


def with_dampers_across(network: Network, dampers: Mapping[str, float]) -> Network:
    """The network with a damper (N s/m) beside some of its elements, by name; 0 for none. Names are given anew."""
    named = zip(network.names, network.elements(), strict=True)

    def part(name: str, element: Element) -> Network | Element:
        plain = element.altered(element.value, None)
        beside = dampers.get(name, 0.0)
        return plain | Damper(beside) if beside and isinstance(plain, Network) else plain

    rebuilt: Network = network._rebuilt([part(name, element) for name, element in named])  # type: ignore[misc]
    return rebuilt
