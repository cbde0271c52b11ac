"""One design on a vehicle whose parameters vary: every metric at every point, the worst beside the nominal.

The device stays as it is; the default suspension goes through the same points, so that one sees whether what the design
gains at the nominal point survives.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from posreal.admittance import Rational
from posreal.errors import BadInput, Infeasible, shown
from posreal.metric import Measured
from posreal.specification.design import Design, metrics_to_dict
from posreal.specification.problem import Problem
from posreal.text_table import frame, percent, table
from posreal.vehicle import override

Metrics = Mapping[str, Measured]

_RANGE = re.compile(r"\s*([A-Za-z]\w*)\s*=\s*([^:]+):([^:]+):(\d+)\s*")
_MOST = 1000  # points
_SHOWN = 40  # points that are printed; more are in the JSON
_NEITHER = ("static_stiffness", "inertance")  # of which more is not worse


@dataclass(frozen=True)
class Robustness:
    """One metric over all points.

    Attributes
    ----------
    nominal, worst : float
        Of the design; `worst` is None where some point is unstable.
    at : mapping of parameter to value
        Where the worst is.
    default_nominal, default_worst : float or None
        Of the default suspension; None where there is none or it is unstable.
    gain, least_gain : float or None
        Per cent by which the design is better than the default suspension, at the nominal point and where it is least
        (−inf where only the default suspension is stable).
    least_gain_at : mapping of parameter to value
    """

    nominal: float
    worst: float | None
    at: Mapping[str, float]
    default_nominal: float | None
    default_worst: float | None
    gain: float | None
    least_gain: float | None
    least_gain_at: Mapping[str, float]


@dataclass(frozen=True, repr=False)
class Sweep:
    """Metrics of a design, and of the default suspension, over vehicle parameters; None where it is not stable.

    Attributes
    ----------
    design : Design
    points : tuple of mappings of parameter to value
    metrics : tuple of mappings, or None, one a point
    default : the same for the default suspension; empty if the vehicle has none
    default_nominal : its metrics at the nominal point, or None
    """

    design: Design
    points: tuple[Mapping[str, float], ...]
    metrics: tuple[Metrics | None, ...]
    default: tuple[Metrics | None, ...] = ()
    default_nominal: Metrics | None = None

    @property
    def parameters(self) -> tuple[str, ...]:
        """What varies."""
        return tuple(self.points[0])

    @cached_property
    def robustness(self) -> dict[str, Robustness]:
        """Nominal beside worst, of every metric of which more (of Ldmp: less) is worse."""
        return {name: self._robustness(name) for name in self.design.metrics if name not in _NEITHER}

    def _robustness(self, name: str) -> Robustness:
        sign = -1.0 if name.split(" at ")[0] == "Ldmp" else 1.0
        own, others = self._values(self.metrics, name), self._values(self.default, name)
        nominal = self.design.metrics[name].value
        default = None if self.default_nominal is None else self.default_nominal[name].value
        at = int(np.argmax([sign * value for value in own]))
        gains = [(_gain(mine, other, sign), i) for i, (mine, other) in enumerate(zip(own, others, strict=False))]
        gained = [(gain, i) for gain, i in gains if gain is not None]
        least = min(gained, default=(None, 0))
        return Robustness(
            nominal=nominal,
            worst=_finite(own[at]),
            at=self.points[at],
            default_nominal=default,
            default_worst=_finite(sign * max(sign * value for value in others)) if others else None,
            gain=None if default is None else _gain(nominal, default, sign),
            least_gain=least[0],
            least_gain_at=self.points[least[1]] if gained else {},
        )

    def _values(self, found: Sequence[Metrics | None], name: str) -> list[float]:
        """A metric at every point, as bad as can be where the vehicle is not stable."""
        worst = -np.inf if name.split(" at ")[0] == "Ldmp" else np.inf
        return [worst if metrics is None else metrics[name].value for metrics in found]

    def to_frame(self) -> Any:
        """A row a point, as a ``pandas.DataFrame``: the parameters, every metric, and the default's objective."""
        goal = self.design.problem.objective
        rows = []
        for i, (point, found) in enumerate(zip(self.points, self.metrics, strict=True)):
            row: dict[str, Any] = {"point": i, **point, "stable": found is not None}
            row |= {name: math.nan if found is None else found[name].value for name in self.design.metrics}
            if self.default:
                other = self.default[i]
                row[f"default {goal}"] = math.nan if other is None else other[goal].value
            rows.append(row)
        return frame(rows, "point")

    def __repr__(self) -> str:
        return f"<Sweep of {self.design.label} over {', '.join(self.parameters)}, {len(self.points)} points>"

    def __str__(self) -> str:
        goal = self.design.problem.objective
        names = list(self.design.metrics)
        units = [self.design.metrics[name].unit for name in names]
        header = [*self.parameters, *(f"{name} [{unit}]" for name, unit in zip(names, units, strict=True))]
        header += [f"default {goal}"] if self.default else []
        body = []
        for i, (point, found) in enumerate(zip(self.points, self.metrics, strict=True)):
            row = [f"{value:.6g}" for value in point.values()]
            row += ["unstable" if found is None else f"{found[name].value:#.5g}" for name in names]
            if self.default:
                other = self.default[i]
                row.append("unstable" if other is None else f"{other[goal].value:#.5g}")
            body.append(row)
        lines = [table(header, body[:_SHOWN], "r")]
        if len(body) > _SHOWN:
            lines.append(f"  … and {len(body) - _SHOWN} points more; --json has them all")
        return "\n".join([*lines, "", self._summary()])

    def _summary(self) -> str:
        header = ["metric", "nominal", "worst", "at"]
        header += ["default, nominal", "default, worst", "better", "least better", "at"] if self.default else []
        rows = []
        for name, one in self.robustness.items():
            row = [name, f"{one.nominal:#.5g}", _number(one.worst), _place(one.at)]
            if self.default:
                row += [_number(one.default_nominal), _number(one.default_worst)]
                least = "unstable" if one.least_gain == -np.inf else percent(one.least_gain)
                row += [percent(one.gain), least, _place(one.least_gain_at)]
            rows.append(row)
        return table(header, rows, "lrrlrrrrl"[: len(header)])

    def to_dict(self) -> dict[str, Any]:
        """JSON-able rows and summary; a single parameter has its name and value by themselves too."""
        alone = self.parameters[0] if len(self.parameters) == 1 else None
        rows: list[dict[str, Any]] = []
        for i, (point, found) in enumerate(zip(self.points, self.metrics, strict=True)):
            row: dict[str, Any] = {} if alone is None else {"value": point[alone]}
            row |= {"values": dict(point), "metrics": None if found is None else metrics_to_dict(found)}
            if self.default:
                other = self.default[i]
                row["default"] = None if other is None else metrics_to_dict(other)
            rows.append(row)
        document: dict[str, Any] = {} if alone is None else {"parameter": alone}
        robustness = {name: dict(vars(one)) for name, one in self.robustness.items()}
        for one in robustness.values():
            one["least_gain"] = None if one["least_gain"] == -np.inf else one["least_gain"]
        return document | {"parameters": list(self.parameters), "rows": rows, "robustness": robustness}


def sweep(
    design: Design, parameters: Mapping[str, Sequence[float]] | str, values: Sequence[float] | None = None
) -> Sweep:
    """Measure `design` over vehicle parameters, the device unchanged.

    Parameters
    ----------
    design : Design
    parameters : mapping of parameter to values, or one parameter
        SI units; of several parameters every combination is measured, 1000 at most.
    values : sequence of float, optional
        Of the one parameter.

    Returns
    -------
    Sweep

    Raises
    ------
    BadInput
        For an unknown parameter, a value out of range, or too many points.
    """
    ranges = {parameters: values or ()} if isinstance(parameters, str) else dict(parameters)
    count = int(np.prod([len(of) for of in ranges.values()])) if ranges else 0
    if not 1 <= count <= _MOST:
        raise BadInput(f"{count} points cannot be swept; give from 1 to {_MOST}")
    points = [dict(zip(ranges, map(float, one), strict=True)) for one in itertools.product(*ranges.values())]
    problem, original = design.problem, design.problem.original
    found, default = [], []
    for point in points:
        changed = problem.with_vehicle(point)
        found.append(_measured(changed, _port(design, changed, point)))
        if original.default_port is not None:
            there = original.with_vehicle(point)
            default.append(_measured(there, there.default_port))
    return Sweep(design, tuple(points), tuple(found), tuple(default), problem.default_metrics)


def _port(design: Design, changed: Problem, point: Mapping[str, float]) -> Rational:
    """The port with the design's device; a layout's own static spring or bush follows the vehicle's."""
    if design.whole and set(point) & set(changed.roles.values()):
        return design.problem.port_at(changed, design.port, point)
    return changed.port(design.device, whole=design.whole)


def _measured(problem: Problem, port: Rational | None) -> Metrics | None:
    assert port is not None
    try:
        return problem.metrics(port)
    except Infeasible:
        return None


def _gain(mine: float, other: float, sign: float) -> float | None:
    """Per cent by which one value is better than another; None where the latter is no measure."""
    if not np.isfinite(other) or other == 0:
        return None
    return -np.inf if not np.isfinite(mine) else 100 * sign * (1 - mine / other)


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _number(value: float | None) -> str:
    return "unstable" if value is None else f"{value:#.5g}"


def _place(point: Mapping[str, float]) -> str:
    return ", ".join(f"{name}={value:g}" for name, value in point.items())


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
            f"{shown(text)} is not a range such as V=10:55:10 (parameter=first:last:number of values, at most {_MOST})"
        ) from None
    return name, np.linspace(first, last, count).tolist()


def read_ranges(problem: Problem, texts: Sequence[str]) -> dict[str, list[float]]:
    """Several ranges, each of another parameter that the problem's vehicle has.

    Raises
    ------
    BadInput
    """
    found: dict[str, list[float]] = {}
    for text in texts:
        name, values = read_range(text)
        if name in found:
            raise BadInput(f"{name} is swept twice; give one range for each parameter")
        found[name] = values
        for end in (values[0], values[-1]):
            override(problem.vehicle, {name: end}, where=text)
    return found
