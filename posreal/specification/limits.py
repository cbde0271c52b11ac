"""Limits on metrics, on top of a problem's own constraints."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

from posreal.errors import BadInput, hint, shown
from posreal.metric import DampingRatio, Inertance, Metric, PeakInTime, StaticStiffness, WeightedSum
from posreal.specification.problem import Problem


def limited(problem: Problem, limits: Mapping[str, float]) -> Problem:
    """The problem with limits on metrics, in their units, on top of its own constraints.

    They are upper ones, and lower ones of a metric that is better for being more.

    Raises
    ------
    BadInput
        For a metric that cannot be limited, or a limit that is not a number above 0.
    """
    known = [name for name, metric in problem.vehicle.metrics.items() if _has_figure(metric)]
    for name, value in limits.items():
        if name not in known:
            raise BadInput(f"{shown(name)} cannot be limited in {problem.name}; {hint(name, known)}")
        if not (np.isfinite(value) and (value > 0 or (value == 0 and name == "inertance"))):
            raise BadInput(f"the limit of {name} is {value:g}; it must be finite and greater than 0")
    return dataclasses.replace(problem, at_most={**problem.at_most, **{n: float(v) for n, v in limits.items()}})


def _has_figure(metric: Metric) -> bool:
    """Whether a search can keep a metric below a limit, a damping ratio above one."""
    if isinstance(metric, DampingRatio):
        return True
    if metric.better != "less":
        return False
    return metric.norm() is not None or isinstance(metric, PeakInTime | StaticStiffness | Inertance | WeightedSum)
