"""One design on a vehicle whose parameter varies: every metric at every value."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from posreal.design import Design, metrics_to_dict
from posreal.errors import BadInput, Infeasible
from posreal.study.text import table
from posreal.vehicle import Metric

_RANGE = re.compile(r"\s*([A-Za-z]\w*)\s*=\s*([^:]+):([^:]+):(\d+)\s*")
_MOST = 1000


@dataclass(frozen=True)
class Sweep:
    """Metrics of a design over a vehicle parameter; None where the vehicle is not stable."""

    design: Design
    parameter: str
    values: tuple[float, ...]
    metrics: tuple[Mapping[str, Metric] | None, ...]

    def __str__(self) -> str:
        names = list(self.design.metrics)
        units = [self.design.metrics[name].unit for name in names]
        body = [
            [
                f"{value:.6g}",
                *("unstable" if found is None else f"{found[name].value:#.5g}" for name in names),
            ]
            for value, found in zip(self.values, self.metrics, strict=True)
        ]
        header = [self.parameter, *(f"{name} [{unit}]" for name, unit in zip(names, units, strict=True))]
        return table(header, body, "r")

    def to_dict(self) -> dict[str, Any]:
        """JSON-able rows."""
        return {
            "parameter": self.parameter,
            "rows": [
                {"value": value, "metrics": None if found is None else metrics_to_dict(found)}
                for value, found in zip(self.values, self.metrics, strict=True)
            ],
        }


def sweep(design: Design, parameter: str, values: Sequence[float]) -> Sweep:
    """Measure `design` with a vehicle parameter at each of `values` (SI units), the device unchanged."""
    found: list[Mapping[str, Metric] | None] = []
    for value in values:
        changed = design.problem.with_vehicle({parameter: float(value)})
        try:
            found.append(changed.metrics(changed.port(design.device, whole=design.whole)))
        except Infeasible:
            found.append(None)
    return Sweep(design, parameter, tuple(float(v) for v in values), tuple(found))


def read_range(text: str) -> tuple[str, list[float]]:
    """``V=10:55:10`` is V at ten values from 10 to 55.

    Raises
    ------
    BadInput
    """
    match = _RANGE.fullmatch(text)
    try:
        if match is None:
            raise ValueError
        name, first, last, count = match[1], float(match[2]), float(match[3]), int(match[4])
        if not (np.isfinite([first, last]).all() and 1 <= count <= _MOST):
            raise ValueError
    except ValueError:
        raise BadInput(
            f"{text!r} is not a range such as V=10:55:10 (parameter=first:last:number of values, at most {_MOST})"
        ) from None
    return name, np.linspace(first, last, count).tolist()
