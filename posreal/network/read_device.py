"""A device as people write it: a network, an admittance in s, or a file with one of them or with JSON of posreal's."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from posreal.admittance import Rational, as_rational
from posreal.errors import BadDevice, BadInput
from posreal.network.notation import parse
from posreal.network.tree import Network

_LARGEST = 1_000_000  # bytes of a device file
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
    return text.endswith((".json", ".txt", ".net")) or (len(text) < 4096 and "\n" not in text and Path(text).is_file())


def _from_file(path: Path) -> Network | Rational | None:
    try:
        if path.stat().st_size > _LARGEST:
            raise BadInput(f"{path} is larger than {_LARGEST} bytes; a device is a page of text")
        text = path.read_text(encoding="utf-8").strip()
    except OSError as error:
        raise BadInput(f"cannot read {path}: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise BadInput(f"{path} is not a text file in UTF-8") from None
    try:
        if not text.startswith("{") or '"' not in text:
            if is_file(text):
                raise BadInput(f"{path} names another file; give a file that holds a device")
            return read_device(text)
        return _from_json(json.loads(text))
    except json.JSONDecodeError as error:
        raise BadInput(f"{path} is not valid JSON: {error}") from None
    except BadDevice as error:
        raise BadDevice(f"{path}: {error}") from None


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
