"""The best positive-real device of an order: matrix inequalities, then local searches, from many starts.

Default combination (``method="auto"``), for order n:

1. the best device of order n − 1, and the best without the spring or inerter that is allowed, found in this same way;
2. where nothing but the figure counts, the matrix inequalities (:mod:`.path_following`) from the best of a hundred
   drawn devices;
3. local searches over devices that are positive real by construction (:mod:`posreal.optimisation`), from what 2
   reached, from 1 as it is and with a weak state added, from the caller's warm devices, and from random starts
   on every face of the order (:mod:`.starts`); then from the best few of these, shaken;
4. the best on each face to full convergence; of these the best, with few digits, exactly positive real
   (:mod:`.rounding`).

Because of 1 the figure never rises with the order or with a freedom: each search begins where a smaller one ended, and
draws its own random numbers, so the smaller one ends where it would have ended by itself.

Why, and what each of them reaches by itself: docs/synthesis.md.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from posreal.admittance import PortHamiltonian, Rational, require
from posreal.admittance.device import Device, as_rational
from posreal.admittance.positive_real_lemma import port_hamiltonian
from posreal.errors import BadInput, Infeasible, listed, shown
from posreal.optimisation.criterion import Candidate
from posreal.optimisation.nonlinear_program import Judge
from posreal.optimisation.scaling import Scale, reference
from posreal.specification.problem import Problem
from posreal.synthesis import path_following, rounding
from posreal.synthesis.incumbent import Incumbent
from posreal.synthesis.lmi_starts import programs
from posreal.synthesis.multistart import local
from posreal.synthesis.result import Step, Synthesis

METHODS = ("auto", "bmi", "ph")
LARGEST_ORDER = 12
ROUNDED = 1e-7  # of the figure: what rounding gains that is a step
FEW = 24  # starts
PROGRAMS = 48  # starts of the matrix inequalities alone, at most
TIGHTER = 1e-7  # relative room that a limit is given where the metric's quadrature missed it
REPAIRS = 3
Progress = Callable[[str], None]


def synthesise(
    problem: Problem,
    order: int,
    *,
    method: str = "auto",
    starts: int | None = None,
    seed: int = 0,
    spring: bool = False,
    inerter: bool = False,
    jobs: int = 1,
    progress: Progress | None = None,
    warm: Sequence[Device] = (),
    settings: path_following.Settings | None = None,
) -> Synthesis:
    """Find the best positive-real device of an order.

    Parameters
    ----------
    problem : Problem
        Any: mean squares, weighted sums, the worst of several figures or operating points, peaks in time and
        largest gains, with limits on other metrics, damping to be kept, and vehicle parameters free.
    order : int
        McMillan degree of the device, 0 to 12.
    method : {"auto", "bmi", "ph"}
        The default combination (see the module's text), the matrix inequalities alone (for mean squares and largest
        gains, their sums, the worst of them and limits on them; free vehicle parameters stay as they are), or local
        searches alone.
    starts : int, optional
        Random starts of the local searches, and as many shaken ones; or starts of the matrix inequalities alone, 48
        at most. By default 24, and 24 more for every order beyond the second, or beyond the first where there are
        constraints.
    seed : int
        Of everything random; the same seed gives the same device, whatever `jobs`.
    spring, inerter : bool
        Allow a spring k/s, an inerter b·s beside the device on top of the order. Not with a bush behind it:
        there, ask for the next order.
    jobs : int
        Local searches that run side by side (joblib); -1 for all cores.
    progress : function of str, optional
        Called with a line at each event worth one.
    warm : sequence of devices
        Positive-real devices of at most the order to start from as well (the best layouts, a lower order).
    settings : path_following.Settings, optional
        Limits of the matrix inequalities' iteration.

    Returns
    -------
    Synthesis
        Interrupting (Ctrl-C) returns the best so far, and says so in its notes.

    Raises
    ------
    BadInput
        For an order, method or problem that is not supported, in a sentence.
    NotPositiveReal
        If a warm device is not.
    Infeasible
        If no device was found that keeps the constraints.
    """
    _validated(problem, order, method, starts, spring, inerter)
    if jobs == 0 or jobs < -1:
        raise BadInput(f"jobs is {jobs}; give the number of processes, or -1 for all cores")
    clock = time.monotonic()
    scale = reference(problem)
    search = Incumbent(Judge(problem, scale), jobs, progress or (lambda text: None))
    plan = _Plan(method, starts, seed, settings or path_following.Settings())
    begun = [Candidate(device, search.judge.nominal) for device in _warm(warm, scale, order, spring, inerter)]
    interrupted = False
    try:
        if method != "bmi" and search.judge.mean_square is None:
            search.progress(f"{problem.objective} is not one mean-square figure: local searches alone")
        # What a wild iterate does to floats is no news: whatever comes out is measured before it is taken.
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for start in begun:
                search.offer("start", start, search.judge.measure(start))
            _best(search, plan, order, spring, inerter, begun)
    except KeyboardInterrupt:
        interrupted = True
        search.note("interrupted: this is the best device found until then")
    if not search.value < np.inf:
        raise Infeasible(
            f"no device of order {order} was found that keeps {listed(problem.constraints)}; "
            "try a higher order, more starts or weaker limits"
        )
    if method != "bmi" and search.landed and not search.agreeing:
        search.note("no independent start ended within 0.1 % of the best, which a shaken one reached")
    return _reported(search, plan, order, (spring, inerter), clock, interrupted)


@dataclass(frozen=True)
class _Plan:
    """How hard to look, and with what."""

    method: str
    starts: int | None
    seed: int
    settings: path_following.Settings

    def count(self, order: int, constrained: bool) -> int:
        """Random starts at an order."""
        if self.starts is not None:
            return self.starts
        return FEW * max(1, order if constrained else order - 1)


def _best(
    search: Incumbent,
    plan: _Plan,
    order: int,
    spring: bool,
    inerter: bool,
    begun: Sequence[Candidate] = (),
    done: dict[tuple[int, bool, bool], Candidate] | None = None,
) -> Candidate:
    """The stages of the module's text; smaller searches first, each once."""
    done = {} if done is None else done
    asked = not done
    rng = np.random.default_rng([plan.seed, order, spring, inerter])
    starts = plan.count(order, search.judge.constrained)
    key = (order, spring, inerter)
    if plan.method == "bmi":
        return _inequalities_alone(search, plan, order, starts, (spring, inerter), begun, rng)
    done[key] = search.best  # so that smaller searches know that they are not what was asked for
    smaller = [
        *([(order - 1, spring, inerter)] if order else []),
        *([(order, False, inerter)] if spring else []),
        *([(order, spring, False)] if inerter else []),
    ]
    for one in smaller:
        if one not in done:
            _best(search, plan, *one, done=done)
    known = [*begun, *(done[one] for one in smaller)] or [search.first]
    reached = None
    judge = search.judge
    if plan.method == "auto" and order > 0 and judge.mean_square is not None and not judge.problem.constraints:
        for fixed in _distinct_parameters([*(c.parameters for c in known), search.judge.nominal]):
            reached = programs(search, order, 1, plan.settings, known, fixed, rng, asked=asked)
            if reached is not None:
                break
    known += [] if reached is None else [reached]
    bases = [found for (lower, *freedom), found in done.items() if lower <= order - 2 and freedom == [spring, inerter]]
    said = "ph" if asked else "lower order"
    done[key] = local(search, order, starts, spring, inerter, known, rng, said, bases)
    return done[key]


def _inequalities_alone(
    search: Incumbent,
    plan: _Plan,
    order: int,
    starts: int,
    freedoms: tuple[bool, bool],
    begun: Sequence[Candidate],
    rng: np.random.Generator,
) -> Candidate:
    spring, inerter = freedoms
    count, nominal = min(starts, PROGRAMS), search.judge.nominal
    programs(search, order, count, plan.settings, begun, nominal, rng, asked=True, spring=spring, inerter=inerter)
    return search.best


def _distinct_parameters(candidates: Sequence[Mapping[str, float]]) -> list[Mapping[str, float]]:
    found: list[Mapping[str, float]] = []
    for values in candidates:
        if values not in found:
            found.append(values)
    return found


def _reported(
    search: Incumbent, plan: _Plan, order: int, freedoms: tuple[bool, bool], clock: float, interrupted: bool
) -> Synthesis:
    """The best device as an exact admittance, measured by the problem's own metrics, and nudged inside its limits."""
    problem, scale = search.judge.problem, search.judge.scale
    for repair in range(REPAIRS + 1):
        device, note = _presented(search, scale)
        parameters = dict(search.best.parameters)
        changed = problem.with_vehicle(parameters)
        metrics = changed.metrics(changed.mounting.port(device))
        missed = {
            c.metric: c.value / metrics[c.metric].value * (1 - TIGHTER)
            for c in problem.constraints
            if c.sense == "<=" and c.margin(metrics) < -1e-9 * abs(c.value) and metrics[c.metric].value > 0
        }
        if not missed or interrupted or repair == REPAIRS:
            break
        # the search's quadrature saw the limit kept: ask for the part that the metric's own wants
        factors = {name: search.judge.shrunk.get(name, 1.0) * factor for name, factor in missed.items()}
        before = search.best, search.value, search.history
        search.judge = replace(search.judge, shrunk={**search.judge.shrunk, **factors})
        search.value, search.history = np.inf, []
        try:
            local(search, order, 1, *freedoms, [search.best], np.random.default_rng(plan.seed), "limits")
        except KeyboardInterrupt:
            interrupted = True
            search.note("interrupted: this is the best device found until then")
        if search.value < np.inf:
            search.history = [step for step in before[2] if step.value > search.history[0].value] + search.history
        else:
            search.best, search.value, search.history = before
            interrupted = True  # nothing to gain from another round
    value = metrics[problem.objective].value
    if note:
        search.note(note)
    for broken in problem.violated(metrics):
        search.note(f"{broken}")
    if value < search.value * (1 - ROUNDED):
        search.history.append(Step("rounding", value))  # onto a face that the search had not reached yet
    if abs(value - search.value) > 1e-3 * value:
        search.note(f"the search saw {search.value:.6g} where the metric is {value:.6g}: see its speed and resonances")
    return Synthesis(
        device=device,
        order=order,
        metrics=metrics,
        value=value,
        parameters=parameters,
        history=tuple(search.history),
        starts=len(search.landed),
        agreeing=search.agreeing,
        seconds=time.monotonic() - clock,
        seed=plan.seed,
        method=plan.method,
        notes=tuple(search.notes),
    )


def _warm(devices: Sequence[Device], scale: Scale, order: int, spring: bool, inerter: bool) -> list[PortHamiltonian]:
    found = []
    for device in devices:
        Y = require(as_rational(device))
        if Y.degree > order + spring + inerter:
            raise BadInput(f"a warm start has degree {Y.degree}; ask for at least that order, or leave it out")
        form = None if Y.is_zero() else port_hamiltonian(scale.from_admittance(Y))
        if form is not None and form.order <= order:
            found.append(form)
    return found


def _presented(search: Incumbent, scale: Scale) -> tuple[Rational, str]:
    """The best device as an exact admittance in few digits, and a note where there are many."""
    judge, best = search.judge, search.best

    def acceptable(Y: Rational) -> bool:
        value = judge.value_of(scale.from_admittance(Y), best.parameters)
        return value <= search.value * (1 + 1e-9) and not _breaks(judge.problem, Y, best.parameters)

    return rounding.presented(scale.admittance(best.device.rational()), acceptable)


def _breaks(problem: Problem, Y: Rational, parameters: Mapping[str, float]) -> bool:
    """Whether a device breaks a constraint, by the problem's own metrics."""
    if not problem.constraints and problem.vehicle.passive:
        return False
    changed = problem.with_vehicle(parameters)
    try:
        return bool(changed.violated(changed.metrics(changed.mounting.port(Y))))
    except Infeasible:
        return True


def _validated(problem: Problem, order: int, method: str, starts: int | None, spring: bool, inerter: bool) -> None:
    if isinstance(order, bool) or not isinstance(order, int) or not 0 <= order <= LARGEST_ORDER:
        raise BadInput(f"order {shown(order)} cannot be synthesised; give a whole number from 0 to {LARGEST_ORDER}")
    if method not in METHODS:
        raise BadInput(f"unknown method {shown(method)}; the methods are {listed(METHODS)}")
    if starts is not None and starts < 1:
        raise BadInput(f"starts is {starts}; give at least 1")
    if (spring or inerter) and problem.mounting.behind is not None:
        raise BadInput("a spring or inerter cannot be added behind a bush; ask for the next order, which has it")
