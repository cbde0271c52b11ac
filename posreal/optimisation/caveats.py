"""What has to be said of a best design: that the default suspension is better, that it rings above 20 Hz."""

from __future__ import annotations

import math
from dataclasses import replace

from posreal.bounds.guard import guarded
from posreal.specification.design import Design
from posreal.specification.problem import Problem
from posreal.vehicle import whole_band_twin

_RINGS = 1.1  # times the figure to 20 Hz; the airspring alone has 1.003 over the trailing bogie, layout S5 1.04
_ROUNDING = 1e-6  # of a figure: worse by no more than that is not worse


def reported(design: Design) -> Design:
    """A design that a search found, held against a proven bound, with its caveats among its notes.

    Raises
    ------
    BelowBound
        See :func:`posreal.bounds.guard.guarded`.
    """
    notes = [*design.found.get("notes", ()), *caveats(design)]
    return guarded(replace(design, found={**design.found, "notes": notes}))


def caveats(design: Design) -> list[str]:
    """Sentences about a design that is worse than the default suspension, or that rings where its figure ends."""
    improvement = design.improvement()
    said = []
    if improvement is not None and improvement < -100 * _ROUNDING:
        said.append(f"{design.problem.objective} is {_worse(-improvement)}")
    return said + _ringing(design)


def _ringing(design: Design) -> list[str]:
    problem = design.problem
    metric = problem.base_objective
    twin = whole_band_twin(problem.vehicle, metric)
    if twin is None or problem.goal is not None:
        return []
    whole, said = design.metrics[twin].value, []
    if whole >= _RINGS * design.metrics[metric].value:
        said.append(
            f"{metric} ends at {_end(problem)}; over all frequencies it is {whole:.6g} {design.metrics[twin].unit}, "
            f"because this device rings above {_end(problem)}: --objective whole-band minimises that instead, "
            f"--limit {twin}=… keeps it low"
        )
    lost = -(problem.improvement(design.metrics, twin) or 0.0)
    if lost > 100 * _ROUNDING:
        said.append(f"over all frequencies {metric} is {_worse(lost)}")
    return said


def _end(problem: Problem) -> str:
    norm = problem.vehicle.metrics[problem.base_objective].norm()
    return "" if norm is None else f"{norm.stop / (2 * math.pi):g} Hz"


def _worse(percent: float) -> str:
    return f"worse than the default suspension by {percent:.3g} %"
