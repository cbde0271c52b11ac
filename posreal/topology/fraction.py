"""A network's admittance as a ratio of polynomials in floats, and from there its matrices.

Numerator and denominator are sums over trees and linear in each element's admittance, so a joint needs products only,

    |  n = n₁d₂ + n₂d₁, d = d₁d₂          +  n = n₁n₂, d = n₁d₂ + n₂d₁,

and with general values nothing but a power of s can be common to both; where it is, its coefficients are exact zeros.
Polynomials are in p = s/ω₀ with values in the vehicle's units, which keeps coefficients near one. The exact admittance
(:meth:`posreal.network.Network.admittance`) decides in the end; this one is for the inner loop.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from itertools import zip_longest

import numpy as np

from posreal.admittance.state_space import StateSpace
from posreal.network.topologies import Form, letters
from posreal.topology.batch import Array
from posreal.topology.ground import Scale

Fraction = tuple[Array, Array]

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
    return np.array([x + y for x, y in zip_longest(a, b, fillvalue=0.0)])


def _reduced(n: Array, d: Array) -> Fraction:
    """Without common powers of p and leading zeros."""
    low = min(int(np.flatnonzero(n)[0]), int(np.flatnonzero(d)[0]))
    return np.trim_zeros(n[low:], "b"), np.trim_zeros(d[low:], "b")


def matrices(form: Form, values: Array, scale: Scale, *, beside: float = 0.0) -> StateSpace:
    """The device in state space, with a spring of stiffness `beside` in parallel; values in SI units."""
    n, d = fraction(form, (values / scale.units(letters(form))).tolist())
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
    w, c = scale.omega0, scale.c0
    return StateSpace(w * A, w * B, c * rest[None, :], np.array([[c * through]]), c * w * k + beside, c / w * b)
