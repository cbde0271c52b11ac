"""The best positive-real device of an order, as a design."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from posreal.numerics.threads import one_thread
from posreal.optimisation.both_bands import in_both_bands
from posreal.optimisation.caveats import reported
from posreal.specification.design import Design
from posreal.specification.named import as_problem
from posreal.specification.problem import Problem
from posreal.synthesis.combination import synthesise as search
from posreal.synthesis.result import Synthesis


@one_thread
def synthesise(
    problem: Problem | str,
    order: int,
    *,
    method: str = "auto",
    starts: int | None = None,
    seed: int = 0,
    warm: Sequence[Any] = (),
    spring: bool = False,
    inerter: bool = False,
    jobs: int = 1,
    progress: Callable[[str], None] | None = None,
) -> Design:
    """The best positive-real admittance of McMillan degree `order` that was found for the device's place.

    See :func:`posreal.synthesis.combination.synthesise` for the parameters, the method and what is raised. The design's
    ``found`` holds what the iterated SDPs reached alone (``bmi``) and what finishing reached (``ph``), the number of
    starts and how many of them agreed within 0.1 %, seed and seconds.
    """
    problem = replace(as_problem(problem), elements=None)  # an admittance has none
    options: dict[str, Any] = {} if starts is None else {"starts": starts}
    options |= {"method": method, "seed": seed, "spring": spring, "inerter": inerter, "jobs": jobs}

    def found(posed: Problem) -> Design:
        result = search(posed, order, warm=warm, progress=progress, **options)
        return _as_design(posed, result, order, spring, inerter)

    return reported(in_both_bands(problem, found))


def _as_design(problem: Problem, result: Synthesis, order: int, spring: bool, inerter: bool) -> Design:
    reached = {name: result.reached_by(name) for name in ("bmi", "ph")}
    beside = [name for name, allowed in (("spring", spring), ("inerter", inerter)) if allowed]
    changed = problem.with_vehicle(result.parameters)
    return Design(
        " + ".join([f"order {order}", *beside]),
        changed,
        result.device,
        result.metrics,
        parameters=dict(result.parameters),
        found={
            "method": result.method,
            **{f"reached_by_{name}": value for name, value in reached.items() if value is not None},
            "starts": result.starts,
            "agreed": result.agreeing,
            "seed": result.seed,
            "seconds": round(result.seconds, 2),
            "notes": list(result.notes),
        },
    )
