"""Every two-terminal network of n springs, dampers and inerters, once.

Series–parallel: a joint holds two children or more, each an element or a joint of the other kind, in no order, and no
two equal elements (they would be one). By duality half of the a_n trees of n ≥ 2 elements are series joints, half
parallel ones. A set of elements and a bag of joints of one kind is a joint of the other kind, or is a single joint:

    (1 + x)³ ∏_{m ≥ 2} (1 − x^m)^{−a_m/2} = 1 + Σ_{n ≥ 1} a_n x^n,      a = 3, 6, 20, 90, 432, 2202, 11700, …

From five elements on there are also bridges: Wheatstone's five branches, each an element or a tree, and trees over
them. Up to six elements this is every graph: a two-terminal network that no series or parallel joint divides is, with
an edge from terminal to terminal added, a 3-connected graph; the least is the tetrahedron, which leaves the bridge,
and the next, the wheel with four spokes, has seven edges besides that one.

A topology is a *form*: the letter of an element, or a tuple of a sign and children. Children of ``+`` and
``|`` stand in the order of their keys, the five branches of a bridge ``#`` as
:func:`posreal.network.bridge` takes them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from itertools import combinations_with_replacement, product
from typing import Any, TypeAlias

from posreal.network.graph import bridge
from posreal.network.tree import Damper, Inerter, Network, Parallel, Series, Spring

Form: TypeAlias = "str | tuple[Any, ...]"

KINDS = "kcb"
MOST_WITH_BRIDGES = 6  # elements up to which trees and bridges are every network there is
DUAL = {"+": "|", "|": "+"}
_ELEMENT: dict[str, Callable[[], Network]] = {"k": Spring, "c": Damper, "b": Inerter}
# Which branches change places when the terminals do, when the inner nodes do, and when both do.
_BRIDGE_TURNS = ((0, 1, 2, 3, 4), (3, 4, 2, 0, 1), (1, 0, 2, 4, 3), (4, 3, 2, 1, 0))


@lru_cache(maxsize=1 << 16)
def key(form: Form) -> str:
    """Text that tells a form from every other: the notation without values, ``(b+c)|k``."""
    if isinstance(form, str):
        return form
    sign, *children = form
    texts = [key(child) for child in children]
    if sign == "#":
        return "{" + ",".join(texts) + "}"
    return sign.join(f"({text})" if child[0] in DUAL else text for child, text in zip(children, texts, strict=True))


@lru_cache(maxsize=1 << 16)
def letters(form: Form) -> str:
    """The kinds of a form's elements, in the order in which its values are given."""
    return form if isinstance(form, str) else "".join(letters(child) for child in form[1:])


def joined(sign: str, children: Sequence[Form]) -> Form:
    """Children in series or in parallel: like joints flattened, like elements merged, the rest put in order."""
    flat: list[Form] = []
    for child in children:
        flat.extend(child[1:] if child[0] == sign else (child,))
    elements = sorted({child for child in flat if isinstance(child, str)})
    rest = [child for child in flat if not isinstance(child, str)]
    ordered: list[Form] = sorted([*elements, *rest], key=key)
    if len(ordered) == 1:
        return ordered[0]
    return (sign, *ordered)


def bridge_turn(branches: tuple[Form, ...]) -> tuple[int, ...]:
    """Which of the four ways to look at a bridge gives it the least key, as the new order of its branches."""
    return min(_BRIDGE_TURNS, key=lambda turn: [key(branches[i]) for i in turn])


def bridged(branches: tuple[Form, ...]) -> Form:
    """The bridge of five branches, the way round that has the least key."""
    return ("#", *(branches[i] for i in bridge_turn(branches)))


@lru_cache
def joints(sign: str, size: int, bridges: bool) -> tuple[Form, ...]:
    """Every form of `size` elements whose outermost joint is `sign`, in the order of their keys."""
    if sign == "#":
        found = {bridged(branches) for branches in _branchings(size)} if bridges else set()
        return tuple(sorted(found, key=key))
    return tuple(sorted({joined(sign, children) for children in _children(sign, size, size - 1, bridges)}, key=key))


def _children(sign: str, size: int, largest: int, bridges: bool) -> Iterator[tuple[Form, ...]]:
    """Sets of children of `size` elements in all, none larger than `largest`: bags of joints, a set of elements."""
    if largest <= 1:
        if size <= len(KINDS):
            yield from (chosen for chosen in combinations_with_replacement(KINDS, size) if len(set(chosen)) == size)
        return
    inner = joints(DUAL[sign], largest, bridges) + joints("#", largest, bridges)
    for count in range(size // largest + 1):
        for bag in combinations_with_replacement(inner, count):
            yield from (bag + rest for rest in _children(sign, size - count * largest, largest - 1, bridges))


def _branchings(size: int) -> Iterator[tuple[Form, ...]]:
    for sizes in product(range(1, size - 3), repeat=5):
        if sum(sizes) == size:
            yield from product(*(forms(n, bridges=True) for n in sizes))


def topologies(size: int) -> tuple[Form, ...]:
    """What is searched: all topologies of up to six elements, all trees of seven."""
    return forms(size, bridges=size <= MOST_WITH_BRIDGES)


@lru_cache
def forms(size: int, *, bridges: bool = True) -> tuple[Form, ...]:
    """Every topology of exactly `size` elements, trees first.

    Examples
    --------
    >>> [len(forms(n, bridges=False)) for n in range(1, 6)]
    [3, 6, 20, 90, 432]
    """
    if size < 1:
        return ()
    if size == 1:
        return tuple(KINDS)
    found = [form for sign in "+|#" for form in joints(sign, size, bridges)]
    return tuple(sorted(found, key=lambda form: ("{" in key(form), key(form))))


def network(form: Form) -> Network:
    """The form as a network whose elements have no values yet, in the same order."""
    if isinstance(form, str):
        return _ELEMENT[form]()
    children = tuple(network(child) for child in form[1:])
    if form[0] == "#":
        return bridge(*children)
    return (Series if form[0] == "+" else Parallel)(children)


def valued(form: Form, values: Sequence[float]) -> Network:
    """The form as a network with values in N/m, N s/m and kg."""
    topology = network(form)
    return topology.with_values(dict(zip(topology.names, (float(value) for value in values), strict=True)))
