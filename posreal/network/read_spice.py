"""A SPICE deck of a one-port, read back as a network by the force–current analogy of :mod:`.spice`.

Resistors, inductors and capacitors become dampers (c = 1/R), springs (k = 1/L) and inerters (b = C); the terminals are
the nodes of the one independent source, or 1 and 0 where there is none. A deck of posreal's own has the network in a
comment, exactly; that is taken where the deck is what posreal writes for it, and passed over where it has been edited.
"""

from __future__ import annotations

import re
from fractions import Fraction

from posreal.admittance import exact
from posreal.errors import BadDevice, plain, shown
from posreal.network.graph import Graph
from posreal.network.notation import MOST, parse
from posreal.network.removal import put_together
from posreal.network.spice import END_OF_CIRCUIT, WRITTEN, spice
from posreal.network.tree import Damper, Inerter, Network, Spring

Branch = tuple[str, str, Network]

_KINDS: dict[str, type[Damper | Spring | Inerter]] = {"R": Damper, "L": Spring, "C": Inerter}
_VALUE = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,4})?)(meg|mil|[tgkmunpf])?[a-z]*", re.I | re.ASCII)
_SUFFIX = {
    **{"t": Fraction(10**12), "g": Fraction(10**9), "meg": Fraction(10**6), "k": Fraction(1000)},
    **{"mil": Fraction(254, 10**7), "m": Fraction(1, 1000), "u": Fraction(1, 10**6), "n": Fraction(1, 10**9)},
    **{"p": Fraction(1, 10**12), "f": Fraction(1, 10**15)},
}


def read_spice(text: str) -> Network:
    """The network of a deck.

    Parameters
    ----------
    text : str
        A title line, then R, L and C elements between two nodes with a value each (scale factors such as ``k``,
        ``meg``, ``u``), and at most one source V or I, whose nodes are the port. Comments, ``.`` lines, and what stands
        between ``.control`` and ``.endc``, are passed over.

    Raises
    ------
    BadDevice
        Naming the line of another element, of a value that is none, or of a second source.
    """
    own = _own(text)
    return own if own is not None else _read(text)


def _own(text: str) -> Network | None:
    """The network in the comment of a deck that posreal wrote, if the rest is its own too."""
    lines = text.splitlines()
    found = [line.removeprefix(WRITTEN) for line in lines[:20] if line.startswith(WRITTEN)]
    if len(found) != 1:
        return None
    try:
        network = parse(found[0])
        again = spice(network, title=lines[0].removeprefix("* "))
    except BadDevice:
        return None
    return network if _circuit(again) == _circuit(text) else None


def _circuit(deck: str) -> list[str]:
    return deck.partition(END_OF_CIRCUIT)[0].split("\n")


def _read(text: str) -> Network:
    branches: list[Branch] = []
    ports: list[tuple[str, str]] = []
    for number, line in _statements(text):
        words = line.split()
        kind = words[0][0].upper()
        where = f"line {number} of the deck, {shown(line, 40)}"
        if kind in "VI" and len(words) >= 3:
            ports.append((_node(words[1]), _node(words[2])))
            continue
        if kind not in _KINDS:
            raise BadDevice(f"{where}, is no resistor R, inductor L or capacitor C; a network is read of these.")
        if len(words) < 4:
            raise BadDevice(f"{where}, is no element; write a name, two nodes and a value, such as 'R1 1 2 50'.")
        value = _value(words[3], where)
        name = f"{'ckb'['RLC'.index(kind)]}{len(branches) + 1}"
        element = _KINDS[kind](value if kind == "C" else 1 / value, name)
        branches.append((_node(words[1]), _node(words[2]), element))
        if len(branches) > MOST:
            raise BadDevice(f"This deck has more than {MOST} elements; that is as many as are read.")
    if not branches:
        raise BadDevice("This deck has no resistor, inductor or capacitor.")
    if len(ports) > 1:
        raise BadDevice(f"This deck has {len(ports)} sources; a one-port has one, which says where its terminals are.")
    return _network(branches, ports[0] if ports else ("1", "0"))


def _network(branches: list[Branch], port: tuple[str, str]) -> Network:
    """Between the terminals, series and parallel joints put together; a graph where something else is left."""
    for end in port:
        if not any(end in branch[:2] for branch in branches):
            raise BadDevice(f"The terminal {shown(end)} of this deck has no element; its port is {' and '.join(port)}.")
    graph = Graph(tuple(branches), terminals=port)  # type: ignore[arg-type]
    kept = put_together(list(graph.branches))
    return kept[0][2] if len(kept) == 1 else Graph(tuple(kept))


def _statements(text: str) -> list[tuple[int, str]]:
    """Number and text of the lines that say something; the first is the title, as in SPICE."""
    found: list[tuple[int, str]] = []
    inside = False
    for number, line in enumerate(text.splitlines(), 1):
        said = re.split(r"[;$]", line, maxsplit=1)[0].strip()
        if said.lower().startswith((".control", ".endc")):
            inside = said.lower().startswith(".control")
        if number == 1 or inside or not said or said[0] in "*.":
            if said.lower().rstrip() == ".end":
                break
            continue
        if said.startswith("+") and found:
            found[-1] = (found[-1][0], f"{found[-1][1]} {said[1:]}")
            continue
        found.append((number, said))
    return found


def _node(text: str) -> str:
    return "0" if text.lower() == "gnd" else text.lower()


def _value(text: str, where: str) -> Fraction:
    match = _VALUE.fullmatch(text)
    if match is None:
        raise BadDevice(f"{where}: {shown(text)} is not a value such as 50, 4.7k or 10u.")
    value = exact.to_fraction(exact.to_fmpq(match[1])) * _SUFFIX.get((match[2] or "").lower(), Fraction(1))
    if value <= 0:
        raise BadDevice(f"{where}: the value is {plain(text, 30)}; a passive element has one above 0.")
    return value
