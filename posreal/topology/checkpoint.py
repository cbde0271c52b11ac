"""What has been found so far, on disk: one JSON document a line, each with a checksum of itself.

The first line says which search it belongs to, the others are finished topologies in the order in which they came in.
Lines are only ever added, and are on disk before the next work is handed out, so a search that was killed loses at most
what was being worked on. A line that a dying process or disk left unfinished at the end is cut off; anything else that
does not read as it was written is refused, because results behind it would be trusted without reason.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import stat
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from posreal.errors import BadInput, plain, shown

_KIND = "posreal search"
_LARGEST = 1_000_000_000  # bytes: a search of the largest size writes a hundredth of it


class Checkpoint:
    """An open checkpoint file; `records` are the results it held when it was opened.

    Parameters
    ----------
    path : path
        Made if it does not exist.
    header : mapping
        What decides the results (problem, seed, settings); the file's must be the same.

    Attributes
    ----------
    records : list of dict
    trimmed : bool
        Whether an unfinished last line was cut off.

    Raises
    ------
    BadInput
        If the file cannot be used, is no checkpoint, belongs to another search, is damaged, or is in use.
    """

    def __init__(self, path: str | os.PathLike[str], header: Mapping[str, Any]) -> None:
        self.path = Path(path)
        self.records: list[dict[str, Any]] = []
        self.trimmed = False
        header = {"kind": _KIND, **header}
        flags = os.O_RDWR | os.O_APPEND | os.O_CREAT | getattr(os, "O_NONBLOCK", 0)  # a pipe would hold it up
        try:
            # unbuffered: what a full disk did not take is not tried again when the file is closed
            self._file = open(os.open(self.path, flags, 0o666), "a+b", buffering=0)  # noqa: SIM115
        except (OSError, ValueError) as error:
            raise self._unwritten(error) from None
        try:
            there = os.fstat(self._file.fileno())
            if not stat.S_ISREG(there.st_mode):
                raise BadInput(f"cannot write the checkpoint {plain(self.path)}: it is not a regular file")
            self._lock()
            self._file.seek(0)
            if there.st_size > _LARGEST:
                raise BadInput(
                    f"the checkpoint {plain(self.path)} is larger than {_LARGEST} bytes, more than any needs"
                )
            self._read(self._file.read(), header)
        except BaseException:
            self._file.close()
            raise

    def add(self, records: Iterable[Mapping[str, Any]]) -> None:
        """Append results and see them onto the disk."""
        left = b"".join(_line(record) for record in records)
        try:
            while left:
                left = left[self._file.write(left) :]
            os.fsync(self._file.fileno())
        except OSError as error:  # a full disk
            raise self._unwritten(error) from None

    def _unwritten(self, error: Exception) -> BadInput:
        return BadInput(f"cannot write the checkpoint {plain(self.path)}: {getattr(error, 'strerror', None) or error}")

    def close(self) -> None:
        """Close the file; it stays."""
        self._file.close()

    def __enter__(self) -> Checkpoint:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _lock(self) -> None:
        """Two searches writing to one file would interleave; the lock goes with the process."""
        try:
            import fcntl
        except ImportError:  # not a POSIX system: there the user keeps searches apart
            return
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise BadInput(
                f"the checkpoint {plain(self.path)} is in use by another search; give each its own file"
            ) from None

    def _read(self, content: bytes, header: Mapping[str, Any]) -> None:
        lines = content.split(b"\n")
        whole, rest = lines[:-1], lines[-1]
        if not whole:
            # nothing, or a header that was never finished
            if rest and not _line(header).startswith(rest):
                raise BadInput(f"{plain(self.path)} is not a checkpoint of a search; name a file that may be written")
            self._cut(0, bool(rest))
            self.add([header])
            return
        documents = [_document(line) for line in whole]
        if documents[0] is None or documents[0].get("kind") != _KIND:
            raise BadInput(f"{plain(self.path)} is not a checkpoint of a search; name a file that may be written")
        _same_search(self.path, documents[0], header)
        if documents[-1] is None:
            # the last line was ended but its middle never reached the disk
            rest = whole.pop() + b"\n" + rest
            documents.pop()
        for number, document in enumerate(documents, 1):
            if document is None:
                raise BadInput(
                    f"line {number} of the checkpoint {plain(self.path)} is damaged; keep what is before it with "
                    f"`head -n {number - 1}`, or delete the file and search again"
                )
        self._cut(sum(len(line) + 1 for line in whole), bool(rest))
        self.records = [document for document in documents[1:] if document is not None]

    def _cut(self, length: int, needed: bool) -> None:
        if needed:
            self._file.truncate(length)
            self.trimmed = True


def fingerprint(document: Any) -> str:
    """A short text that changes with anything in a JSON-able document."""
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()[:16]


def number(value: float) -> float | None:
    """A float as JSON has it: infinity is null."""
    return value if math.isfinite(value) else None


def _line(document: Mapping[str, Any]) -> bytes:
    return json.dumps({**document, "checksum": fingerprint(dict(document))}).encode() + b"\n"


def _document(line: bytes) -> dict[str, Any] | None:
    """A line's document without its checksum; None if the two do not belong together."""
    try:
        document = json.loads(line)
    except (ValueError, RecursionError):
        return None
    if not isinstance(document, dict):
        return None
    checksum = document.pop("checksum", None)
    return document if checksum == fingerprint(document) else None


def _same_search(path: Path, theirs: Mapping[str, Any], ours: Mapping[str, Any]) -> None:
    for name, value in ours.items():
        if theirs.get(name) != value:
            raise BadInput(
                f"the checkpoint {plain(path)} belongs to another search (its {name} is {shown(theirs.get(name))}, "
                f"here it is {shown(value)}); give this search its own file"
            )
