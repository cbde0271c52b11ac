"""What a network becomes when one of its elements vanishes (value → 0) or locks (value → ∞).

A vanished element is no connection, a locked one a rigid link:

    | :  a child that vanishes is left out, one that locks locks the whole
    + :  a child that locks is left out, one that vanishes takes the whole with it
    # :  a branch that vanishes leaves four branches, one that locks joins two nodes: a tree either way

Like elements that now share a joint are one. The limit lies on the border of the larger network's values, so

    inf J(larger) ≤ inf J(limit):

a network whose optimum is no better than the best of its limits *is* that smaller network, and the optimum of a limit,
with the lost element just off its border, is a place from which the larger one can only improve.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from posreal.network.topologies import Form, bridge_turn, joined, key, letters

_OPEN, _RIGID = "open", "rigid"  # what is left of a part: no connection, or a rigid link

# A part whose elements remember where they came from: (letter, ((index, share), …)) or (sign, parts…).
Part = tuple[Any, ...]


@dataclass(frozen=True)
class Limit:
    """A limit and how its values sit in the larger network.

    Attributes
    ----------
    form : Form
        The smaller network.
    sources : tuple, one entry an element of `form`
        ``((i, share), …)``: with the element at v, element i of the larger network stands at share · v.
    lost : int
        The element that vanished or locked.
    locked : bool
        Whether it locked.
    """

    form: Form
    sources: tuple[tuple[tuple[int, float], ...], ...]
    lost: int
    locked: bool


@lru_cache(maxsize=1 << 14)
def limits(form: Form) -> tuple[Limit, ...]:
    """The limits of a form in which one element goes, one entry for each smaller form."""
    found: dict[Form, Limit] = {}
    for lost in range(len(letters(form))):
        for locked in (False, True):
            part = _without(_numbered(form), lost, _RIGID if locked else _OPEN)
            if not isinstance(part, str):
                smaller = _form(part)
                found.setdefault(smaller, Limit(smaller, tuple(_sources(part)), lost, locked))
    return tuple(found.values())


def _numbered(form: Form) -> Part:
    counter = iter(range(len(letters(form))))

    def number(inner: Form) -> Part:
        if isinstance(inner, str):
            return (inner, ((next(counter), 1.0),))
        return (inner[0], *(number(child) for child in inner[1:]))

    return number(form)


def _is_element(part: Part) -> bool:
    return part[0] not in "+|#"


def _form(part: Part) -> Form:
    if _is_element(part):
        return str(part[0])
    children = [_form(child) for child in part[1:]]
    return ("#", *children) if part[0] == "#" else joined(part[0], children)


def _sources(part: Part) -> list[tuple[tuple[int, float], ...]]:
    if _is_element(part):
        return [part[1]]
    return [source for child in part[1:] for source in _sources(child)]


def _without(part: Part, lost: int, state: str) -> Part | str:
    """The part with element `lost` vanished or locked: a part, or what is left of it."""
    if _is_element(part):
        return state if any(index == lost for index, _ in part[1]) else part
    children = [_without(child, lost, state) for child in part[1:]]
    if part[0] == "#":
        return _crossed(children)
    return _joined(part[0], children)


def _joined(sign: str, children: list[Part | str]) -> Part | str:
    """As :func:`topologies.joined`, for parts: flattened, merged with shares, in the order of their keys."""
    ends, left_out = (_OPEN, _RIGID) if sign == "+" else (_RIGID, _OPEN)
    if ends in children:
        return ends
    flat: list[Part] = []
    for child in children:
        if not isinstance(child, str):
            flat.extend(child[1:] if child[0] == sign else (child,))
    if not flat:
        return left_out
    share = 2.0 if sign == "+" else 0.5  # two like elements as one: each twice as stiff end to end, half side by side
    merged: list[Part] = []
    for child in flat:
        twin = next((i for i, other in enumerate(merged) if _is_element(child) and other[0] == child[0]), None)
        if twin is None:
            merged.append(child)
        else:
            pairs = tuple((i, w * share) for i, w in (*merged[twin][1], *child[1]))
            merged[twin] = (child[0], pairs)
    if len(merged) == 1:
        return merged[0]
    return (sign, *sorted(merged, key=lambda child: key(_form(child))))


def _crossed(branches: list[Part | str]) -> Part | str:
    """A bridge, one branch of which may have vanished or locked: then a tree of the other four."""
    gone = next((i for i, branch in enumerate(branches) if isinstance(branch, str)), None)
    if gone is None:
        turn = bridge_turn(tuple(_form(branch) for branch in branches))  # type: ignore[arg-type]
        return ("#", *(branches[i] for i in turn))
    # a: terminal 1 to 2, b: 1 to 3, e: 2 to 3, c: 2 to terminal 0, d: 3 to 0
    rigid = branches[gone] == _RIGID
    a, b, e, c, d = branches
    if gone == 2:  # the cross branch
        if rigid:
            return _joined("+", [_joined("|", [a, b]), _joined("|", [c, d])])
        return _joined("|", [_joined("+", [a, c]), _joined("+", [b, d])])
    # by symmetry, call the branch that is gone a; b shares its terminal, c its inner node, d is opposite
    b, c, d = {0: (b, c, d), 1: (a, d, c), 3: (d, a, b), 4: (c, b, a)}[gone]
    if rigid:  # inner node 2 is the terminal
        return _joined("|", [c, _joined("+", [_joined("|", [b, e]), d])])
    return _joined("+", [b, _joined("|", [_joined("+", [e, c]), d])])


def start(limit: Limit, values: Sequence[float], lost: float, idle: Sequence[float]) -> list[float]:
    """Values of the larger network at its limit.

    Parameters
    ----------
    limit : Limit
    values : of the limit's elements
    lost : float
        Value of the element that the limit lost.
    idle : sequence of float
        Values of elements that went with it, having nothing to hold on to.
    """
    whole = list(idle)
    for value, pairs in zip(values, limit.sources, strict=True):
        for index, share in pairs:
            whole[index] = share * value
    whole[limit.lost] = lost
    return whole
