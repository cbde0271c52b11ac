"""The elements of a network as a table: name, kind, value as an engineer says it, value to the last digit."""

from __future__ import annotations

from dataclasses import dataclass

from posreal.network.tree import Network
from posreal.network.value import write_value
from posreal.units import engineering


@dataclass(frozen=True)
class Row:
    """One element: `value` is short text with a unit, `exact` the same number to every digit in `unit`."""

    name: str
    kind: str
    value: str
    exact: str
    unit: str


def rows(network: Network, digits: int = 3) -> tuple[Row, ...]:
    """The elements in order; an element without a value has empty text."""
    return tuple(
        Row(
            name,
            element.kind,
            "" if element.value is None else engineering(element.value, element.unit, digits),
            "" if element.value is None else write_value(element.value),
            element.unit,
        )
        for name, element in zip(network.names, network.elements(), strict=True)
    )


def table(network: Network, digits: int = 3) -> str:
    """The table as text.

    Examples
    --------
    >>> from posreal.network import parse
    >>> print(table(parse("k=2.45e5 | c=1/3")))
    name  kind    value       exact   unit
    k     spring  245 kN/m    245000  N/m
    c     damper  333 mN·s/m  1/3     N s/m
    """
    lines = [("name", "kind", "value", "exact", "unit")]
    lines += [(row.name, row.kind, row.value, row.exact, row.unit) for row in rows(network, digits)]
    widths = [max(len(line[i]) for line in lines) for i in range(5)]
    cells = ("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) for line in lines)
    return "\n".join(line.rstrip() for line in cells)
