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

_WRITERS: dict[str, Callable[[Network], bytes]] = {
    ".png": lambda network: picture(network, format="png"),
    ".svg": lambda network: picture(network, format="svg"),
    ".cir": lambda network: spice(network).encode(),
    ".tex": lambda network: latex(network, document=True).encode(),
    ".txt": lambda network: (diagram(network) + "\n").encode(),
    ".net": lambda network: f"{network}\n".encode(),
}


def checked(path: str | Path) -> Path:
    """The path, once it is known that its ending is one we write and that its folder takes files.

    Raises
    ------
    BadInput
    """
    return require_writable(path, _WRITERS)


def export(network: Network, path: str | Path) -> None:
    """Write a network to a file, whole or not at all.

    Parameters
    ----------
    network : Network
    path : path
        Ending in .png or .svg (picture), .cir (SPICE deck), .tex (LaTeX with circuitikz), .txt (text diagram) or
        .net (one-line notation, which posreal reads again).

    Raises
    ------
    BadInput
        For another ending, or if the file cannot be written.
    """
    path = checked(path)
    write_whole(path, _WRITERS[path.suffix.lower()](network))
