"""A network as a file: picture, SPICE deck, LaTeX, text diagram or notation, by the file's ending."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from posreal.files import require_writable, write_whole
from posreal.network import Network
from posreal.network.diagram import diagram
from posreal.network.latex import latex
from posreal.network.picture import picture
from posreal.network.spice import spice

Terminals = tuple[str, str]
_TERMINALS = ("body", "bogie")
_DRAWN: dict[str, Callable[[Network, Terminals], bytes]] = {
    ".png": lambda network, ends: picture(network, ends, format="png"),
    ".svg": lambda network, ends: picture(network, ends, format="svg"),
    ".tex": lambda network, ends: latex(network, ends, document=True).encode(),
    ".txt": lambda network, ends: (diagram(network, ends) + "\n").encode(),
}
_READ_AGAIN: dict[str, Callable[[Network], bytes]] = {
    ".cir": lambda network: spice(network).encode(),
    ".net": lambda network: f"{network}\n".encode(),
}


def checked(path: str | Path) -> Path:
    """The path, once it is known that its ending is one we write and that its folder takes files.

    Raises
    ------
    BadInput
    """
    return require_writable(path, (*_DRAWN, *_READ_AGAIN))


def export(
    network: Network, path: str | Path, *, strut: Network | None = None, terminals: Terminals = _TERMINALS
) -> None:
    """Write a network to a file, whole or not at all.

    Parameters
    ----------
    network : Network
    path : path
        Ending in .png or .svg (picture), .tex (LaTeX with circuitikz), .txt (text diagram), .cir (SPICE deck) or
        .net (one-line notation); the last two posreal reads again as a device.
    strut : Network, optional
        What is drawn instead: the network with the vehicle's spring beside or behind it.
    terminals : (str, str)
        What it stands between.

    Raises
    ------
    BadInput
        For another ending, or if the file cannot be written.
    """
    path = checked(path)
    ending = path.suffix.lower()
    content = _DRAWN[ending](strut or network, terminals) if ending in _DRAWN else _READ_AGAIN[ending](network)
    write_whole(path, content)
