"""A network as a SPICE deck, by the force–current analogy [Smith2002].

    velocity ↔ voltage        spring k ↔ inductor 1/k        inerter b ↔ capacitor b
    force ↔ current           damper c ↔ resistor 1/c        lever ↔ ideal transformer

so that the admittance F/v is the electrical one, I/V.

SPICE adds up admittances at each node in doubles: where elements that meet differ by more than 1e10 at some
frequency, its answer has lost digits there which `Network.__call__` and `nodal_value` still have.

[Smith2002] M.C. Smith, Synthesis of mechanical networks: the inerter, IEEE Trans. Automatic Control 47 (2002)
1648–1662.
"""

from __future__ import annotations

from posreal.errors import BadInput
from posreal.network.circuit import Bar, Edge, circuit
from posreal.network.tree import Network

_HEADER = """\
* {title}
* A mechanical network by the force-current analogy:
*   volt = m/s (velocity), ampere = N (force), so admittance I/V = F/v in N s/m
*   inductor L = 1/k (spring, N/m)   resistor R = 1/c (damper, N s/m)   capacitor C = b (inerter, kg)
* Node 1 is the first terminal, node 0 the second. One volt drives node 1: V(y) is Y(j omega).

Vport 1 0 DC 0 AC 1
Hport y 0 Vport -1
"""


def spice(
    network: Network,
    title: str = "mechanical network",
    frequencies: tuple[float, float] = (1e-3, 1e3),
    per_decade: int = 20,
) -> str:
    """The deck, with an AC analysis that prints the real and the imaginary part of Y(jω).

    Parameters
    ----------
    network : Network
        Every element valued.
    title : str
        Its first line.
    frequencies : (float, float)
        Range of the analysis in Hz.
    per_decade : int
        Points in each decade of frequency.

    Raises
    ------
    BadDevice
        If an element has no value.
    BadInput
        If the range is not one, or the title is more than one line.
    """
    low, high = frequencies
    if not 0 < low < high < float("inf") or per_decade < 1:
        raise BadInput(f"{low:g} … {high:g} Hz is no range of frequencies; give two positive ones, the lower first.")
    if not title.isprintable():
        raise BadInput(f"The title {title!r} is not one line of text; give one.")
    flat = circuit(network)
    used: set[str] = set()
    lines = _HEADER.format(title=title).splitlines()
    lines += [_branch(edge, used) for edge in flat.edges]
    lines += [_transformer(bar, used) for bar in flat.bars]
    lines += [
        "* Linear and driven by AC alone: no operating point is needed, and none need exist.",
        "* Values spread over many decades: without strict pivoting, digits are lost.",
        ".options noopac pivrel=0.9 pivtol=1e-30",
        f".ac dec {per_decade} {low!r} {high!r}",
        ".print ac vr(y) vi(y)",
        ".control",
        "set numdgt=15",
        ".endc",
        ".end",
    ]
    return "\n".join(lines) + "\n"


def _branch(edge: Edge, used: set[str]) -> str:
    value = edge.element.exact
    kind, number = {"k": ("L", 1 / value), "c": ("R", 1 / value), "b": ("C", value)}[edge.element.letter]
    return f"{_label(kind, edge.name, used)} {edge.start} {edge.end} {float(number)!r}"


def _transformer(bar: Bar, used: set[str]) -> str:
    ratio = float(bar.lever.exact)
    name = _label("", bar.name, used)
    return "\n".join(
        (
            f"* lever {bar.name}: v({bar.far},{bar.pivot}) = {ratio!r} v({bar.near},{bar.pivot})",
            f"V{name} {bar.far} {name}x 0",
            f"E{name} {name}x {bar.pivot} {bar.near} {bar.pivot} {ratio!r}",
            f"F{name} {bar.near} {bar.pivot} V{name} {-ratio!r}",
        )
    )


def _label(kind: str, name: str, used: set[str]) -> str:
    """SPICE does not tell k1 from K1, so a name met before gets a tail."""
    label = kind + name
    while label.lower() in used:
        label += "_"
    used.add(label.lower())
    return label
