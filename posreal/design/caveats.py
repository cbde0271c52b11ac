"""What has to be said of a best design: that the default suspension is better, that it rings above 20 Hz."""

from __future__ import annotations

from dataclasses import replace

from posreal.design.guard import guarded
from posreal.design.result import Design
from posreal.vehicle import SideView
from posreal.vehicle.metrics import vertical_ride_over_the_whole_band

_RINGS = 1.1  # times the figure to 20 Hz; the airspring alone has 1.003 over the trailing bogie, layout S5 1.04
_ROUNDING = 1e-6  # of a figure: worse by no more than that is not worse


def reported(design: Design) -> Design:
    """A design that a search found, held against a proven bound, with its caveats among its notes.

    Raises
    ------
    BelowBound
        See :func:`posreal.design.guard.guarded`.
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
    metric, vehicle = problem.base_objective, problem.vehicle
    if not isinstance(vehicle, SideView) or problem.goal is not None or problem.whole_band:
        return []
    position = metric.removeprefix("J1z_")
    whole = vertical_ride_over_the_whole_band(vehicle, design.port, position).value
    before, port = problem.original.vehicle, problem.original.default_port
    assert isinstance(before, SideView)
    assert port is not None
    lost = 100 * (whole / vertical_ride_over_the_whole_band(before, port, position).value - 1)
    said = []
    if whole >= _RINGS * design.metrics[metric].value:
        said.append(
            f"{metric} ends at 20 Hz; over all frequencies it is {whole:.6g} %g, because this device rings above "
            f"20 Hz: --objective whole-band minimises that instead, --limit {metric}_whole=… keeps it low"
        )
    if lost > 100 * _ROUNDING:
        said.append(f"over all frequencies {metric} is {_worse(lost)}")
    return said


def _worse(percent: float) -> str:
    return f"worse than the default suspension by {percent:.3g} %"
