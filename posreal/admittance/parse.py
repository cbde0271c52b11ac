"""Ordinary algebra in s, read and never evaluated: ``(s^2 + s + 1)/(s^2 + s + 4)``, ``2.5e5/s + 2e4``.

    device  :=  [ ("Y" | "Z") [ "(s)" ] "=" ] ( sum | "tf(" list "," list ")" )
    sum     :=  product  { ("+" | "-") product }
    product :=  signed   { ("*" | "/") signed  |  power that begins with a name or "(" }
    signed  :=  ("+" | "-") signed  |  power
    power   :=  atom [ ("^" | "**") signed integer ]
    atom    :=  number | name | "(" sum ")"

The one name is ``s``, besides those of parameters that a caller may know the values of.

``2s``, ``4 s`` and ``(s+1)(s+3)`` are products. ``1/2s`` is refused: to some it is 1/(2s), to others s/2. An admittance
is F/v; ``Z = …`` is the impedance v/F, whose inverse is meant [Smith2002].

``tf([1 0], [1 2 3])`` is s/(s² + 2 s + 3), as MATLAB and python-control write it, in descending powers.

Decimals are exact, and length, nesting, degree and coefficient sizes are limited, so no text can make the reader slow.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from posreal.admittance import exact
from posreal.errors import BadDevice, hint, shown

if TYPE_CHECKING:
    from posreal.admittance.rational import Rational

LONGEST_TEXT = 50_000  # characters
MOST_TOKENS = 4_000
DEEPEST_NESTING = 100
HIGHEST_DEGREE = 40
LARGEST_COEFFICIENT = 20_000  # bits of a coefficient's numerator or denominator
MOST_WORK = 150_000_000  # sum over operations of (degree + 1)² times bits: a few seconds

HEAD = re.compile(r"\s*([YZ])\s*(?:\(\s*s\s*\)\s*)?=")
"""What may stand before a function: the admittance Y or the impedance Z that it is."""

RIGID = "An impedance Z = 0 is a rigid link, which no admittance describes; give one that is not."
_LISTS = re.compile(
    r"\s*(?:(?P<head>[YZ])\s*(?:\(\s*s\s*\)\s*)?=\s*)?tf\s*\(\s*\[(?P<top>[-+\d.eE,\s]*)\]\s*,"
    r"\s*\[(?P<bottom>[-+\d.eE,\s]*)\]\s*\)\s*",
    re.ASCII,
)

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<mark>\*\*|[-+*/^()])|(?P<name>[A-Za-z_]\w*))",
    re.ASCII,  # other scripts have digits too
)


@dataclass(frozen=True)
class _Token:
    kind: str  # "number", "mark", "name" or "end"
    text: str
    position: int


def read(text: str, kind: type[Rational], names: Mapping[str, Rational] | None = None) -> Rational:
    """The function that a text says, worked out in `kind`; see `Rational.parse`.

    Parameters
    ----------
    text : str
    kind : type
    names : mapping of name to Rational, optional
        What stands in the text besides s; a name ``s`` among them takes its place.
    """
    if len(text) > LONGEST_TEXT:
        raise BadDevice(f"This device text has {len(text)} characters; at most {LONGEST_TEXT} are read.")
    listed = _LISTS.fullmatch(text)
    if listed is not None and not names:
        return _of_lists(listed, kind)
    return _Reader(text, kind, names or {}).read()


def _of_lists(match: re.Match[str], kind: type[Rational]) -> Rational:
    """A function from its coefficients in descending powers."""
    lists = [re.split(r"\s*,\s*|\s+", match[name].strip()) for name in ("top", "bottom")]
    if any(len(one) > HIGHEST_DEGREE + 1 for one in lists):
        raise BadDevice(f"degrees above {HIGHEST_DEGREE} are not read")
    value = kind(*([exact.to_fmpq(text) for text in reversed(one)] for one in lists))
    if match["head"] != "Z":
        return value
    if value.is_zero():
        raise BadDevice(RIGID)
    return value.inverse()


def _tokens(text: str, position: int = 0) -> list[_Token]:
    found = []
    while text[position:].strip():
        match = _TOKEN.match(text, position)
        if match is None:
            at = position + len(text[position:]) - len(text[position:].lstrip())
            raise _error(text, at, f"{shown(text[at])} is not part of a function of s")
        kind = str(match.lastgroup)
        found.append(_Token(kind, match[kind], match.start(kind)))
        position = match.end()
        if len(found) > MOST_TOKENS:
            raise BadDevice(f"This device text has more than {MOST_TOKENS} symbols; give coefficients instead.")
    return [*found, _Token("end", "the end", len(text))]


def _error(text: str, position: int, complaint: str) -> BadDevice:
    start = max(0, position - 12)
    near = ("…" if start else "") + text[start : position + 12] + ("…" if position + 12 < len(text) else "")
    return BadDevice(
        f"{complaint} (character {position + 1}, near {shown(near)}); write for example '2.5e5/s + 2e4*s'."
    )


class _Reader:
    def __init__(self, text: str, kind: type[Rational], names: Mapping[str, Rational]) -> None:
        self.text, self.kind = text, kind
        self.names = {"s": kind([0, 1]), **names}
        self.head = HEAD.match(text)
        self.tokens = _tokens(text, 0 if self.head is None else self.head.end())
        self.next = 0
        self.depth = 0
        self.work = 0

    def read(self) -> Rational:
        if self.tokens[0].kind == "end":
            raise BadDevice("The device text is empty; write for example '2.5e5/s + 2e4'.")
        value = self.sum()
        if self.here.kind != "end":
            raise self.error(f"expected an operator before {shown(self.here.text)}")
        if self.head is None or self.head[1] == "Y":
            return value
        if value.is_zero():
            raise BadDevice(RIGID)
        return value.inverse()

    @property
    def here(self) -> _Token:
        return self.tokens[self.next]

    def error(self, complaint: str) -> BadDevice:
        return _error(self.text, self.here.position, complaint)

    def accept(self, *marks: str) -> str | None:
        if self.here.kind == "mark" and self.here.text in marks:
            self.next += 1
            return self.tokens[self.next - 1].text
        return None

    def sum(self) -> Rational:
        value = self.product()
        while mark := self.accept("+", "-"):
            other = self.product()
            value = self.limited(value | other if mark == "+" else value.without(other))
        return value

    def product(self) -> Rational:
        value, divided = self.signed(), False
        while mark := self.accept("*", "/") or self.implied():
            position = self.here
            if mark == "implied" and divided:
                raise self.error("write '*' or brackets after a division: 1/2s is s/2 to some and 1/(2*s) to others")
            divided = mark == "/" or (divided and mark == "implied")
            other = self.power() if mark == "implied" else self.signed()
            if mark == "/" and other.is_zero():
                raise _error(self.text, position.position, "division by zero")
            value = self.limited(value.times(other.inverse() if mark == "/" else other))
        return value

    def implied(self) -> str | None:
        """Whether a factor follows without a mark: ``2s``, ``(s+1)(s+3)``."""
        follows = self.here.text == "(" or (self.here.kind == "name" and self.here.text in self.names)
        return "implied" if follows else None

    def signed(self) -> Rational:
        self.depth += 1
        if self.depth > DEEPEST_NESTING:
            raise self.error(f"nested more than {DEEPEST_NESTING} deep")
        if mark := self.accept("+", "-"):
            value = self.signed()
            value = value if mark == "+" else value.scaled(-1)
        else:
            value = self.power()
        self.depth -= 1
        return value

    def power(self) -> Rational:
        value = self.atom()
        if not self.accept("^", "**"):
            return value
        negative = self.accept("-") is not None
        token = self.here
        if token.kind != "number" or not token.text.isdigit() or len(token.text) > 4:
            raise self.error("expected a whole number as exponent")
        self.next += 1
        exponent = int(token.text)
        if exponent * max(value.degree, 1) > HIGHEST_DEGREE:
            raise _error(self.text, token.position, f"powers and degrees above {HIGHEST_DEGREE} are not read")
        if negative and value.is_zero():
            raise _error(self.text, token.position, "division by zero")
        if self.accept("^", "**"):
            raise self.error("write parentheses around a power of a power")
        value = value.inverse() if negative else value
        return self.limited(self.kind(value.n**exponent, value.d**exponent))

    def atom(self) -> Rational:
        token = self.here
        if token.kind == "number":
            self.next += 1
            return self.kind([exact.to_fmpq(token.text)])
        if token.kind == "name" and token.text in self.names:
            self.next += 1
            return self.names[token.text]
        if token.kind == "name":
            known = "the only variable is s" if len(self.names) == 1 else hint(token.text, self.names)
            raise self.error(f"{shown(token.text)} is not known; {known}")
        if self.accept("("):
            value = self.sum()
            if not self.accept(")"):
                raise self.error("expected ')'")
            return value
        raise self.error(f"expected a number, s or '(' but found {shown(token.text)}")

    def limited(self, value: Rational) -> Rational:
        if value.degree > HIGHEST_DEGREE:
            raise self.error(f"degrees above {HIGHEST_DEGREE} are not read")
        bits = max((c.height_bits() for p in (value.n, value.d) for c in p.coeffs()), default=0)
        if bits > LARGEST_COEFFICIENT:
            raise self.error("coefficients grew too large to read")
        self.work += (value.degree + 1) ** 2 * (bits + 100)
        if self.work > MOST_WORK:
            raise self.error("too much to work out from here on; give coefficients instead")
        return value
