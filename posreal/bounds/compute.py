"""Compute a bound: the certificate is found in floats, proven in balls, and only what is proven is claimed."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence

from posreal.admittance import Rational
from posreal.bounds import points
from posreal.bounds.figure import BoundedFigure, figure
from posreal.bounds.interpolation_space import in_words
from posreal.bounds.result import BelowBound, Bound
from posreal.bounds.value_form import ValueCertificate
from posreal.errors import BadInput, shown
from posreal.numerics.threads import one_thread
from posreal.specification.design import Design
from posreal.specification.named import as_problem
from posreal.specification.problem import Problem

_MOST_POINTS = 201
_LEAST, _MOST = 1e-6, 1e9  # of a frequency, rad/s
_LEFT = 1e-10  # relative; another machine may round the vehicle's matrices otherwise


@one_thread
def bound(
    subject: Problem | BoundedFigure | str,
    *,
    effort: int = 1,
    L: int | None = None,
    omega0: float | Sequence[points.Place] | None = None,
    weights: Mapping[str, float] | None = None,
    best: Design | Rational | float | None = None,
    form: str = "auto",
    both_sides: bool = False,
    progress: Callable[[str], None] | None = None,
) -> Bound:
    """A proven lower bound on a mean-square figure over all positive-real devices.

    Parameters
    ----------
    subject : Problem or Figure
        A problem or the name of one, whose objective is bounded over the whole band; or a figure of one's own plant.
    effort : int
        0 to 3: how many points, a few seconds to a few minutes.
    L : int, optional
        L + 1 points instead, a pair counted as two; with one point repeated, L is the order of the truncated Taylor
        series.
    omega0 : float or sequence of places, optional
        Where the points lie, taken in turn; searched for if not given, quickly where L is. A place is a frequency,
        rad/s, or natural frequency and damping ratio of a pair of points, which counts as two.
    weights : mapping of metric to float, optional
        Bound √(Σ weight · metric²) instead of the problem's objective.
    best : Design, Rational (a port admittance) or float, optional
        What to show beside the bound; a float must be a figure of the bound's own kind.
    form : {"auto", "plain", "lifted", "value"}
    both_sides : bool
        Also look for a passive device of high order that comes close (mean squares only): with it the best possible is
        known to lie in an interval.
    progress : function of str, optional

    Returns
    -------
    Bound
        Already checked.

    Raises
    ------
    BadInput
        If no valid bound is known for the problem, in a sentence that says why.
    BelowBound
        If `best` is below the bound, which would be an error in the program.

    Examples
    --------
    >>> from posreal import problem
    >>> bound(problem("quarter-car"), L=20, omega0=20).value > 1.40
    True
    """
    begun = time.monotonic()
    say = progress or (lambda text: None)
    if isinstance(subject, BoundedFigure):
        about, named = subject, None
        if weights is not None:
            raise BadInput("a figure brings its own weights; give weights with a problem only")
    else:
        named = as_problem(subject)
        about = figure(named, weights)
    places = None if omega0 is None else _places(omega0)
    chosen = points.choose_form(about, form, places=places is not None, size=None if L is None else L + 1)
    size = _size(about, chosen, effort, L)
    certificate: points.Certificate | ValueCertificate | None = None
    if chosen == points.VALUE:
        try:
            certificate = points.certify_values(about, size, say, quick=L is not None)
        except BadInput:
            if form != "auto":
                raise
            chosen = points.choose_form(about, form, places=True)
            size = _size(about, chosen, effort, L)
    if certificate is None:
        where = places or points.best_place(about, chosen, size, say, quick=L is not None)
        say(f"bound: {size} points at {in_words(points.exactly(where))}")
        certificate = points.certify(about, chosen, points.cycled(where, size), progress=progress)
    say("bound: checking the certificate")
    value = math.nextafter(certificate.lower_bound(about) * (1 - _LEFT), 0.0)
    attained = None
    if both_sides:
        say("bound: looking for a passive device of high order")
        attained = points.attain(about, points.ORDERS[effort] if L is None else min(max(L + 1, 12), points.ORDERS[1]))
        if attained is not None and attained.value < value:
            raise BelowBound(f"a device of high order has {attained.value:.10g}, below the proven bound {value:.10g}")
    found = Bound(
        value,
        about,
        certificate,
        chosen,
        points.passive(about),
        named,
        () if weights is None else tuple((name, float(weight)) for name, weight in weights.items()),
        seconds=time.monotonic() - begun,
        attained=attained,
    )
    return found.beside(best)


def _size(about: BoundedFigure, form: str, effort: int, L: int | None) -> int:
    if L is None:
        if effort not in range(4):
            raise BadInput(f"effort {effort} is not known; accepted are 0, 1, 2 or 3")
        return points.size_for(about, form, effort)
    if not 0 <= L < _MOST_POINTS:
        raise BadInput(f"L is {L}; give 0 to {_MOST_POINTS - 1}")
    return L + 1


def _places(omega0: float | Sequence[points.Place]) -> tuple[points.Place, ...]:
    places = (omega0,) if isinstance(omega0, int | float) else tuple(omega0)
    numbers = [value for place in places for value in (place if isinstance(place, tuple) else (place,))]
    if not places or not all(_LEAST <= value <= _MOST for value in numbers):
        raise BadInput(
            f"omega0 is {shown(omega0)}; give frequencies from {_LEAST:g} to {_MOST:g} rad/s, or pairs of frequency "
            "and damping ratio"
        )
    return places
