"""Networks of real elements (:mod:`posreal.real_elements`): each element with what comes with it.

That is an exact substitution of every leaf of a network by a small network, so that an admittance, its derivative and a
proof are those of any other network; ∂Y/∂log θ of the element itself is

    Y₀ (E/(E + Y₀ + c_par))²,      Y₀ = k/s, c or b s,      E = k_end/s + c_end.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posreal.network.tree import Damper, Element, Network, Spring, parallel, series
from posreal.real_elements import Parasitics, RealElements

Array = NDArray[Any]

_LONGEST = 25  # letters of an element's name that the names of what comes with it keep
_KINDS = "kcb"


def _around(kind: Parasitics, element: Element, name: str) -> Network:
    """The element with what comes with it, which is named after it."""
    assert isinstance(element, Network)
    own, after = element.altered(element.value, name), name[:_LONGEST]
    assert isinstance(own, Network)
    whole: Network = own
    if kind.parallel_damping:
        whole = parallel(whole, Damper(kind.parallel_damping, f"c_par_{after}"))
    if kind.has_end:
        end: Network = Spring(kind.end_stiffness, f"k_end_{after}")
        if kind.end_damping:
            end = parallel(end, Damper(kind.end_damping, f"c_end_{after}"))
        whole = series(whole, end)
    return whole


def made(network: Network, elements: RealElements | None, *, keep: Collection[str] = ()) -> Network:
    """The network with each element replaced by what is bought for it.

    Parameters
    ----------
    network : Network
        With values or without.
    elements : RealElements or None
        None: ideal ones.
    keep : collection of str
        Names of elements that stay as they are, such as a vehicle's own spring.

    Examples
    --------
    >>> from posreal.network import parse
    >>> from posreal.real_elements import RAIL
    >>> str(made(parse("c=2e4 + b=300"), RAIL))
    'c=20000 + k_end_c=5000000 + (b=300 | c_par_b=1000) + k_end_b=5000000'
    """
    if elements is None:
        return network
    parts: list[Any] = []
    for element, name in zip(network.elements(), network.names, strict=True):
        ideal = name in keep or element.letter not in _KINDS or elements.of(element.letter).is_nothing
        parts.append(
            element.altered(element.value, name) if ideal else _around(elements.of(element.letter), element, name)
        )
    return network._rebuilt(parts)


def companions(network: Network, elements: RealElements | None, *, keep: Collection[str] = ()) -> dict[str, float]:
    """The names and values of what comes with the elements of a network: SI units."""
    if elements is None:
        return {}
    full = made(network, elements, keep=keep)
    values = zip(full.names, full.elements(), strict=True)
    own = set(network.names)
    return {name: float(element.exact) for name, element in values if name not in own}


def leaf(kind: Parasitics, own: Array, s: Array) -> tuple[Array, Array]:
    """The admittance of a real element and its share of the ideal one's slope.

    Parameters
    ----------
    kind : Parasitics
    own : (…, N) complex
        Y₀ at the points.
    s : (N,) complex

    Returns
    -------
    Y, dY/dY₀ : (…, N) complex
    """
    beside = own + kind.parallel_damping
    if not kind.has_end:
        return beside, np.ones_like(beside)
    share = 1 / (1 + beside / (kind.end_stiffness / s + kind.end_damping))
    return beside * share, share * share
