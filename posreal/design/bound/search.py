"""From a figure to the best certificate for it: which form, where the points lie, how many of them.

The bound never falls when a point is added, and how fast it rises depends on where the points lie: near the modes that
carry the energy. The scan tries every octave of the vehicle's band with few points, half octaves around the best, there
also points spread over a factor of three, and the few best of all these once more with more points. It does not depend
on how many points are asked for in the end, and the places that it keeps compete at that number, so the bound that
comes out does not fall with that number either.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, fmpq

from posreal.admittance import Rational, state_space
from posreal.admittance.exact import rounded, to_float, to_fmpq
from posreal.admittance.positive_real import is_positive_real
from posreal.design.bound import lifted, plain
from posreal.design.bound.certificate import proven
from posreal.design.bound.objectives import objective
from posreal.design.bound.ports import SQUARES, Figure, enclosed
from posreal.design.bound.sampled import Sampled
from posreal.design.bound.space import precision
from posreal.errors import BadInput, PosrealError
from posreal.vehicle.plant import close

Array = np.ndarray
Progress = Callable[[str], None]

PLAIN, LIFTED = "plain", "lifted"
SIZES = {PLAIN: (41, 71, 101, 141), "lifted, one loop": (17, 25, 33, 41), LIFTED: (13, 21, 25, 31)}
"""Number of points at efforts 0 to 3: about 1, 3, 10 and 30 seconds, the last form some times that."""
_SCAN = {PLAIN: (25, 41, 1), "lifted, one loop": (15, 25, 2), LIFTED: (11, 15, 3)}
"""Number of points in the scan, and for the few best places of it once more; how many places are kept."""
_SPREAD = (3**-0.5, 3**0.5)


@dataclass(frozen=True)
class Certificate:
    """The numbers that prove a bound: see :mod:`certificate`.

    Attributes
    ----------
    points : tuple of fmpq, rad/s
    damper : fmpq
        c0, N s/m.
    factor : (r m, r m)
        Lower-triangular C.
    multipliers : (r (r − 1)/2, m)
        μ.
    functional : array
        u, or P over Q, for a sum or a peak; empty for squares.
    """

    points: tuple[fmpq, ...]
    damper: fmpq
    factor: Array
    multipliers: Array
    functional: Array

    def lower_bound(self, figure: Figure) -> float:
        """J from below, rigorously: a float that is not above what the balls prove.

        Raises
        ------
        NotProven
            If the numbers prove nothing for this figure.
        """
        digits = 20
        while True:
            found = enclosed(figure, self.points, self.damper, digits=digits)
            with precision(64 + 6 * digits):
                ball = proven(found, self.factor, self.multipliers, self.functional, figure.combine)
                if ball.rad() < 1e-12 * abs(ball.mid()) or digits > 500:
                    low = ball.lower() if ball.lower() > 0 else arb(0)
                    return math.nextafter(float((low.sqrt() if figure.combine == SQUARES else low).lower()), 0.0)
            digits *= 2


def passive(figure: Figure) -> bool:
    """Whether every loop's port is passive, decided exactly."""
    return all(is_positive_real(figure.mobility(port)) for port in figure.loops)


def choose_form(figure: Figure, wanted: str = "auto") -> str:
    """The plain form for one passive port, the lifted one for all else.

    Raises
    ------
    BadInput
        If the plain form is wanted where it does not apply.
    """
    if wanted == LIFTED and figure.combine == SQUARES:
        return LIFTED
    if wanted not in ("auto", PLAIN, LIFTED):
        raise BadInput(f"form {wanted!r} is not known; accepted are auto, plain or lifted")
    reason = ""
    if len(figure.loops) > 1:
        reason = f"{len(figure.loops)} loops share the device"
    elif not passive(figure):
        reason = "the mobility of the port is not positive real"
    if reason and figure.combine != SQUARES:
        raise BadInput(f"a bound on a sum or a peak needs one passive port, and here {reason}; bound mean squares")
    if reason and wanted == PLAIN:
        raise BadInput(f"the plain form needs one passive port, and here {reason}; use the lifted form")
    return LIFTED if reason else PLAIN


def size_for(figure: Figure, form: str, effort: int) -> int:
    """Number of points at an effort of 0 to 3."""
    return SIZES[_row(figure, form)][effort]


def places(figure: Figure, form: str, progress: Progress = lambda text: None) -> list[tuple[float, ...]]:
    """The best places for the points, rad/s, by what few of them prove there."""
    few, more, kept = _SCAN[_row(figure, form)]
    known: dict[tuple[float, ...], float] = {}

    def promised(where: tuple[float, ...], size: int) -> float:
        progress(f"bound: looking at {' and '.join(f'{omega:g}' for omega in where)} rad/s")
        try:
            return certify(figure, form, cycled(where, size), tolerance=1e-3)[1]
        except PosrealError:  # a pole of the vehicle lies there, or no certificate starts there
            return 0.0

    def height(centre: float, spread: Sequence[float] = (1.0,)) -> float:
        where = tuple(float(f"{centre * factor:.3g}") for factor in spread)
        if where not in known:
            known[where] = promised(where, few)
        return known[where]

    slowest, fastest = _band(figure)
    octaves = [slowest * 2.0**k for k in range(math.ceil(math.log2(fastest / slowest)) + 1)]
    values: list[float] = []
    for omega in octaves:
        values.append(height(omega))
        if values[-1] < 0.8 * max(values):
            break
    centre = octaves[int(np.argmax(values))]
    centre = max((centre, centre * 2**0.5, centre * 2**-0.5), key=height)
    height(centre, _SPREAD)
    shortlist = sorted(known, key=lambda where: -known[where])[:4]
    again = {where: promised(where, more) for where in shortlist}
    best = [where for where in sorted(again, key=lambda where: -again[where]) if again[where] > 0]
    if not best:
        raise BadInput("no certificate was found at any expansion point, so no bound is known for this figure")
    return best[:kept]


def cycled(where: Sequence[float], size: int) -> tuple[fmpq, ...]:
    """So many points, taking the places in turn."""
    exact = [to_fmpq(repr(float(omega))) for omega in where]
    return tuple(exact[k % len(exact)] for k in range(size))


def certify(
    figure: Figure,
    form: str,
    points: Sequence[fmpq],
    *,
    tolerance: float | None = None,
    progress: Progress | None = None,
) -> tuple[Certificate, float]:
    """The best certificate at some points, and the bound on J it promises in floats."""
    damper = _damper(figure, points)
    found = enclosed(figure, points, damper)
    data = Sampled.of(found)
    if form == PLAIN:
        goal = objective(figure.combine, data)
        solution = plain.solve(data, goal, tolerance=tolerance or 1e-8)
        Z, mu, functional = solution.Z, np.zeros((0, len(points))), solution.functional
        promised = solution.value
    else:
        dual = lifted.solve(data, tolerance=tolerance or 1e-5, progress=progress)
        Z, mu, functional = dual.Z, dual.mu, np.zeros((0, 0))
        promised = math.sqrt(max(dual.value, 0.0))
    return Certificate(tuple(points), damper, _short(np.linalg.cholesky(Z)), _short(mu), _short(functional)), promised


def _row(figure: Figure, form: str) -> str:
    return "lifted, one loop" if form == LIFTED and len(figure.loops) == 1 else form


def _short(numbers: Array) -> Array:
    """Twelve significant digits: the certificate is measured as it is stored."""
    return np.array([float(f"{value:.11e}") for value in numbers.ravel()]).reshape(numbers.shape)


def _damper(figure: Figure, points: Sequence[fmpq]) -> fmpq:
    """c0 that matches the ports at the points: about 1/P there, two digits."""
    logs = []
    for port in figure.loops:
        P = figure.mobility(port)
        for point in set(points):
            if P.d(point) != 0 and P.n(point) != 0:
                logs.append(math.log(abs(to_float(P.n(point) / P.d(point)))))
    return rounded(to_fmpq(math.exp(-sum(logs) / len(logs))), 2) if logs else fmpq(1)


def _band(figure: Figure) -> tuple[float, float]:
    """The slowest and the fastest mode of the vehicle with a matched damper for device, rad/s."""
    plant, beside = figure.plant, figure.mounting.beside
    inside = Rational.zero() if beside is None else beside
    poles = close(plant, {plant.groups[0]: state_space(inside)}, shaped=False).poles()
    sizes = np.abs(poles)
    sizes = sizes[sizes > 1e-6 * sizes.max()]
    return float(sizes.min()) / 2, float(sizes.max()) * 2


__all__ = [
    "LIFTED",
    "PLAIN",
    "Certificate",
    "certify",
    "choose_form",
    "cycled",
    "passive",
    "places",
    "size_for",
]
