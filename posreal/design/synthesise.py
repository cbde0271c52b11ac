"""The best positive-real device of an order, as a design."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from posreal.admittance import Rational
from posreal.design.guard import guarded
from posreal.design.problem import Problem
from posreal.design.result import Design
from posreal.design.synthesis import synthesise as search
from posreal.design.threads import one_thread
from posreal.vehicle import measure

_RINGS = 1.1  # times the figure to 20 Hz; the airspring alone has 1.003 over the trailing bogie, layout S5 1.04


@one_thread
def synthesise(
    problem: Problem,
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

    See :func:`posreal.design.synthesis.synthesise` for the parameters, the method and what is raised. The design's
    ``found`` holds what the iterated SDPs reached alone (``bmi``) and what finishing reached (``ph``), the number of
    starts and how many of them agreed within 0.1 %, seed and seconds.
    """
    options: dict[str, Any] = {} if starts is None else {"starts": starts}
    result = search(
        problem,
        order,
        method=method,
        seed=seed,
        warm=warm,
        spring=spring,
        inerter=inerter,
        jobs=jobs,
        progress=progress,
        **options,
    )
    reached = {name: result.reached_by(name) for name in ("bmi", "ph")}
    beside = [name for name, allowed in (("spring", spring), ("inerter", inerter)) if allowed]
    changed = problem.with_vehicle(result.parameters)
    return guarded(
        Design(
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
                "notes": [*result.notes, *_ringing(changed, result.device)],
            },
        )
    )


def _ringing(problem: Problem, device: Rational) -> list[str]:
    """A sentence about a device whose ride ends at 20 Hz because it rings above, where the figure does not look."""
    metric, twin = problem.base_objective, f"{problem.base_objective}_whole"
    if twin not in problem.vehicle.metrics or problem.goal is not None:
        return []
    found = measure(problem.vehicle, {"secondary": problem.port(device)}, twin)
    ends, whole = found[metric].value, found[twin].value
    if whole < _RINGS * ends:
        return []
    return [
        f"{metric} ends at 20 Hz; over all frequencies it is {whole:.6g} %g, because this device rings above 20 Hz: "
        f"--objective whole-band minimises that instead, --limit {metric}_whole=… keeps it low"
    ]
