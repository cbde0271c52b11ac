"""Files: read with a limit and only where they are files, written whole or not at all.

A path that a user gives may lead to a pipe, a device or a file without end, and a document in it may be nested or
dotted so deeply that its reader takes minutes; all of that is refused in a sentence before it costs anything. What is
written appears beside its place first, under a name that nobody can have taken, and then moves there.
"""

from __future__ import annotations

import json
import os
import re
import secrets
import stat
import tempfile
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from posreal.errors import BadInput, listed, plain

PAGE = 1_000_000  # bytes: of text that a person writes, a device, a layout, a vehicle
_DOTTED = re.compile(r"""(?<![\w-])(?:(?:"[^"\n]*"|'[^'\n]*'|[\w-]+)[ \t]*\.[ \t]*){32}""")


def read_bytes(path: str | Path, largest: int = PAGE) -> bytes:
    """The content of a regular file of at most so many bytes.

    Raises
    ------
    BadInput
        If it cannot be read, is larger, or is a folder, a pipe or a device, which may have no end.
    """
    where = plain(path)
    try:
        # a pipe that nobody writes to would otherwise hold the opening up
        with open(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)), "rb") as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise BadInput(f"cannot read {where}: it is not a regular file")
            content = file.read(largest + 1) or b""  # None where a file of the system has nothing to say just now
    except (OSError, ValueError) as error:  # ValueError: a name with a null character
        raise BadInput(f"cannot read {where}: {getattr(error, 'strerror', None) or error}") from None
    if len(content) > largest:
        raise BadInput(f"{where} is larger than {largest} bytes, more than such a file needs")
    return content


def read_text(path: str | Path, largest: int = PAGE) -> str:
    """The text of a regular file in UTF-8; see `read_bytes`."""
    try:
        return read_bytes(path, largest).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise BadInput(f"{plain(path)} is not a text file in UTF-8") from None


def read_json(path: str | Path, largest: int = PAGE) -> Any:
    """The document of a JSON file; see `read_bytes`."""
    return json_document(read_text(path, largest), path)


def json_document(text: str, path: str | Path) -> Any:
    """What a JSON text says; `path` is named where it is none.

    Raises
    ------
    BadInput
    """
    try:
        return json.loads(text, parse_float=_finite, parse_constant=_finite)
    except BadInput as error:
        raise BadInput(f"{plain(path)}: {error}") from None
    except RecursionError:
        raise BadInput(f"{plain(path)} is not valid JSON here: it is nested too deeply") from None
    except ValueError as error:
        raise BadInput(f"{plain(path)} is not valid JSON: {_reason(error)}") from None


def read_toml(path: str | Path) -> dict[str, Any]:
    """The tables of a TOML file; see `read_bytes`.

    Raises
    ------
    BadInput
        If it cannot be read or is not TOML, with the line that is at fault.
    """
    return toml_document(read_text(path), path)


def toml_document(text: str, path: str | Path) -> dict[str, Any]:
    """What a TOML text says; `path` is named where it is none.

    Raises
    ------
    BadInput
    """
    if _DOTTED.search(text):  # each part of a key is looked up from the top again
        raise BadInput(f"{plain(path)} is not valid TOML here: it has a key of more than 32 parts")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise BadInput(f"{plain(path)} is not valid TOML here: it is nested too deeply") from None
    except ValueError as error:
        raise BadInput(f"{plain(path)} is not valid TOML: {_reason(error)}") from None


def _finite(text: str) -> float:
    value = float(text)
    if not abs(value) < float("inf"):
        raise BadInput(f"{plain(text, 40)} is not a finite number that a float holds")
    return value


def _reason(error: ValueError) -> str:
    text = str(error)
    return "a whole number has too many digits" if "int_max_str_digits" in text else plain(text)


def require_writable(path: str | Path, endings: Iterable[str] | None = None) -> Path:
    """The path, once it is known that its ending says one of the forms there are and that its folder takes files.

    Raises
    ------
    BadInput
    """
    path = Path(path)
    if endings is not None and path.suffix.lower() not in endings:
        raise BadInput(f"cannot write {plain(path)}: its ending says the form, and accepted are {listed(endings)}")
    _replaceable(path)
    require_folder(Path(os.path.realpath(path)).parent)
    return path


def _replaceable(path: Path) -> None:
    """Refuse a name that is too long, or is a folder, a pipe or a device already."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return
    except (OSError, ValueError) as error:
        raise _unwritten(path, error) from None
    if stat.S_ISDIR(mode):
        raise BadInput(f"cannot write {plain(path)}: it is a folder; give a file")
    if not stat.S_ISREG(mode):
        raise BadInput(f"cannot write {plain(path)}: it is not a regular file")


def _unwritten(path: Path, error: Exception) -> BadInput:
    return BadInput(f"cannot write {plain(path)}: {getattr(error, 'strerror', None) or error}")


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
        raise BadInput(f"cannot write into the folder {plain(folder)}: {error.strerror or error}") from None


def write_whole(path: str | Path, content: bytes) -> Path:
    """Write a file such that no half of it is ever seen: beside it first, then in its place.

    A symbolic link stays, and what it leads to is replaced. The file beside it is always a new one: nothing is written
    through a link that somebody else has put there.

    Raises
    ------
    BadInput
        If it cannot be written; what was there stays as it was.
    """
    path = Path(path)
    _replaceable(path)
    target = Path(os.path.realpath(path))
    part = target.with_name(f".{secrets.token_hex(8)}.part")
    try:
        new = os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0), 0o666)
        try:
            with open(new, "wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            os.replace(part, target)
        except BaseException:
            part.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise _unwritten(path, error) from None
    return path
