"""The best networks of up to N springs, dampers and inerters.

Sizes are searched one after another, from the smallest: the optimum of a network is a start for every larger
one that has it as a limit (:mod:`~posreal.topology.degenerate`). Within a size the topologies are
independent of each other, and so are the random numbers of each, so that the answer does not depend on who
does which, nor on how often the search was interrupted. Topologies that cannot bring anything are left out
beforehand, by proof (:mod:`~posreal.topology.equivalence`), and the most promising ones of each size are
looked at twice.
"""

from __future__ import annotations

import dataclasses
import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from typing import Any

import numpy as np

from posreal.errors import BadInput, plain
from posreal.network.topologies import Form, key, letters, topologies
from posreal.numerics.parallel import Workers, workers
from posreal.numerics.threads import one_thread
from posreal.specification.conditions import conditions
from posreal.specification.named import as_problem, is_named, limited
from posreal.specification.problem import Problem
from posreal.topology.checkpoint import Checkpoint, fingerprint, number
from posreal.topology.constrained import require_figures
from posreal.topology.degenerate import limits as limits_of
from posreal.topology.degenerate import start
from posreal.topology.equivalence import classes
from posreal.topology.found import Found, SearchSettings
from posreal.topology.front import front, least_of_limits, ranked, tally
from posreal.topology.options import checked_at_most, checked_bounds
from posreal.topology.result import Search
from posreal.topology.tradeoff import require_metric, tradeoff
from posreal.topology.values import best_values, is_smooth, scale
from posreal.vehicle import parameters

LARGEST = 7  # elements: 11,700 trees, of which there are five times as many with each element more
STARTS, STARTS_CONSTRAINED = 16, 6  # random starts for each topology
PROMISING = 24  # networks of each size, the best, that are looked at again
MORE, MORE_CONSTRAINED = 8, 2  # times as many starts for these
_WARM = 3  # limits whose optima are starts of a larger network, the best of them
_OFF = 2.5  # decades from the unit of the element that the limit lost
_CHUNK = 8  # topologies handed out at a time


@one_thread
def search(
    problem: Problem | str,
    elements: int,
    *,
    at_most: Mapping[str, int] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    any_values: bool = False,
    limits: Mapping[str, float] | None = None,
    metric: str | None = None,
    starts: int | None = None,
    seed: int = 0,
    jobs: int = 1,
    backend: str | None = None,
    scheduler: str | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    progress: Callable[[str], None] | None = None,
) -> Search:
    """The best network for each number of elements up to `elements`, in the device's place.

    Parameters
    ----------
    problem : Problem, or the name of one
    elements : int
        The most elements, 1 to 7; the bush or the static spring is not counted. Bridges are searched up to 6.
    at_most : mapping, optional
        The most ``springs``, ``dampers``, ``inerters``, and ``reactive`` elements (springs and inerters together): a
        network of n of these has degree n at most.
    bounds : mapping of "k", "c", "b" to (lower, upper), optional
        In N/m, N s/m and kg, for every element of the kind. Otherwise what can usually be bought for the place.
    any_values : bool
        Whether kinds without `bounds` are free instead.
    limits : mapping of metric name to value, optional
        Further metrics that may not exceed a value, in their own units.
    metric : str, optional
        Trade the objective against this one as well: the front then has several designs of one size.
    starts : int, optional
        Random starts for each topology, the best of 64. By default 16, and 6 where something must hold, for which a
        start costs a hundred times as much. The most promising topologies of each size get more of them afterwards.
    seed : int
    jobs : int
        Processes on this machine; -1 for all cores.
    backend : {None, "loky", "threading", "dask"}
    scheduler : str, optional
        Address of a Dask scheduler, for the dask backend.
    checkpoint : path, optional
        File into which results go as they come. If it holds some of this search already, they are not
        computed again; a search of more elements, or with other numbers in `at_most`, may go on from the same
        file.
    progress : function of str, optional
        Called with one line whenever results come in: how many, how fast, the best so far.

    Returns
    -------
    Search

    Raises
    ------
    BadInput
        For a number, metric, backend or checkpoint that cannot be used.
    """
    began = time.perf_counter()
    problem = as_problem(problem)
    if isinstance(elements, bool) or not isinstance(elements, int) or not 1 <= elements <= LARGEST:
        raise BadInput(f"{elements!r} elements cannot be searched; give a number from 1 to {LARGEST}")
    counts = checked_at_most(at_most)
    posed = limited(problem, limits) if limits else problem
    if starts is None:
        starts = STARTS if is_smooth(posed) else STARTS_CONSTRAINED
    if isinstance(starts, bool) or not isinstance(starts, int) or not 1 <= starts <= 1000:
        raise BadInput(f"{starts!r} starts: give a number from 1 to 1000")
    usual = {} if any_values or problem.usual is None else problem.usual.by_kind
    settings = SearchSettings(starts, seed, {**usual, **checked_bounds(bounds)})
    require_figures(posed)
    if metric is not None:
        require_metric(posed, metric)
    alone = bool(settings.bounds) or posed.tolerances is not None or posed.elements is not None
    classed = _classes(elements, alone)
    header = _header(posed, settings)
    found: dict[Form, Found] = {}
    with (
        workers(jobs, backend, scheduler) as pool,
        Checkpoint(checkpoint, header) if checkpoint is not None else nullcontext() as file,
    ):
        known = {} if file is None else _records(file, classed, len(posed.free))
        if file is not None and file.trimmed and progress is not None:
            progress(f"the last line of {file.path} was unfinished and has been cut off")
        again = dataclasses.replace(settings, starts=settings.starts * (MORE if is_smooth(posed) else MORE_CONSTRAINED))
        resumed = 0
        for size in range(1, elements + 1):
            wanted = [form for form in _of_size(size, counts) if classed[form] == form]
            first = _Look(posed, settings, wanted, known, found, progress)
            first.take(
                pool, file, lambda form: (warm_starts(posed, form, found), least_of_limits(form, classed, found))
            )
            found.update(first.results)
            promising = [one.form for one in ranked(size, classed, found)[:PROMISING]]
            second = _Look(posed, again, promising, known, found, progress)
            second.take(pool, file, lambda form: ([found[form].values], least_of_limits(form, classed, found)))
            for form, one in second.results.items():
                if one.objective < found[form].objective:
                    found[form] = one
            resumed += first.resumed
        every = [_of_size(size, counts) for size in range(1, elements + 1)]
        points = front(posed, settings, classed, every, found)
        if metric is not None:
            points = tradeoff(posed, settings, metric, points, classed, found, pool)
    return Search(
        problem=posed,
        elements=elements,
        front=points,
        tallies=tuple(tally(size, some, classed, found) for size, some in enumerate(every, 1)),
        metric=metric,
        bounds=settings.bounds,
        found={
            "method": "every topology, descent on the port's response with exact gradients",
            "starts": starts,
            "seed": seed,
            "seconds": round(time.perf_counter() - began, 2),
            "resumed": resumed,
        },
    )


def best_of_each(
    problem: Problem, settings: SearchSettings, chunk: Sequence[tuple[Form, Sequence[Sequence[float]], float]]
) -> list[Found]:
    """The best values of some topologies, each with its warm starts and its limits' best: what a worker does."""
    return [best_values(problem, form, settings, warm, limit) for form, warm, limit in chunk]


def _classes(elements: int, alone: bool) -> Mapping[Form, Form]:
    """Which topology stands for which; each for itself where values have bounds or tolerances, or elements are real."""
    if alone:
        return {form: form for size in range(1, elements + 1) for form in topologies(size)}
    return classes(elements)


def _of_size(size: int, at_most: Mapping[str, int]) -> list[Form]:
    return [
        form
        for form in topologies(size)
        if all(sum(letters(form).count(one) for one in kind) <= most for kind, most in at_most.items())
    ]


def warm_starts(problem: Problem, form: Form, found: Mapping[Form, Found]) -> list[list[float]]:
    """The optima of a topology's best limits, with the lost element near its border; the default of a damper alone."""
    original = problem.original
    default = original.default_device
    if form == "c" and default is not None and default.degree == 0:
        return [[float(default(1.0).real), *(float(getattr(original.vehicle, name)) for name in problem.free)]]
    here = [(found[limit.form], limit) for limit in limits_of(form) if limit.form in found]
    near = sorted((pair for pair in here if pair[0].feasible), key=lambda pair: pair[0].objective)[:_WARM]
    units = scale(problem).units(letters(form))
    made = []
    for smaller, limit in near:
        count = len(letters(limit.form))
        lost = units[limit.lost] * 10 ** (_OFF if limit.locked else -_OFF)
        values = start(limit, smaller.values[:count], float(lost), units.tolist())
        made.append([*values, *smaller.values[count:]])
    return made


def _header(problem: Problem, settings: SearchSettings) -> dict[str, Any]:
    """What decides the results, for a checkpoint; the number of elements does not."""
    identity = {
        "vehicle": [problem.vehicle.name, _parameters(problem)],
        "objective": problem.objective,
        "conditions": conditions(problem),
        "track": repr(problem.vehicle.irregularity),
        "points": [dict(point) for point in problem.points],
        "constraints": [[c.metric, c.sense, c.value] for c in problem.constraints],
        "free": {name: [r.lower, r.upper] for name, r in problem.free.items()},
        "bounds": {kind: list(pair) for kind, pair in settings.bounds.items()},
    }
    if problem.elements is not None:
        identity["elements"] = problem.elements.to_dict()
    if problem.tolerances is not None:
        identity["tolerances"] = str(problem.tolerances)
    return {
        "version": 1,
        "problem": problem.name,
        "seed": settings.seed,
        "starts": settings.starts,
        "fingerprint": fingerprint(identity),
    }


def _parameters(problem: Problem) -> dict[str, Any]:
    """Everything that makes the vehicle what it is, JSON-able."""
    vehicle = problem.vehicle
    if is_named(problem):
        return parameters(vehicle)
    around, plant = problem.mounting, problem.plant
    matrices = {field.name: getattr(plant, field.name) for field in dataclasses.fields(plant) if field.init}
    return {name: np.asarray(part).tolist() for name, part in matrices.items() if part is not None} | {
        "beside": str(around.beside),
        "behind": str(around.behind),
    }


def _record(found: Found) -> dict[str, Any]:
    return {
        "network": key(found.form),
        "objective": number(found.objective),
        "values": list(found.values),
        "agreed": found.agreed,
        "starts": found.starts,
    }


def _records(file: Checkpoint, classed: Mapping[Form, Form], free: int) -> dict[tuple[Form, int], Found]:
    """A checkpoint's results by topology and starts; those of sizes that are not wanted now are passed over.

    Parameters
    ----------
    file : Checkpoint
    classed : mapping of topologies
    free : int
        How many of the vehicle's parameters are searched too, whose values follow the elements'.
    """
    by_key = {key(form): form for form in classed}
    known = {}
    for line, record in enumerate(file.records, 2):
        try:
            form = by_key.get(record["network"])
            if form is not None:
                found = _found(form, record, len(letters(form)) + free)
                known[form, found.starts] = found
        except (KeyError, TypeError, ValueError):
            raise BadInput(
                f"line {line} of the checkpoint {plain(file.path)} holds no result of a search; keep what is before it "
                f"with `head -n {line - 1}`, or delete the file and search again"
            ) from None
    return known


def _found(form: Form, record: Mapping[str, Any], count: int) -> Found:
    values, objective = tuple(map(float, record["values"])), record["objective"]
    found = Found(form, math.inf if objective is None else float(objective), values, record["agreed"], record["starts"])
    if len(values) != (count if found.feasible else 0) or not all(0 < value < math.inf for value in values):
        raise ValueError
    if not found.objective > 0 or not all(isinstance(number, int) for number in (found.agreed, found.starts)):
        raise ValueError
    return found


class _Look:
    """The best values of some topologies of one size: taken from a checkpoint, or found and put there."""

    def __init__(
        self,
        problem: Problem,
        settings: SearchSettings,
        wanted: Sequence[Form],
        known: Mapping[tuple[Form, int], Found],
        found: Mapping[Form, Found],
        say: Callable[[str], None] | None,
    ) -> None:
        self._problem, self._settings, self._wanted, self._found, self._say = problem, settings, wanted, found, say
        pairs = ((form, known.get((form, settings.starts))) for form in wanted)
        self.results = {form: one for form, one in pairs if one is not None}
        self.resumed = len(self.results)

    def take(
        self, pool: Workers, file: Checkpoint | None, given: Callable[[Form], tuple[Sequence[Sequence[float]], float]]
    ) -> None:
        """Find what is not known yet; `given` are a topology's warm starts and its limits' best figure."""
        work = [(form, *given(form)) for form in self._wanted if form not in self.results]
        tasks = [(self._problem, self._settings, work[i : i + _CHUNK]) for i in range(0, len(work), _CHUNK)]
        began = time.perf_counter()
        for results in pool.each(best_of_each, tasks):
            if file is not None:
                file.add([_record(result) for result in results])
            self.results |= {result.form: result for result in results}
            if self._say is not None:
                self._say(self._line(time.perf_counter() - began))

    def _line(self, seconds: float) -> str:
        """How far, how fast, the best so far."""
        done, total = len(self.results), len(self._wanted)
        filled = round(20 * done / total)
        rate = (done - self.resumed) / max(seconds, 1e-9)
        best = min([*self._found.values(), *self.results.values()], key=lambda one: one.objective)
        return (
            f"{len(letters(self._wanted[0]))} elements {'━' * filled}{'─' * (20 - filled)} {done}/{total}, "
            f"{rate:.1f} a second, best {self._problem.objective} {best.objective:.5g} by {key(best.form)}"
        )
