"""Biquadratics with the fewest elements [JiangSmith2011] [MorelliSmith2019].

A regular one (least Re Y or Re 1/Y at 0 or ∞) comes apart in the Foster preamble: two springs or
inerters, at most three dampers. A non-regular one may be one of the five-element networks that reach
beyond the regular ones: the bridges of spring, inerter and three dampers, or the networks with three
springs and inerters in which a common factor drops out. Their values are found by fitting and then
sharpened to an exact match; if there is none, no five elements serve.
"""

from __future__ import annotations

import numpy as np

from posreal.admittance import Rational, is_regular
from posreal.network import Network, parse
from posreal.realise.fit import fitted, sharpened
from posreal.realise.long import Long
from posreal.realise.preamble import Recurse, Synthesis
from posreal.realise.proof import corners
from posreal.realise.refusal import DoesNotApply

QUARTETS = (
    ("{1-2: c1, 1-3: c2, 2-3: b, 2-0: c3, 3-0: k}", "{1-2: b, 1-3: c1, 2-3: k, 2-0: c2, 3-0: c3}"),
    (
        "(b1 | c1) + k | b2 + c2",
        "(c1 | k1) + b | c2 + k2",
        "(c1 + k1 | b) + (c2 | k2)",
        "(b1 + c1 | k) + (b2 | c2)",
    ),
    ("{1-2: c1, 1-3: k1, 2-3: b, 2-0: k2, 3-0: c2}", "{1-2: b1, 1-3: c1, 2-3: k, 2-0: c2, 3-0: b2}"),
)
CLOSE = 1e-6  # misfit of a fit worth sharpening
POINTS = 30


def fewest(y: Rational, arithmetic: Long) -> Network:
    """The fewest-element network of a biquadratic.

    Raises
    ------
    DoesNotApply
        If the degree is not two, or no five-element network was found.
    """
    if y.degree != 2:
        raise DoesNotApply(f"This method serves functions of degree 2 and this one has degree {y.degree}.")
    if is_regular(y):
        return Synthesis(_no_cycle, arithmetic)(y)
    low, high = corners(y)
    omega = np.geomspace(low * 5, high / 5, POINTS)
    for form in (form for quartet in QUARTETS for form in quartet):
        network, misfit = fitted(parse(form), y, omega, starts=12)
        if misfit < CLOSE:
            exact = sharpened(network, y)
            if exact is not None:
                return exact
    raise DoesNotApply("This biquadratic is not regular and no five-element network was found; use reza-pantell.")


def _no_cycle(y: Rational, x: object, arithmetic: Long, recurse: Recurse) -> Network:
    raise DoesNotApply("A minimum function is left inside, which a regular biquadratic does not have.")
