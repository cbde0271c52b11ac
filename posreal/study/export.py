"""A network as a file: picture, SPICE deck, LaTeX, text diagram or notation, by the file's ending."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from posreal.errors import BadInput, listed
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
    """The path, once it is known that its ending is one we write and that its folder is there.

    Raises
    ------
    BadInput
    """
    path = Path(path)
    if path.suffix.lower() not in _WRITERS:
        raise BadInput(f"cannot write {path}: its ending says the form, and there are {listed(_WRITERS)}")
    if not path.parent.is_dir():
        raise BadInput(f"cannot write {path}: there is no folder {path.parent}")
    if path.is_dir():
        raise BadInput(f"cannot write {path}: it is a folder")
    if not os.access(path.parent, os.W_OK):
        raise BadInput(f"cannot write {path}: the folder {path.parent} does not allow it")
    return path


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
    content = _WRITERS[path.suffix.lower()](network)
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_bytes(content)
        os.replace(part, path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise BadInput(f"cannot write {path}: {error.strerror or error}") from None
