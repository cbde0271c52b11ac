"""Errors that a user can cause, each carrying one sentence that names the culprit and the next step.

The command line prints ``str(error)`` and leaves with ``exit_code``: 2 where the input is at fault,
1 where the question was well put and the answer is no. Anything else that escapes is a bug.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class PosrealError(Exception):
    """Base of all errors that are the caller's to mend; ``str()`` is one sentence of advice."""

    exit_code = 2


class BadInput(PosrealError):
    """Something the user gave cannot be used: an unknown name, a value out of range, a file with a typo."""


class BadDevice(BadInput):
    """A device or network that cannot be read, or is not one (a negative spring, a missing value)."""


class NotPositiveReal(PosrealError):
    """The admittance is not positive real, so no springs, dampers and inerters make it.

    Attributes
    ----------
    witness : object
        What breaks it (a frequency with Re Y < 0, a right-half-plane pole, an axis residue), as the
        verdict of ``posreal.check`` holds it; its text is part of the message.
    """

    exit_code = 1

    def __init__(self, message: str, witness: object = None) -> None:
        super().__init__(message)
        self.witness = witness


class Infeasible(PosrealError):
    """No point that meets the constraints was found."""

    exit_code = 1


class Unsettled(Infeasible):
    """A figure that two independent methods, and longer arithmetic, do not agree on: it is not printed."""


class DoesNotApply(BadDevice):
    """This method does not serve this device; the text says why, and what does."""


class Unproven(PosrealError):
    """A synthesised network does not have the admittance it was made for: a fault of the method."""

    exit_code = 1


def plain(text: object, most: int = 120) -> str:
    """Input as it may stand in a message: on one line, control characters escaped, its middle left out if it is long.

    Examples
    --------
    >>> plain("a\\nb"), plain("0123456789", 6)
    ('a\\\\nb', '012…89')
    """
    try:
        whole = str(text)
    except (ValueError, RecursionError):  # an integer of more digits than Python writes; a list within lists
        return f"a very large {type(text).__name__}"
    if len(whole) > most:
        end = most // 3
        whole = f"{whole[: most - end - 1]}…{whole[len(whole) - end :]}"
    return "".join(c if c.isprintable() else c.encode("unicode_escape", "replace").decode() for c in whole)


def shown(given: object, most: int = 60) -> str:
    """A value of the user's as Python writes it, text in quotes; shortened as `plain` does."""
    if isinstance(given, str):
        text = plain(given, most)
        return f'"{text}"' if "'" in text and '"' not in text else f"'{text}'"
    try:
        return plain(repr(given), most)
    except (ValueError, RecursionError):
        return f"a very large {type(given).__name__}"


def listed(names: Iterable[object]) -> str:
    """``a, b or c``: what would have been accepted, for the end of a message."""
    words = [str(name) for name in names] or ["none"]
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " or " + words[-1]


def hint(word: str, names: Iterable[str]) -> str:
    """``did you mean a?`` where one of `names` is near, else what is accepted."""
    by_lower = {name.lower(): name for name in names}
    near = difflib.get_close_matches(word.lower(), by_lower, n=1, cutoff=0.7)
    return f"did you mean {by_lower[near[0]]}?" if near else f"accepted are {listed(by_lower.values())}"
