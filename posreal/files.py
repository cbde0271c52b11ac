"""Files written whole or not at all, and refused before any work where they cannot be written."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable
from pathlib import Path

from posreal.errors import BadInput, listed


def require_writable(path: str | Path, endings: Iterable[str]) -> Path:
    """The path, once it is known that its ending says one of the forms there are and that its folder takes files.

    Raises
    ------
    BadInput
    """
    path = Path(path)
    if path.suffix.lower() not in endings:
        raise BadInput(f"cannot write {path}: its ending says the form, and accepted are {listed(endings)}")
    if path.is_dir():
        raise BadInput(f"cannot write {path}: it is a folder; give a file")
    require_folder(path.parent)
    return path


def require_folder(folder: Path) -> None:
    """Refuse a folder in which no file can be made.

    Raises
    ------
    BadInput
    """
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise BadInput(f"cannot write into the folder {folder}: {error.strerror or error}") from None


def write_whole(path: str | Path, content: bytes) -> Path:
    """Write a file such that no half of it is ever seen: beside it first, then in its place.

    Raises
    ------
    BadInput
        If it cannot be written.
    """
    path = Path(path)
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_bytes(content)
        os.replace(part, path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise BadInput(f"cannot write {path}: {error.strerror or error}") from None
    return path
