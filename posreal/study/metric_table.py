"""A design's metrics as a table: both bands side by side, and by how much each is better than the default's."""

from __future__ import annotations

from posreal.metric import Inertance, StaticStiffness
from posreal.specification.design import Design
from posreal.specification.problem import Problem
from posreal.vehicle import whole_band_twin

_ALIGNED = dict.fromkeys(("value", "real", "ideal", "better", "all frequencies"), "r")


def metric_table(design: Design) -> tuple[list[str], list[list[str]], str]:
    """Header, a row a metric, and the alignment of the columns.

    Where some end at 20 Hz, what they are over all frequencies stands beside them, and beside each what it would be of
    ideal elements.
    """
    ideal = design.ideal

    def value(name: str) -> list[str]:
        measured = None if ideal is None else ideal.metrics.get(name)
        beside = [] if ideal is None else ["–" if measured is None else f"{measured.value:#.6g}"]
        return [f"{design.metrics[name].value:#.6g}", *beside]

    def better(name: str) -> str:
        gain = design.improvement(name) if _improves(design.problem, name) else None
        return "" if gain is None else f"{gain:+.2f} %"

    beside = {name: whole_band_twin(design.problem.vehicle, name) for name in design.metrics}
    twins = {name: twin for name, twin in beside.items() if twin in design.metrics}
    values = ["value"] if ideal is None else ["real", "ideal"]
    rows = []
    for name, metric in design.metrics.items():
        if name not in twins.values():
            twin = twins.get(name) or ""
            whole = [*value(twin), better(twin)] if twin else [""] * (len(values) + 1)
            rows.append([name, *value(name), metric.unit, better(name), *(whole if twins else []), metric.at])
    everywhere = ["all frequencies", *values[1:], "better"] if twins else []
    header = ["metric", *values, "unit", "better", *everywhere, ""]
    return header, rows, "".join(_ALIGNED.get(name, "l") for name in header)


def _improves(problem: Problem, name: str) -> bool:
    """Whether it says something by how much a metric is better than the default's: not of what a place holds."""
    metric = problem.vehicle.metrics.get(name.partition(" at ")[0])
    ride = metric is not None and metric.better == "less" and not isinstance(metric, StaticStiffness | Inertance)
    return ride or name == problem.objective
