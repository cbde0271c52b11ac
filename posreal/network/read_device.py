"""A device as people write it: a network, an admittance in s, or a file with one of them, with JSON or a deck."""

from __future__ import annotations

import os
import re
import stat
from pathlib import Path
from typing import Any

from posreal.admittance import Rational, as_rational
from posreal.errors import BadDevice, BadInput, plain
from posreal.files import json_document, read_text
from posreal.network.notation import parse
from posreal.network.tree import Network

_DECKS = (".cir", ".sp", ".spice", ".ckt")
_ELEMENT = re.compile(r"\s*[({\s]*[kcb]\w*\s*(=|[|+)]|$)")


def read_device(text: str) -> Network | Rational | None:
    """A network, an admittance or a file with one of them; None for ``default``.

    Raises
    ------
    BadDevice, BadInput
    """
    text = text.strip()
    if text in ("default", "none"):
        return None
    if is_file(text):
        return _from_file(Path(text))
    return parse(text) if _ELEMENT.match(text) or text.startswith("{") else as_rational(text)


def is_file(text: str) -> bool:
    """Whether this names a file rather than a device."""
    if text.endswith((".json", ".txt", ".net", *_DECKS)):
        return "\n" not in text
    try:
        return stat.S_IFMT(os.stat(text).st_mode) != stat.S_IFDIR  # a pipe too, to be refused as what it is
    except (OSError, ValueError):  # most networks are no names that a file could have
        return False


def _from_file(path: Path) -> Network | Rational | None:
    text = read_text(path).strip()
    try:
        if str(path).endswith(_DECKS):
            from posreal.network.read_spice import read_spice

            return read_spice(text)
        if not text.startswith("{") or '"' not in text:
            if is_file(text):
                raise BadInput(f"{plain(path)} names another file; give a file that holds a device")
            return read_device(text)
        return _from_json(json_document(text, path))
    except BadDevice as error:
        raise BadDevice(f"{plain(path)}: {error}") from None


def _from_json(document: Any) -> Network | Rational:
    """A device from what posreal itself prints with ``--json``, or from a bare numerator and denominator."""
    for key in ("design", "device"):
        if isinstance(document, dict) and isinstance(document.get(key), dict):
            document = document[key]
    if isinstance(document, dict) and isinstance(document.get("network"), str):
        return parse(document["network"])
    if isinstance(document, dict) and isinstance(document.get("notation"), str):
        return parse(document["notation"])
    if isinstance(document, dict) and isinstance(document.get("rational"), dict):
        document = document["rational"]
    if isinstance(document, dict) and "numerator" in document:
        return Rational.from_dict(document)
    raise BadDevice("no device in this JSON; accepted is what --json prints, or numerator and denominator lists")
