"""The matrices of a state space from a file: .mat of MATLAB, .npz of numpy, .json; nothing in it is ever run.

A .mat or .json may have them in a struct: ``sys.A`` is the field A of the variable sys. MATLAB keeps its ``ss`` objects
in a form of its own; ``[A, B, C, D] = ssdata(sys)`` and ``save -v7`` write what is read here.
"""

from __future__ import annotations

import io
import math
import struct
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from posreal.errors import BadInput, hint, plain, shown
from posreal.files import json_document, read_bytes

_COMPRESSED = 15  # kind of an element
LARGEST = 20_000_000  # bytes of a file, and numbers in it: 200 states take a hundred thousandth of that
ENDINGS = (".mat", ".npz", ".json")


class MatricesFile:
    """The variables of one file.

    Parameters
    ----------
    path : Path
        Ending in .mat (level 4 to 7), .npz or .json.

    Raises
    ------
    BadInput
        If it cannot be read, or is larger than such a file needs to be.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        ending = path.suffix.lower()
        if ending not in ENDINGS:
            raise BadInput(f"{plain(path)} ends in none of {', '.join(ENDINGS)}, which say what a file of matrices is")
        content = read_bytes(path, LARGEST)
        read = {".mat": _matlab, ".npz": _numpy, ".json": _json}[ending]
        self.variables: Mapping[str, Any] = read(content, path)

    def get(self, name: str) -> Any:
        """A variable, or a field of a struct by its dotted name.

        Raises
        ------
        BadInput
            Naming what the file has.
        """
        found: Any = self.variables
        for part in name.split("."):
            if isinstance(found, np.ndarray) and found.dtype.names and found.size == 1:  # a struct of MATLAB's
                record = found.reshape(-1)[0]
                found = {key: record[key] for key in found.dtype.names}
            if not isinstance(found, Mapping) or part not in found:
                known = [key for key in found if not key.startswith("__")] if isinstance(found, Mapping) else []
                has = hint(part, known) if known else "it is no struct"
                raise BadInput(f"{plain(self.path)} has no variable {shown(name)}; {has}")
            found = found[part]
        return found

    def matrix(self, name: str, *, column: bool = False) -> np.ndarray:
        """A real matrix; a list of numbers is one row, or one column."""
        given = self.get(name)
        try:
            found = np.asarray(given.toarray() if hasattr(given, "toarray") else given)
            if found.dtype.kind not in "biuf" or found.ndim > 2 or found.size > LARGEST:
                raise ValueError
        except (ValueError, TypeError):
            raise BadInput(f"{plain(self.path)}: {plain(name, 40)} is not a matrix of real numbers") from None
        return np.asarray(found.reshape(-1, 1) if column and found.ndim < 2 else np.atleast_2d(found), dtype=float)

    def names(self, name: str) -> list[str]:
        """A list of texts: a cell array, a string array."""
        items = _texts(self.get(name))
        if not items or not all(isinstance(item, str) and item.strip() for item in items):
            raise BadInput(f"{plain(self.path)}: {plain(name, 40)} is not a list of names")
        return [item.strip() for item in items]

    def __contains__(self, name: str) -> bool:
        return name in self.variables


def _texts(given: Any) -> list[Any]:
    """The texts of a list, an array, or a cell array of such."""
    if isinstance(given, np.ndarray):
        given = given.ravel().tolist()
    if not isinstance(given, list):
        return [given]
    return [text for item in given for text in (_texts(item) if isinstance(item, np.ndarray) else [item])]


def _matlab(content: bytes, path: Path) -> Mapping[str, Any]:
    from scipy.io import loadmat, whosmat

    if content[:8] == b"\x89HDF\r\n\x1a\n" or b"MATLAB 7.3 MAT-file" in content[:128]:
        raise BadInput(f"{plain(path)} is a MAT-file of version 7.3; save it with '-v7'")
    try:
        sizes = [math.prod(shape) for _, shape, _ in whosmat(io.BytesIO(content))]
        if sum(sizes) > LARGEST or _expanded(content) > 8 * LARGEST:
            raise BadInput(f"{plain(path)} holds more than {LARGEST} numbers, more than such a file needs")
        found: Mapping[str, Any] = loadmat(io.BytesIO(content))
    except BadInput:
        raise
    except Exception as error:  # of scipy's reader: it has no class of its own, and reads what it is given
        raise BadInput(f"{plain(path)} is not a MAT-file that can be read: {plain(error, 100)}") from None
    return found


def _expanded(content: bytes) -> int:
    """Bytes of the compressed elements of a MAT-file of level 5, as far as they are no more than is read."""
    order, at, total = "<" if content[126:128] == b"IM" else ">", 128, 0
    while at + 8 <= len(content) and total <= 8 * LARGEST:
        kind, size = struct.unpack(f"{order}II", content[at : at + 8])
        if kind == _COMPRESSED:
            total += len(zlib.decompressobj().decompress(content[at + 8 : at + 8 + size], 8 * LARGEST + 1 - total))
        at += 8 + size
    return total


def _numpy(content: bytes, path: Path) -> Mapping[str, Any]:
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            if sum(entry.file_size for entry in archive.infolist()) > 8 * LARGEST:
                raise BadInput(f"{plain(path)} holds more than {LARGEST} numbers, more than such a file needs")
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except BadInput:
        raise
    except Exception as error:  # zipfile, zlib and numpy each have their own
        raise BadInput(f"{plain(path)} is not an .npz file that can be read: {plain(error, 100)}") from None


def _json(content: bytes, path: Path) -> Mapping[str, Any]:
    try:
        document = json_document(content.decode("utf-8-sig"), path)
    except UnicodeDecodeError:
        raise BadInput(f"{plain(path)} is not a text file in UTF-8") from None
    if not isinstance(document, dict):
        raise BadInput(f'{plain(path)} is not a table of matrices, such as {{"A": [[0, 1], [-4, -0.1]], …}}')
    return document
