"""Every network of up to six elements as the polynomials that its admittance is made of [Kirchhoff1847].

    Y = T/U,    T = Σ over spanning trees Π y_e,    U = Σ over spanning forests of two trees, a terminal in each, Π y_e

with y_e = k/s, c or b s. In series T = T₁T₂, U = T₁U₂ + U₁T₂; in parallel the other way round; a bridge has eight trees
and eight forests. A product is a set of elements, a bit each, so all networks of one size stand in one array.

What Y does at 0 and at ∞ (a spring's, a damper's or an inerter's) does not depend on the values, and its degree is at
most what the powers of s span; so a device has to be sought among few of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np
from flint import fmpq, fmpq_poly
from numpy.typing import NDArray

from posreal.admittance import Rational
from posreal.network.topologies import Form, letters, topologies

LARGEST = 6  # elements
_TREES = tuple(three for three in combinations(range(5), 3) if three not in ((0, 1, 2), (2, 3, 4)))
_FORESTS = tuple(two for two in combinations(range(5), 2) if two not in ((0, 3), (1, 4)))
_POWER = {"k": -1, "c": 0, "b": 1}


@dataclass(frozen=True)
class Entry:
    """A topology: the products in T and in U, bit i for element i, and the power of s of each."""

    form: Form
    trees: tuple[int, ...]
    forests: tuple[int, ...]
    powers: tuple[tuple[int, ...], tuple[int, ...]]

    @property
    def size(self) -> int:
        """Elements."""
        return len(letters(self.form))

    @property
    def ends(self) -> tuple[int, int]:
        """The power of s that Y goes with at 0 and at ∞: −1 a spring's, 0 a damper's, 1 an inerter's."""
        top, bottom = self.powers
        return min(top) - min(bottom), max(top) - max(bottom)

    @property
    def degree(self) -> int:
        """The most that the McMillan degree can be."""
        powers = [*self.powers[0], *self.powers[1]]
        return max(powers) - min(powers)

    def polynomials(self, values: Sequence[fmpq]) -> tuple[list[fmpq_poly], list[fmpq_poly]]:
        """(T and its derivatives by log values, U and its), times s to the power that makes them polynomials."""
        lowest = min(*self.powers[0], *self.powers[1])
        found = []
        for products, powers in zip((self.trees, self.forests), self.powers, strict=True):
            sums = [[fmpq(0)] * (self.degree + 1) for _ in range(self.size + 1)]
            for product, power in zip(products, powers, strict=True):
                term = fmpq(1)
                chosen = [i for i in range(self.size) if product >> i & 1]
                for i in chosen:
                    term *= values[i]
                for row in (0, *(i + 1 for i in chosen)):
                    sums[row][power - lowest] += term
            found.append([fmpq_poly(row) for row in sums])
        return found[0], found[1]


@dataclass(frozen=True)
class Catalogue:
    """Topologies of one size as arrays: per sum the exponents (F, M, n), powers of s (F, M), and which are there."""

    entries: tuple[Entry, ...]
    exponents: tuple[NDArray[np.float64], NDArray[np.float64]]
    powers: tuple[NDArray[np.float64], NDArray[np.float64]]
    there: tuple[NDArray[np.float64], NDArray[np.float64]]

    def only(self, rows: Sequence[int]) -> Catalogue:
        """Some of the topologies."""
        arrays = ((pair[0][rows], pair[1][rows]) for pair in (self.exponents, self.powers, self.there))
        return Catalogue(tuple(self.entries[i] for i in rows), *arrays)


def behaviour(y: Rational) -> tuple[int, int]:
    """The power of s that Y goes with at 0 and at ∞."""
    at_zero = [next(i for i, c in enumerate(p.coeffs()) if c != 0) for p in (y.n, y.d)]
    return at_zero[0] - at_zero[1], y.n.degree() - y.d.degree()


@lru_cache(maxsize=256)
def catalogue(size: int, degree: int, ends: tuple[int, int]) -> Catalogue:
    """The topologies of `size` elements that may have an admittance of a degree with such ends."""
    chosen = tuple(e for e in _entries(size) if e.ends == ends and degree <= e.degree)
    exponents, powers, there = [], [], []
    for which in (0, 1):
        sums = [(entry.trees, entry.forests)[which] for entry in chosen]
        longest = max((len(products) for products in sums), default=0)
        padded = np.array([[*products, *[-1] * (longest - len(products))] for products in sums], dtype=int)
        padded = padded.reshape(len(chosen), longest)
        exponents.append(((padded[:, :, None] >> np.arange(size)) & 1).astype(float))
        powers.append(np.array([[*e.powers[which], *[0] * (longest - len(e.powers[which]))] for e in chosen], float))
        there.append((padded >= 0).astype(float))
    return Catalogue(chosen, *((pair[0], pair[1]) for pair in (exponents, powers, there)))


@lru_cache
def _entries(size: int) -> tuple[Entry, ...]:
    found = []
    for form in topologies(size):
        trees, forests = _sums(form, 0)
        power = [_POWER[kind] for kind in letters(form)]
        powers = tuple(
            tuple(sum(power[i] for i in range(size) if product >> i & 1) for product in products)
            for products in (trees, forests)
        )
        found.append(Entry(form, tuple(trees), tuple(forests), (powers[0], powers[1])))
    return tuple(found)


def _sums(form: Form, first: int) -> tuple[list[int], list[int]]:
    """T and U as lists of products, the form's first element being bit `first`."""
    if isinstance(form, str):
        return [1 << first], [0]
    sign, *children = form
    parts = []
    for child in children:
        parts.append(_sums(child, first))
        first += len(letters(child))
    if sign == "#":
        return _mixed(parts, _TREES), _mixed(parts, _FORESTS)
    everything = tuple(range(len(parts)))
    one_of_each, one_out = [everything], [(i,) for i in everything]
    if sign == "|":
        return _mixed(parts, one_out), _mixed(parts, [()])
    return _mixed(parts, one_of_each), _mixed(parts, [tuple(j for j in everything if j != i) for i in everything])


def _mixed(parts: list[tuple[list[int], list[int]]], choices: Sequence[tuple[int, ...]]) -> list[int]:
    """Σ over choices of the product of T of the chosen parts and U of the others."""
    found = []
    for chosen in choices:
        products = [0]
        for i, (trees, forests) in enumerate(parts):
            products = [a | b for a in products for b in (trees if i in chosen else forests)]
        found += products
    return found
