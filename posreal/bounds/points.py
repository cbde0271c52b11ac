"""From a figure to the best certificate for it: which form, where the points lie, how many of them.

Mean squares are bounded by values at distinct points (:mod:`value_form`), which :mod:`windows` chooses. Sums, peaks,
few points and places that somebody gives are bounded on the space of repeated points (:mod:`certificate`), as follows.

The bound never falls when a point is added, and how fast it rises depends on where the points lie. The scan tries every
octave of the vehicle's band with few points, half octaves around the best, and from there looks for three places, taken
in turn: a frequency twice and between them a pair, which is the better the more the vehicle's energy sits in two bands.
What a place is worth is computed cheaply: by the convex program for one passive port, and by `device_at_points` for all
else, where the semidefinite program is left to the end. The scan does not depend on how many points are asked for, and
the few best places compete at that number, or at as many as that takes little time for, so the bound that comes out
does not fall with that number either.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from flint import arb, fmpq

from posreal.admittance import Rational, state_space
from posreal.admittance.exact import rounded, to_float, to_fmpq
from posreal.admittance.positive_real import is_positive_real
from posreal.admittance.roots import precision
from posreal.bounds import ascent, device_at_points, one_passive_port, pick, shor_dual
from posreal.bounds.certificate import NotProven, proven
from posreal.bounds.figure import SQUARES, BoundedFigure, enclosed
from posreal.bounds.interpolation_space import Point, in_words, width
from posreal.bounds.objectives import objective
from posreal.bounds.ritz import Attained, best_device
from posreal.bounds.sampled import Sampled
from posreal.bounds.value_form import ValueCertificate, real_form, real_rows
from posreal.bounds.values import sampled_values
from posreal.bounds.windows import Windows, best_windows
from posreal.errors import BadInput, PosrealError
from posreal.plant.plant import close

Array = np.ndarray
Progress = Callable[[str], None]

PLAIN, LIFTED, VALUE = "plain", "lifted", "value"
SIZES = {
    PLAIN: (41, 71, 101, 141),
    "lifted, one loop": (31, 51, 71, 101),
    LIFTED: (21, 31, 37, 41),
    VALUE: (61, 101, 141, 201),
    "value, several loops": (51, 81, 121, 161),
}
"""Dimension of the space at efforts 0 to 3; a pair of points counts twice."""
_SCAN = {PLAIN: (25, 41), "lifted, one loop": (15, 25), LIFTED: (15, 31)}
"""The dimension in the scan of octaves, and in the search for three places."""
_LAST = 51  # and the largest at which the last few compete
_QUICK, _QUICK_LAST = (15, 21), 31  # the same, at most, for somebody who chose the dimension and does not want to wait
_BELOW, _ABOVE = (0.4, 0.7), (1.4, 2.5, 4.0)  # where frequency and pair start, relative to the best single place
_STEP = 1.4  # factor by which the search moves a frequency or a damping ratio
_WORTHWHILE = 1e-4  # relative gain for which it does
ORDERS = (41, 81, 121, 161)
"""Order of the device that shows what can be reached, at efforts 0 to 3."""
_FEW = 25  # points below which three places in turn prove more than windows
_SHAPED, _SLOPE = 51, -0.7  # points that shape a device's poles; how T falls with frequency where nothing is searched
_CLOSE = (1e-6, 1e-5, 1e-4, 1e-3)  # how near its own optimum a certificate in closed form is looked for
_FALLS_SHORT = 2e-3  # relative to what the points allow; then a certificate is looked for without restriction

Place = float | tuple[float, float]
"""Where points lie: a frequency, or natural frequency and damping ratio of a pair."""


@dataclass(frozen=True)
class Certificate:
    """The numbers that prove a bound: see :mod:`certificate`.

    Attributes
    ----------
    points : tuple of Point
        a or (ω, ζ); frequencies in rad/s.
    damper : fmpq
        c0, N s/m.
    factor : (r m, p)
        C, zero above its diagonal.
    multipliers : (r (r − 1)/2, m)
        μ.
    functional : array
        u, or P over Q, for a sum or a peak; empty for squares.
    """

    points: tuple[Point, ...]
    damper: fmpq
    factor: Array
    multipliers: Array
    functional: Array

    def lower_bound(self, figure: BoundedFigure) -> float:
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


def passive(figure: BoundedFigure) -> bool:
    """Whether every loop's port is passive, decided exactly."""
    return all(is_positive_real(figure.mobility(port)) for port in figure.loops)


def choose_form(figure: BoundedFigure, wanted: str = "auto", *, places: bool = False, size: int | None = None) -> str:
    """The value form for mean squares where the places are free and many; else plain for one passive port, and lifted.

    Raises
    ------
    BadInput
        If the plain form is wanted where it does not apply.
    """
    if wanted not in ("auto", PLAIN, LIFTED, VALUE):
        raise BadInput(f"form {wanted!r} is not known; accepted are auto, plain, lifted or value")
    if wanted == VALUE and (places or figure.combine != SQUARES):
        raise BadInput("the value form is for mean squares, and chooses its own points: leave omega0 out")
    if wanted in (LIFTED, VALUE) and figure.combine == SQUARES:
        return wanted
    if wanted == "auto" and not places and figure.combine == SQUARES and (size is None or size >= _FEW):
        return VALUE
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


def size_for(figure: BoundedFigure, form: str, effort: int) -> int:
    """Number of points at an effort of 0 to 3."""
    return SIZES[_row(figure, form)][effort]


def best_place(
    figure: BoundedFigure, form: str, size: int, progress: Progress = lambda text: None, *, quick: bool = False
) -> tuple[Place, ...]:
    """The best places for `size` points, rad/s; a quick search costs a quarter and proves some 0.04 % less.

    Raises
    ------
    BadInput
        If nothing is proven at any.
    """
    few, more = _SCAN[_row(figure, form)]
    last = _LAST
    if quick:
        few, more, last = min(few, _QUICK[0]), min(more, _QUICK[1]), _QUICK_LAST
    known: dict[tuple[tuple[Place, ...], int], float] = {}

    def worth(where: tuple[Place, ...], dimension: int) -> float:
        if (where, dimension) not in known:
            progress(f"bound: looking at {in_words(exactly(where))}")
            try:
                data = Sampled.of(enclosed(figure, cycled(where, dimension), _damper(figure, cycled(where, dimension))))
                known[where, dimension] = _promised(figure, form, data)
            except PosrealError:  # a pole of the vehicle lies there
                known[where, dimension] = 0.0
        return known[where, dimension]

    slowest, fastest = _band(figure)
    values: list[float] = []
    octaves = [_short_number(slowest * 2.0**k) for k in range(math.ceil(math.log2(fastest / slowest)) + 1)]
    for omega in octaves:
        values.append(worth((omega,), few))
        if values[-1] < 0.8 * max(values):
            break
    centre = octaves[int(np.argmax(values))]
    single = max(
        (centre, _short_number(centre * 2**0.5), _short_number(centre * 2**-0.5)), key=lambda a: worth((a,), few)
    )
    starts = [[single * below, single * above, 0.5] for below in _BELOW for above in _ABOVE]
    triple = max(starts, key=lambda start: worth(_in_turn(start), more))
    moved = True
    while moved:
        moved = False
        for k, step in product(range(3), (_STEP, 1 / _STEP)):
            other = [value * step if k == l else value for l, value in enumerate(triple)]
            inside = slowest <= min(other[:2]) and max(other[:2]) <= fastest
            if inside and worth(_in_turn(other), more) > worth(_in_turn(triple), more) * (1 + _WORTHWHILE):
                triple, moved = other, True
    searched = sorted((where for where, size in known if size == more), key=lambda where: -worth(where, more))
    final = min(size, last)
    best = max([(single,), *searched[:4]], key=lambda where: worth(where, final))
    if worth(best, final) == 0:
        raise BadInput("nothing is proven at any place for the points, so no bound is known for this figure")
    return best


def _in_turn(triple: Sequence[float]) -> tuple[Place, ...]:
    """A frequency, a pair, and the frequency again."""
    a, omega, zeta = map(_short_number, triple)
    return a, (omega, zeta), a


def _short_number(value: float) -> float:
    return float(f"{value:.3g}")


def _promised(figure: BoundedFigure, form: str, data: Sampled) -> float:
    """What points prove about J, nearly; 0 where nothing."""
    if form == PLAIN:
        return one_passive_port.solve(data, objective(figure.combine, data), tolerance=1e-3).value
    return device_at_points.solve(data, tolerance=1e-3).value


def cycled(where: Sequence[Place], size: int) -> tuple[Point, ...]:
    """Points for a space of dimension `size`, or one less where a pair does not fit, taking the places in turn."""
    exact = exactly(where)
    points: list[Point] = []
    room = size
    while room > 0:
        point = exact[len(points) % len(exact)]
        room -= width(point)
        if room >= 0:
            points.append(point)
    return tuple(points)


def exactly(where: Sequence[Place]) -> list[Point]:
    """Places as the decimal numbers that they print as."""
    return [
        (to_fmpq(repr(place[0])), to_fmpq(repr(place[1]))) if isinstance(place, tuple) else to_fmpq(repr(float(place)))
        for place in where
    ]


def certify(
    figure: BoundedFigure,
    form: str,
    points: Sequence[Point],
    *,
    tolerance: float | None = None,
    progress: Progress | None = None,
) -> Certificate:
    """The best certificate at some points."""
    damper = _damper(figure, points)
    data = Sampled.of(enclosed(figure, points, damper))
    if form == PLAIN:
        solution = one_passive_port.solve(data, objective(figure.combine, data), tolerance=tolerance or 1e-8)
        factor, mu, functional = _triangular(solution.Z), np.zeros((0, len(data.F))), solution.functional
    else:
        dual = _lifted(data, tolerance or 1e-5, progress)
        factor, mu, functional = dual.C, dual.mu, np.zeros((0, 0))
    return Certificate(tuple(points), damper, _short(factor), _short(mu), _short(functional))


def certify_values(
    figure: BoundedFigure, size: int, progress: Progress = lambda text: None, *, quick: bool = False
) -> ValueCertificate:
    """Points by windows, and a certificate there: in closed form for one loop (:mod:`pick`), else by :mod:`ascent`.

    Raises
    ------
    BadInput
        If nothing is proven at them.
    """
    band = _band(figure)
    octaves = exactly(tuple(np.geomspace(*band, 12)))
    points = best_windows(figure, size, band, _damper(figure, octaves), progress, quick=quick).points(size)
    damper = _damper(figure, points)
    seen = sampled_values(figure, points, damper)
    if len(figure.loops) > 1:
        climbed = ascent.climb(seen, progress)
        factor = _triangular(real_form(climbed.Z, points, len(figure.loops)))
        mu = real_rows(climbed.mu.T, points).T
        return ValueCertificate(points, damper, _short(factor), _short(mu), np.zeros((0, 0)))
    best: tuple[float, ValueCertificate] | None = None
    for tolerance in _CLOSE:
        found = pick.solve(seen, tolerance=tolerance)
        try:
            factor = _triangular(real_form(found.inverse / found.t, points, 1))
            certificate = ValueCertificate(points, damper, _short(factor), np.zeros((0, seen.size)), np.zeros((0, 0)))
            proof = certificate.lower_bound(figure)
        except (NotProven, np.linalg.LinAlgError):
            continue
        best = max(best or (0.0, certificate), (proof, certificate), key=lambda pair: pair[0])
        if best[0] > found.value * (1 - 2 * tolerance):
            break
    if best is not None and best[0] > 0:
        return best[1]
    raise BadInput("nothing is proven at these points, so no bound is known for this figure")


def _triangular(Z: np.ndarray) -> np.ndarray:
    """C, lower triangular, with C Cᵀ = Z; what rounding has made of eigenvalues that are next to 0 is 0."""
    try:
        return np.asarray(np.linalg.cholesky(Z))
    except np.linalg.LinAlgError:
        values, vectors = np.linalg.eigh(Z)
        return np.asarray(np.linalg.qr((vectors * np.sqrt(np.clip(values, 0.0, None))).T)[1].T)


def attain(figure: BoundedFigure, size: int) -> Attained | None:
    """The best passive device of high order, at most `size`, found for a mean square; None if none is."""
    if figure.combine != SQUARES:
        return None
    band = _band(figure)
    knots = np.geomspace(*band, 8)
    c0 = _damper(figure, exactly(tuple(np.geomspace(*band, 12))))
    shapes = [
        Windows(knots, _SLOPE * np.log(knots), 0.0),
        best_windows(figure, min(size, _SHAPED), band, c0, quick=True),
    ]
    found = [best_device(figure, shapes, order, c0) for order in sorted({min(size, ORDERS[0]), size})]
    return min((one for one in found if one is not None), key=lambda one: one.value, default=None)


def _lifted(data: Sampled, tolerance: float, progress: Progress | None) -> shor_dual.LiftedSolution:
    """The dual on the kernel that the best device at the points leaves, and without restriction if that falls short."""
    guide = device_at_points.solve(data)
    try:
        found = shor_dual.solve(data, guide.kernel, tolerance=tolerance, progress=progress)
    except BadInput:
        return shor_dual.solve(data, tolerance=tolerance, progress=progress)
    rows, columns = guide.kernel.shape
    if columns == rows or found.value > (guide.value * (1 - _FALLS_SHORT)) ** 2:
        return found
    whole = shor_dual.solve(data, tolerance=tolerance, progress=progress)
    return max(found, whole, key=lambda solution: solution.value)


def _row(figure: BoundedFigure, form: str) -> str:
    if form == VALUE and len(figure.loops) > 1:
        return "value, several loops"
    return "lifted, one loop" if form == LIFTED and len(figure.loops) == 1 else form


def _short(numbers: Array) -> Array:
    """Twelve significant digits: the certificate is measured as it is stored."""
    return np.array([float(f"{value:.11e}") for value in numbers.ravel()]).reshape(numbers.shape)


def _damper(figure: BoundedFigure, points: Sequence[Point]) -> fmpq:
    """c0 that matches the ports at the points: about 1/P there, two digits."""
    logs = []
    for port in figure.loops:
        P = figure.mobility(port)
        for point in {point[0] if isinstance(point, tuple) else point for point in points}:
            if P.d(point) != 0 and P.n(point) != 0:
                logs.append(math.log(abs(to_float(P.n(point) / P.d(point)))))
    return rounded(to_fmpq(math.exp(-sum(logs) / len(logs))), 2) if logs else fmpq(1)


def _band(figure: BoundedFigure) -> tuple[float, float]:
    """The slowest and the fastest mode of the vehicle with a matched damper for device, rad/s."""
    plant, beside = figure.plant, figure.mounting.beside
    inside = Rational.zero() if beside is None else beside
    poles = close(plant, {plant.groups[0]: state_space(inside)}, shaped=False).poles()
    sizes = np.abs(poles)
    sizes = sizes[sizes > 1e-6 * sizes.max()]
    return float(sizes.min()) / 2, float(sizes.max()) * 2


__all__ = [
    "LIFTED",
    "ORDERS",
    "PLAIN",
    "VALUE",
    "Certificate",
    "Place",
    "attain",
    "best_place",
    "certify",
    "certify_values",
    "choose_form",
    "cycled",
    "exactly",
    "passive",
    "size_for",
]
