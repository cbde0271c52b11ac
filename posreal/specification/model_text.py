"""An admittance in a model's file: a function of s, or a network in the notation of devices, parameters in both.

``Ksz/s + Csz``, or ``k=Ksz | c=Csz``: whatever has ``=``, ``|`` or braces in it is a network. An element's value is a
number, with or without a unit, or the name of a parameter; ``k | c`` takes the parameters k and c themselves.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator

from posreal.admittance.parse import HEAD
from posreal.errors import BadInput, shown
from posreal.network import Graph, Network, Parallel, Series, parse
from posreal.network.tree import Element
from posreal.network.value import write_value

_ASSIGNED = re.compile(r"\b([kcb]\w*)(?:\s*=\s*([A-Za-z_]\w*)(?=\s*(?:[|+)},]|$)))?(?!\s*=)", re.ASCII)


def admittance_text(text: str, parameters: Collection[str]) -> str:
    """The text as a function of s in which parameters stand by name.

    Raises
    ------
    BadInput
        If a network cannot be read, or has an element without a value.
    """
    if not (("=" in text and not HEAD.match(text)) or set(text) & set("|{")):
        return text
    named: dict[str, str] = {}

    def unvalued(match: re.Match[str]) -> str:
        element, value = match[1], match[2] or match[1]
        if value not in parameters:
            return match[0]
        alone = f"{element[0]}_{len(named)}"
        named[alone] = value
        return alone

    network = parse(_ASSIGNED.sub(unvalued, text))
    values = []
    for name, element in zip(network.names, network.elements(), strict=True):
        if element.value is None and name not in named:
            raise BadInput(f"{name} in {shown(text)} has no value, and there is no parameter of that name")
        values.append(named[name] if name in named else write_value(element.exact))
    return _function(network, iter(values))


def _function(network: Network, values: Iterator[str]) -> str:
    if isinstance(network, Element):
        return {"k": "({})/s", "c": "({})", "b": "({})*s"}[network.letter].format(next(values))
    if isinstance(network, Graph) or not isinstance(network, Series | Parallel):
        raise BadInput("a graph in braces has no place in a model's file; give its admittance as a function of s")
    parts = [_function(child, values) for child in network.children]
    if isinstance(network, Parallel):
        return " + ".join(f"({part})" for part in parts)
    return "1/(" + " + ".join(f"1/({part})" for part in parts) + ")"
