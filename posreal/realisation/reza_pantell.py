"""The bridge of Reza, Pantell, Fialkow and Gerst [Reza1954] [Pantell1954] [FialkowGerst1955].

Bott–Duffin with one energy-storing element less a cycle. Take frequency in κ and impedance in Z(κ), so that
Bott and Duffin's network is, with 1/R = α s/(s² + x) + W, between its nodes P, u, m, t, Q:

    P–m:  W | inerter 1 | (inerter α/x  P–u  +  spring α  u–m)
    m–Q:  spring 1 | ((spring x/α | inerter 1/α)  m–t  +  dual of W  t–Q)

Ask which springs and inerters between these nodes give every node the velocity it has there: force
balance at u, m and t leaves a family of solutions, and at its end one element is gone and all are
positive, for every α and x:

    P–m:  W | (inerter α/x + α/(1+α)  P–u  +  spring α (1 + x/(1+α))  u–m)         m–Q:  spring 1
    P–t:  inerter 1/(1+α)            m–t:  spring x/(1+α)                         t–Q:  dual of W
"""

from __future__ import annotations

from flint import fmpq

from posreal.admittance import Rational
from posreal.network import Network, bridge, parallel, series
from posreal.realisation.bott_duffin import richards
from posreal.realisation.elements import dual, inerter, scaled, spring
from posreal.realisation.multiprecision import Long, susceptance_slope
from posreal.realisation.preamble import Recurse


def cycle(y: Rational, x: fmpq, arithmetic: Long, recurse: Recurse) -> Network:
    """A network for the admittance of a minimum function that vanishes in Re at ω₀² = x."""
    z = y.inverse()
    if susceptance_slope(z, x) < 0:
        return dual(cycle(z, x, arithmetic, recurse))
    size, kappa, alpha, w = richards(z, x, arithmetic)
    z_kappa = kappa * size
    b, k = 1 / (kappa * z_kappa), kappa / z_kappa  # what inerter 1 and spring 1 stand for
    a, x = alpha / kappa, x / kappa**2
    rest = recurse(w)
    leg = series(inerter(b * (a / x + a / (1 + a))), spring(k * a * (1 + x / (1 + a))))
    return bridge(
        parallel(leg, scaled(rest, 1 / z_kappa)),
        inerter(b / (1 + a)),
        spring(k * x / (1 + a)),
        spring(k),
        scaled(dual(rest), 1 / z_kappa),
    )
