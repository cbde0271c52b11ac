"""Y(s) of one topology for many sets of values in one go, and the gradient of whatever is made of it.

Each joint is met once going up and once coming down, whatever the number of values and frequencies. Going up,
a parallel joint adds admittances and a series joint impedances, so that only a change of joint costs a
division. Coming down, with the adjoint g such that dJ = Re Σ g dY over the grid,

    parallel   g_child = g                series, of impedances   h_child = h,   h = −g Y²,   g = −h Z²
    element    ∂J/∂ log θ = Re Σ g Y      in impedances           ∂J/∂ log θ = −Re Σ h Z

    bridge     Y = [ab(c+d) + cd(a+b) + e(a+b)(c+d)] / [(a+c)(b+d) + e(a+b+c+d)],   g_branch = g
    (v_branch/v_port)²

This is :mod:`posreal.network.response` with a third axis, over sets of values, and without levers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posreal.network.as_made import leaf
from posreal.network.topologies import Form, letters
from posreal.real_elements import Parasitics, RealElements

Array = NDArray[Any]
Pull = Callable[[Array, Array], None]  # takes an adjoint, fills in gradients

_POWER = {"k": -1, "c": 0, "b": 1}


@dataclass(frozen=True)
class Grid:
    """Points s and their powers −1, 0, 1, shapes (N,), and what comes with the elements that stand there."""

    s: Array
    powers: tuple[Array, Array, Array]
    elements: RealElements | None = None

    @classmethod
    def at(cls, s: Array, elements: RealElements | None = None) -> Grid:
        """The grid of given points."""
        return cls(s, (1 / s, np.ones_like(s), s), elements)


def admittance(form: Form, theta: Array, grid: Grid) -> tuple[Array, Callable[[Array], Array]]:
    """Y for sets of values, and the map from dJ/dY to dJ/dθ.

    Parameters
    ----------
    form : Form
    theta : (B, n) logarithms of the values, in the order of the form's elements
    grid : Grid of N points

    Returns
    -------
    Y : (B, N) complex
    pull : function of (B, N) complex g with dJ = Re Σ g dY, giving (B, n) ∂J/∂θ
    """
    values = np.exp(theta)
    y, back = _up(_numbered(form), values, grid, False)

    def pull(g: Array) -> Array:
        gradient = np.empty_like(values)
        back(g, gradient)
        return gradient

    return y, pull


@lru_cache(maxsize=1 << 12)
def _numbered(form: Form) -> tuple[Any, ...]:
    counter = iter(range(len(letters(form))))

    def number(inner: Form) -> tuple[Any, ...]:
        if isinstance(inner, str):
            return (inner, next(counter))
        return (inner[0], *(number(child) for child in inner[1:]))

    return number(form)


def _up(part: tuple[Any, ...], values: Array, grid: Grid, impedance: bool) -> tuple[Array, Pull]:
    """The admittance of a part, or its impedance, and the way back down."""
    sign, *children = part
    if sign in _POWER:
        return _element(sign, children[0], values, grid, impedance)
    if sign == "#":
        return _inverted(*_bridge(children, values, grid)) if impedance else _bridge(children, values, grid)
    inside = [_up(child, values, grid, sign == "+") for child in children]
    total = inside[0][0] + inside[1][0]
    for value, _ in inside[2:]:
        total += value

    def back(g: Array, gradient: Array) -> None:
        for _, pull in inside:
            pull(g, gradient)

    return (total, back) if impedance == (sign == "+") else _inverted(total, back)


def _inverted(value: Array, back: Pull) -> tuple[Array, Pull]:
    """1/value for an admittance or an impedance."""
    other = 1 / value

    def through(g: Array, gradient: Array) -> None:
        back(-g * other * other, gradient)

    return other, through


def _element(letter: str, index: int, values: Array, grid: Grid, impedance: bool) -> tuple[Array, Pull]:
    if grid.elements is not None and not (kind := grid.elements.of(letter)).is_nothing:
        return _real_element(kind, letter, index, values, grid, impedance)
    power = -_POWER[letter] if impedance else _POWER[letter]
    size = 1 / values[:, index] if impedance else values[:, index]
    sign = -1.0 if impedance else 1.0
    points = grid.powers[power + 1]

    def back(g: Array, gradient: Array) -> None:
        gradient[:, index] = sign * size * (g.real @ points.real - g.imag @ points.imag)

    return np.multiply.outer(size, points), back


def _real_element(
    kind: Parasitics, letter: str, index: int, values: Array, grid: Grid, impedance: bool
) -> tuple[Array, Pull]:
    """An element with what comes with it: Y of the whole, ∂Y/∂ log θ = Y₀ times its share of the slope."""
    own = np.multiply.outer(values[:, index], grid.powers[_POWER[letter] + 1])
    y, share = leaf(kind, own, grid.s)
    slope = own * share

    def back(g: Array, gradient: Array) -> None:
        gradient[:, index] = (g * slope).real.sum(axis=1)

    return _inverted(y, back) if impedance else (y, back)


def _bridge(children: list[Any], values: Array, grid: Grid) -> tuple[Array, Pull]:
    inside = [_up(child, values, grid, False) for child in children]
    a, b, e, c, d = (y for y, _ in inside)
    ac, bd = a + c, b + d
    det = ac * bd + e * (ac + bd)
    x2, x3 = (a * (bd + e) + e * b) / det, (b * (ac + e) + e * a) / det
    y = a * (1 - x2) + b * (1 - x3)

    def back(g: Array, gradient: Array) -> None:
        for drop, (_, pull) in zip((1 - x2, 1 - x3, x2 - x3, x2, x3), inside, strict=True):
            pull(g * drop * drop, gradient)

    return y, back
