"""Topologies that need no optimising, because another one with no more elements does all they can do.

Write T → T' when every admittance of T, for whatever positive values, is one of T' or of its limits, and T'
has no more springs, dampers or inerters than T. Such a T can be left out: whatever it reaches, T' reaches,
with no more parts. Three rules give the arrows; each holds for a part of a network as well, since a part
enters its network by its admittance only.

**Exchange.** X | (X + R) ↔ X + (X | R) for one kind of element X and any R [Zobel's transformation]. With
admittances aX, bX and Y of R, and t = (1 + a/b)²,

    aX + 1/(1/(bX) + 1/Y) = 1/(1/((a + b) X) + 1/((a (a + b)/b) X + t Y)):

all values stay positive, so each side covers the other. Where the result puts two like elements into one
joint they are one, and the network was a smaller one.

**Foster.** A part made of two kinds only is worth its Foster form: elements in parallel, and pairs in series. For
springs and dampers Y = k₀/s + c₀ + Σ kᵢcᵢ/(kᵢ + cᵢ s). It has no more elements *of either kind*: the degree of Y in s
is the number of its springs, and the degree of s·Y (in which springs are constants and dampers reactive) is the
number of its dampers; neither can exceed the number of such elements in T. Dampers and inerters: the same for Y/s.
Springs and inerters: the same for s·Y and Y/s as functions of s². In particular a network with one reactive element,
whose degree is at most one, is never better than one with three elements in all, since those have every positive-real
admittance of degree one: no network beats the best device of its degree.

**Star and triangle.** A bridge in which three branches of one kind make a triangle (or a star) is the tree
that has the star (or the triangle) in its place: the formulas of Kennelly keep values positive, and there are
three either way.

From every set of topologies that lead to each other one is kept, if no arrow leaves the set. With bounds on
values the other side of an exchange may be out of bounds, so these rules are for free values.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import lru_cache
from itertools import combinations

import networkx as nx

from posreal.network.topologies import DUAL, Form, bridged, joined, key, letters, network, topologies

_TRIANGLES = {(0, 1, 2): (3, 4), (2, 3, 4): (0, 1)}
_STARS = {(0, 2, 3): (1, 4), (1, 2, 4): (0, 3)}


def rewritten(form: Form) -> Iterator[Form]:
    """Every T' with T → T' by one rule, applied once anywhere in the form."""
    yield from _at_root(form)
    if isinstance(form, str):
        return
    sign, *children = form
    for i, child in enumerate(children):
        for other in rewritten(child):
            changed = (*children[:i], other, *children[i + 1 :])
            yield bridged(changed) if sign == "#" else joined(sign, changed)


def _at_root(form: Form) -> Iterator[Form]:
    if isinstance(form, str):
        return
    sign, *children = form
    if sign == "#":
        yield from _star_and_triangle(tuple(children))
        yield from _foster(form)
        return
    for part, rest in _parts(tuple(children)):
        whole = joined(sign, part)
        for other in (*_exchanged(sign, part), *_foster(whole)):
            yield joined(sign, (other, *rest)) if rest else other


def _parts(children: tuple[Form, ...]) -> Iterator[tuple[tuple[Form, ...], tuple[Form, ...]]]:
    """Two or more of the children of a joint, and the others."""
    for count in range(2, len(children) + 1):
        for chosen in combinations(range(len(children)), count):
            yield (
                tuple(children[i] for i in chosen),
                tuple(c for i, c in enumerate(children) if i not in chosen),
            )


def _exchanged(sign: str, part: tuple[Form, ...]) -> Iterator[Form]:
    """X sign (X dual R) as X dual (X sign R)."""
    if len(part) != 2:
        return
    for element, joint in (part, part[::-1]):
        if isinstance(element, str) and joint[0] == DUAL[sign] and element in joint[1:]:
            rest = joined(DUAL[sign], [child for child in joint[1:] if child != element])
            yield joined(DUAL[sign], (element, joined(sign, (element, rest))))


def _foster(form: Form) -> Iterator[Form]:
    """The Foster form of a network of two kinds, if it is another one."""
    kinds = sorted(set(letters(form)))
    if len(kinds) == 2 and len(letters(form)) > 2:
        other = foster_form(form)
        if other != form:
            yield other


@lru_cache(maxsize=1 << 12)
def foster_form(form: Form) -> Form:
    """Foster's first form for a network of two kinds with general values."""
    first, second = sorted(set(letters(form)))
    # general values: distinct primes, of which no pole and zero meets another
    primes = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37)
    topology = network(form)
    values = {
        name: Fraction(p, primes[-1 - i]) for i, (name, p) in enumerate(zip(topology.names, primes, strict=False))
    }
    Y = topology.with_values(values).admittance()
    alone = [letter for letter in (first, second) if _connects(form, letter)]
    # every pair adds one to the degree in s if one of the two is reactive, two if both are
    reactive = [letter for letter in (first, second) if letter != "c"]
    pairs = (Y.degree - sum(letter in reactive for letter in alone)) // len(reactive)
    return joined("|", (*alone, *([("+", first, second)] * pairs)))


def _connects(form: Form, letter: str) -> bool:
    """Whether elements of one kind alone lead from terminal to terminal."""
    if isinstance(form, str):
        return form == letter
    sign, *children = form
    through = [_connects(child, letter) for child in children]
    if sign == "#":
        a, b, e, c, d = through
        return (a and c) or (b and d) or (e and ((a and d) or (b and c)))
    return all(through) if sign == "+" else any(through)


def _star_and_triangle(branches: tuple[Form, ...]) -> Iterator[Form]:
    for three, others in _TRIANGLES.items():
        if _alike(branches, three):
            x, (c, d) = branches[three[0]], (branches[i] for i in others)
            yield joined("+", (x, joined("|", (joined("+", (x, c)), joined("+", (x, d))))))
    for three, others in _STARS.items():
        if _alike(branches, three):
            x, (b, d) = branches[three[0]], (branches[i] for i in others)
            yield joined("|", (x, joined("+", (joined("|", (x, b)), joined("|", (x, d))))))


def _alike(branches: tuple[Form, ...], three: tuple[int, ...]) -> bool:
    kinds = {branches[i] for i in three}
    return len(kinds) == 1 and kinds <= set("kcb")


@lru_cache
def classes(size: int) -> dict[Form, Form]:
    """Every topology of up to `size` elements and the kept one that stands for it, itself if it is kept."""
    arrows: nx.DiGraph[Form] = nx.DiGraph()
    for n in range(1, size + 1):
        for form in topologies(n):
            arrows.add_node(form)
            arrows.add_edges_from((form, other) for other in rewritten(form))
    condensed = nx.condensation(arrows)
    stands: dict[int, Form] = {}
    for node in reversed(list(nx.topological_sort(condensed))):
        after = [stands[other] for other in condensed.successors(node)]
        candidates = after or list(condensed.nodes[node]["members"])
        stands[node] = min(candidates, key=_plainness)
    return {form: stands[node] for form, node in condensed.graph["mapping"].items()}


def _plainness(form: Form) -> tuple[int, bool, int, str]:
    text = key(form)
    return len(letters(form)), "{" in text, len(text), text
