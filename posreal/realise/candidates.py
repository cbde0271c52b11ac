"""All small networks: series–parallel trees over spring, damper and inerter, and the bridges.

Trees alternate series and parallel, children are unordered, and no node joins two equal leaves (they
would be one element): 3, 6, 20, 90, 432, 2202 of 1, 2, … 6 elements. A network is only worth fitting if
it behaves like the device at rest and at high frequency.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from itertools import product
from typing import Any

from posreal.admittance import Rational
from posreal.network import Damper, Inerter, Network, Spring, bridge, parallel, series

Form = tuple  # ("k",) or ("+", child, …) or ("|", child, …), children sorted
LEAVES = (("b",), ("c",), ("k",))
_MAKE: dict[str, type[Any]] = {"k": Spring, "c": Damper, "b": Inerter}


@lru_cache
def forms(size: int, root: str = "") -> tuple[Form, ...]:
    """Trees of so many elements, those whose root joins by "+" or "|" only if asked."""
    if size == 1:
        return () if root else LEAVES
    roots = (root,) if root else ("+", "|")
    return tuple((sign, *children) for sign in roots for children in _families(size, sign, size - 1, ()))


def _families(size: int, sign: str, largest: int, least: Form) -> Iterator[tuple[Form, ...]]:
    """Children of one node, sizes falling, equal sizes in rising order, equal leaves only once."""
    if size == 0:
        yield ()
        return
    other = "|" if sign == "+" else "+"
    for first in range(min(size, largest), 0, -1):
        for child in forms(first) if first == 1 else forms(first, other):
            if first == largest and least and (child < least or (child == least and first == 1)):
                continue
            for rest in _families(size - first, sign, first, child):
                yield (child, *rest)


def build(form: Form) -> Network:
    """The network of a form, without values."""
    if len(form) == 1:
        return _MAKE[form[0]]()
    return (series if form[0] == "+" else parallel)(*map(build, form[1:]))


def end_orders(form: Form) -> tuple[int, int]:
    """The power of s that the admittance grows with at 0 and at infinity: −1, 0 or 1."""
    if len(form) == 1:
        power = "kcb".index(form[0]) - 1
        return power, power
    low, high = zip(*map(end_orders, form[1:]), strict=True)
    return (max(low), min(high)) if form[0] == "+" else (min(low), max(high))


def device_orders(y: Rational) -> tuple[int, int]:
    """The same for a device."""
    low = next(i for i, c in enumerate(y.n.coeffs()) if c != 0) - (1 if y.d[0] == 0 else 0)
    return low, y.n.degree() - y.d.degree()


def trees(y: Rational, size: int, stores: int | None = None) -> Iterator[Network]:
    """Series–parallel networks that may have this admittance; `stores` fixes the springs and inerters."""
    wanted = device_orders(y)
    for form in forms(size):
        count = sum(letters(form).count(letter) for letter in "kb")
        if count >= y.degree and (stores is None or count == stores) and end_orders(form) == wanted:
            yield build(form)


def bridges(stores: int) -> Iterator[Network]:
    """Five-element bridges with so many springs and inerters, mirror images left out."""
    seen = set()
    for kinds in product("kcb", repeat=5):
        a, b, x, c, d = kinds
        images = [(a, b, x, c, d), (b, a, x, d, c), (c, d, x, a, b), (d, c, x, b, a)]
        if min(images) == kinds and sum(kind != "c" for kind in kinds) == stores and kinds not in seen:
            seen.add(kinds)
            yield bridge(*(_MAKE[kind]() for kind in kinds))


def letters(form: Form) -> str:
    """The elements' kinds in order."""
    return form[0] if len(form) == 1 else "".join(map(letters, form[1:]))
