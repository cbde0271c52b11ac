"""Where in a TOML text a key stands: errors name the line."""

from __future__ import annotations

import re
from typing import Any

_PART = r"""(?:[\w-]+|"[^"]*"|'[^']*')"""
_DOTTED = rf"{_PART}(?:\s*\.\s*{_PART})*"
_HEADER = re.compile(rf"\s*\[\[?\s*({_DOTTED})\s*\]\]?\s*(?:#.*)?")
_KEY = re.compile(rf"\s*({_DOTTED})\s*=")


def line_of(text: str, path: tuple[Any, ...]) -> int | None:
    """Number of the line on which the longest part of a path of keys is given; None where no part of it is.

    Examples
    --------
    >>> line_of("[inputs]\\nroad = { density = 1 }\\n", ("inputs", "road", "density"))
    2
    """
    wanted = tuple(str(part) for part in path)
    table: tuple[str, ...] = ()
    best, found = 0, None
    for number, line in enumerate(text.splitlines(), 1):
        header = _HEADER.fullmatch(line)
        if header is not None:
            table = _parts(header[1])
            here = table
        else:
            key = _KEY.match(line)
            if key is None:
                continue
            here = table + _parts(key[1])
        if len(here) > best and here == wanted[: len(here)]:
            best, found = len(here), number
    return found


def _parts(dotted: str) -> tuple[str, ...]:
    return tuple(part.strip().strip("\"'") for part in dotted.split("."))
