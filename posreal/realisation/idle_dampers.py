"""Dampers that do nothing: one of 1e-11 N s/m beside a suspension is not an element to build.

A device on the boundary of positive realness is presented a hair inside it, and the hair comes out as a damper
of its own. A damper whose value moves Y by less than 1e-11 of itself anywhere near the device's corners,

    max |∂Y/∂log θ| / |Y| < 1e-11,

is left out: opened where it stands in parallel, closed where it stands in series. What remains is passive like any
network, and is proven against the same target. Springs and inerters stay: each holds a pole, and an undamped
resonance next to a zero is felt nowhere but at its own frequency.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count

import numpy as np

from posreal.admittance import Rational
from posreal.network import Element, Network, Parallel, Series, parallel, series
from posreal.realisation.proof import LARGEST_RESIDUAL, branch_residual, corners, prove

SMALL = 1e-11
"""A tenth of what a residual shows at its second digit, a hundredth of what the proof allows."""
POINTS = 200


def without_negligible(network: Network, target: Rational) -> tuple[Network, tuple[str, ...]]:
    """The network without its negligible dampers, and what was left out.

    Dampers inside a graph (a bridge, a lever) are kept, and so is everything where the proof of the smaller network
    would be weaker than 1e-10.
    """
    s = 1j * np.geomspace(*corners(target), POINTS)
    effects = np.max(np.abs(network.sensitivities(s)) / np.abs(np.asarray(target(s))), axis=1)
    elements = network.elements()

    def serves(gone: set[int]) -> bool:
        rest = _without(network, gone, count())
        return rest is not None and branch_residual(rest, target) <= SMALL

    def stands_free(index: int) -> bool:
        return len(_without(network, {index}, count()) or ()) < len(network)

    small = [int(i) for i in np.argsort(effects) if effects[i] < SMALL]
    idle = [index for index in small if elements[index].letter == "c" and stands_free(index)]

    left_out = set(idle)
    if idle and not serves(left_out):  # not all of them at once
        left_out = set()
        for index in idle:
            if serves(left_out | {index}):
                left_out.add(index)
    smaller = _without(network, left_out, count())
    if not left_out or smaller is None or prove(smaller, target).residual > LARGEST_RESIDUAL / 10:
        return network, ()
    said = tuple(
        f"a {elements[i].kind} of {float(elements[i].exact):.2g} {elements[i].unit} was left out: it does nothing"
        for i in sorted(left_out)
    )
    return smaller.unnamed(), said


def _without(network: Network, gone: set[int], number: Iterator[int]) -> Network | None:
    """The network without some of its elements, counted in order; None if nothing is left."""
    if isinstance(network, Element):
        return None if next(number) in gone else network
    if not isinstance(network, Series | Parallel):
        for _ in network.elements():
            next(number)
        return network
    parts = [_without(part, gone, number) for part in network.children]
    kept = [part for part in parts if part is not None]
    if not kept:
        return None
    return (series if isinstance(network, Series) else parallel)(*kept)
