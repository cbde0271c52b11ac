"""Cauer's ladders [Cauer1926]: a continued fraction about infinity (first form) or about zero (second form).

At infinity a positive-real Y is b s, a constant, or k/s. The inerter b in parallel, the spring k in
series, or the constant, in parallel (Y − c) or in series (1/Y − 1/c), whichever leaves a positive-real
rest, comes off; then the same again. The second form does the same about zero. All steps are rational, so
the ladder is exact.
"""

from __future__ import annotations

from flint import fmpq

from posreal.admittance import Rational, is_positive_real
from posreal.errors import DoesNotApply
from posreal.network import Network, parallel, series
from posreal.realisation.elements import damper, inerter, spring
from posreal.realisation.frequency_inversion import turned_device, turned_network
from posreal.realisation.multiprecision import Long


def from_infinity(y: Rational, arithmetic: Long) -> Network:
    """Cauer's first form.

    Raises
    ------
    DoesNotApply
        If a constant can come off neither side.
    """
    return _ladder(y, "Cauer's first form")


def from_zero(y: Rational, arithmetic: Long) -> Network:
    """Cauer's second form: the first form of Y(1/s), with springs and inerters swapped back.

    Raises
    ------
    DoesNotApply
        If a constant can come off neither side.
    """
    return turned_network(_ladder(turned_device(y), "Cauer's second form"))


def _ladder(y: Rational, form: str) -> Network:
    rungs: list[tuple[str, Network]] = []
    while not y.is_zero():
        excess = y.n.degree() - y.d.degree()
        lead = y.n.leading_coefficient()
        if y.degree == 0:
            rungs.append(("end", damper(lead)))
            break
        if excess == 1:
            rungs.append(("|", inerter(lead)))
            y = y.without(Rational([0, lead]))
        elif excess == -1:
            rungs.append(("+", spring(lead)))
            rest = y.inverse().without(Rational([0, 1 / lead]))
            if rest.is_zero():
                break
            y = rest.inverse()
        else:
            sign, y = _constant_off(y, lead, form)
            rungs.append((sign, damper(lead)))
    ladder: Network | None = None
    for sign, rung in reversed(rungs):
        if ladder is None:
            ladder = rung
            continue
        ladder = parallel(rung, ladder) if sign == "|" else series(rung, ladder)
    if ladder is None:
        raise DoesNotApply("The admittance is zero, so there is no ladder.")
    return ladder


def _constant_off(y: Rational, c: fmpq, form: str) -> tuple[str, Rational]:
    rest = y.without(Rational([c]))
    if is_positive_real(rest):
        return "|", rest
    rest = y.inverse().without(Rational([1 / c]))
    if is_positive_real(rest):
        return "+", rest.inverse()
    raise DoesNotApply(
        f"{form} would need a negative element here; it serves ladders of two kinds, so use bott-duffin."
    )
