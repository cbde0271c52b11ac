"""How a network shows itself in a notebook: its picture and the table of its elements.

The room hangs these on `Network` as its display hooks, so that drawing stays outside the mathematics.
"""

from __future__ import annotations

from html import escape

from posreal.network.diagram import diagram
from posreal.network.latex import formula
from posreal.network.picture import picture
from posreal.network.table import rows
from posreal.network.tree import Network

MOST_DRAWN = 60  # elements; above, the text diagram says more than a picture


def svg(network: Network) -> str:
    """The picture as SVG text."""
    return picture(network, format="svg").decode()


def html(network: Network) -> str:
    """Picture, or text diagram where the network is large, and table."""
    drawn = svg(network) if len(network) <= MOST_DRAWN else f"<pre>{escape(diagram(network, legend=False))}</pre>"
    head = "<tr><th>name</th><th>kind</th><th>value</th><th>exact</th></tr>"
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in (row.name, row.kind, row.value, row.exact)) + "</tr>"
        for row in rows(network)
    )
    return f"<div>{drawn}<table>{head}{body}</table></div>"


def latex(network: Network) -> str:
    """The admittance in symbols, for MathJax."""
    return f"${formula(network)}$"
