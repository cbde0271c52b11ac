"""A network's admittance as a ratio of polynomials in floats, and from there its matrices.

Numerator and denominator are sums over trees and linear in each element's admittance, so a joint needs products only,

    |  n = n₁d₂ + n₂d₁, d = d₁d₂          +  n = n₁n₂, d = n₁d₂ + n₂d₁,

and with general values nothing but a power of s can be common to both; where it is, its coefficients are exact zeros.
Polynomials are in p = s/ω₀ with values in units about which they lie, which keeps coefficients near one. The exact
admittance (:meth:`posreal.network.Network.admittance`) decides in the end; this one is for the inner loop of searches.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posreal.admittance.state_space import StateSpace
from posreal.network.graph import Graph
from posreal.network.topologies import Form, letters
from posreal.network.tree import Damper, Inerter, Network, Parallel, Series, Spring

Array = NDArray[Any]
Fraction = tuple[Array, Array]

_BRIDGE = [(1, 2), (1, 3), (2, 3), (2, 0), (3, 0)]

# Branches a (terminal 1 to inner node 2), b (1 to 3), e (2 to 3), c (2 to terminal 0), d (3 to 0) as 0 … 4: the trees
# of the bridge, and those of what is left when its terminals are made one node.
_TREES = ("013", "014", "034", "134", "203", "204", "213", "214")
_FORESTS = ("01", "04", "31", "34", "20", "21", "23", "24")


def fraction(form: Form, values: Sequence[float]) -> Fraction:
    """Numerator and denominator, ascending powers, for values in the form's order."""
    return _fraction(form, iter(values))


def _fraction(form: Form, values: object) -> Fraction:
    if isinstance(form, str):
        value = next(values)  # type: ignore[call-overload]
        one = np.ones(1)
        return {
            "k": (np.array([value]), np.array([0.0, 1.0])),
            "c": (np.array([value]), one),
            "b": (np.array([0.0, value]), one),
        }[form]
    children = [_fraction(child, values) for child in form[1:]]
    if form[0] == "#":
        return _reduced(_sum_over(_TREES, children), _sum_over(_FORESTS, children))
    join = _beside if form[0] == "|" else _behind
    return reduce(join, children)


def _beside(one: Fraction, two: Fraction) -> Fraction:
    return _reduced(_plus(np.convolve(one[0], two[1]), np.convolve(two[0], one[1])), np.convolve(one[1], two[1]))


def _behind(one: Fraction, two: Fraction) -> Fraction:
    d, n = _beside(one[::-1], two[::-1])
    return n, d


def _sum_over(terms: tuple[str, ...], branches: list[Fraction]) -> Array:
    """Σ over terms of ∏ numerators of the branches in it and denominators of the others."""
    products = (
        reduce(np.convolve, [branch[0 if str(i) in term else 1] for i, branch in enumerate(branches)]) for term in terms
    )
    return reduce(_plus, products)


def _plus(a: Array, b: Array) -> Array:
    if len(a) < len(b):
        a, b = b, a
    total = a.copy()
    total[: len(b)] += b
    return total


def _reduced(n: Array, d: Array) -> Fraction:
    """Without common powers of p and leading zeros."""
    top, bottom = n.nonzero()[0], d.nonzero()[0]
    low = min(top[0], bottom[0])
    return n[low : top[-1] + 1], d[low : bottom[-1] + 1]


def matrices(form: Form, values: Sequence[float]) -> StateSpace:
    """The network in state space; values in N/m, N s/m and kg, in the form's order."""
    c, w = _units(letters(form), values)
    unit = {"k": c * w, "c": c, "b": c / w}
    n, d = fraction(form, [value / unit[letter] for letter, value in zip(letters(form), values, strict=True)])
    k = b = 0.0
    if d[0] == 0.0:  # n/d = k/p + rest/(d/p)
        k = n[0] / d[1]
        d = d[1:]
        n = _plus(n, -k * d)[1:]
    if len(n) > len(d):
        b = n[-1] / d[-1]
        n = _plus(n, -b * np.concatenate([[0.0], d]))[:-1]
    n, d = n / d[-1], d / d[-1]
    order = len(d) - 1
    through = n[order] if len(n) > order else 0.0
    rest = np.zeros(order)
    rest[: min(len(n), order)] = n[:order]
    rest -= through * d[:order]
    A = np.eye(order, k=1)
    B = np.zeros((order, 1))
    if order:
        A[-1] = -d[:order]
        B[-1] = 1.0
    return StateSpace(w * A, w * B, c * rest[None, :], np.array([[c * through]]), c * w * k, c / w * b)


def form_of(network: Network) -> Form | None:
    """The form of a series-parallel network or of the five-branch bridge in one; None for other graphs and levers."""
    if isinstance(network, Spring | Damper | Inerter):
        return network.letter
    if isinstance(network, Series | Parallel):
        sign = "+" if isinstance(network, Series) else "|"
        inner = [form_of(child) for child in network.children]
    elif isinstance(network, Graph) and not network.levers and [b[:2] for b in network.branches] == _BRIDGE:
        sign, inner = "#", [form_of(branch) for _, _, branch in network.branches]
    else:
        return None
    known = [part for part in inner if part is not None]
    return (sign, *known) if len(known) == len(inner) else None


def _units(kinds: str, values: Sequence[float]) -> tuple[float, float]:
    """A damping and a frequency about which the values lie, so that polynomials have coefficients near one."""
    middle = {}
    for kind in set(kinds):
        logs = [math.log(value) for letter, value in zip(kinds, values, strict=True) if letter == kind]
        middle[kind] = math.exp(sum(logs) / len(logs))
    k, c, b = (middle.get(kind, 0.0) for kind in "kcb")
    omega = math.sqrt(k / b) if k and b else k / c if k and c else c / b if c and b else 1.0
    return c or (k / omega if k else b * omega), omega
