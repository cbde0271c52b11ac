"""A design: a problem, a device for it, and its figures, all of which it can compute again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from posreal.admittance import Rational
from posreal.admittance.positive_real import require
from posreal.design.problem import Problem
from posreal.errors import Infeasible
from posreal.network import Network
from posreal.vehicle import Metric


@dataclass(frozen=True)
class Design:
    """A device for a problem.

    Attributes
    ----------
    label : str
        Name for tables: a layout, ``order 2``.
    problem : Problem
        With the vehicle as designed (chosen vehicle parameters in place).
    port : Rational
        Admittance of the whole secondary port.
    device : Rational or None
        What stands in the device's place: the layout's network, or the admittance beside the spring or behind the
        bush; None for no device.
    network : Network or None
        `device` as a network where it is one.
    metrics : mapping of metric name to Metric
    parameters : mapping of str to float
        Element values by name and chosen vehicle parameters, SI units.
    found : mapping
        How it was found: method, starts, how many agreed, seed, seconds, notes.
    """

    label: str
    problem: Problem
    port: Rational
    device: Rational | None
    network: Network | None
    metrics: Mapping[str, Metric]
    parameters: Mapping[str, float] = field(default_factory=dict)
    found: Mapping[str, Any] = field(default_factory=dict)

    @property
    def objective(self) -> Metric:
        """The figure that the problem minimises."""
        return self.metrics[self.problem.objective]

    @property
    def order(self) -> int:
        """McMillan degree of the device."""
        return 0 if self.device is None else self.device.degree

    @property
    def feasible(self) -> bool:
        """Whether all constraints hold."""
        return not self.problem.violated(self.metrics)

    def improvement(self, metric: str | None = None) -> float | None:
        """Per cent by which a metric (the objective) is better than with the default suspension."""
        return self.problem.improvement(self.metrics, metric)

    def check(self, *, tolerance: float = 1e-6) -> Mapping[str, Metric]:
        """Compute everything again from the device alone and compare.

        Parameters
        ----------
        tolerance : float
            Relative; the metrics are deterministic, so this only allows for another machine's rounding.

        Returns
        -------
        mapping of metric name to Metric, the figures computed anew

        Raises
        ------
        NotPositiveReal
            If the device is not positive real, decided in exact arithmetic.
        Infeasible
            If a figure differs from the one recorded, or a constraint does not hold.
        """
        if self.device is not None:
            require(self.device)
        if self.network is not None and self.network.admittance() != self.device:
            raise Infeasible(f"{self.label}: the network's admittance is not the device's")
        anew = self.problem.metrics(self.port)
        for name, metric in anew.items():
            recorded = self.metrics[name].value
            if abs(metric.value - recorded) > tolerance * abs(recorded):
                raise Infeasible(f"{self.label}: {name} is {metric.value:.8g}, recorded as {recorded:.8g} {metric.unit}")
        broken = self.problem.violated(anew)
        if broken:
            raise Infeasible(f"{self.label}: {broken[0]}")
        return anew

    def to_dict(self) -> dict[str, Any]:
        """The design as JSON-able data; coefficients as exact text in ascending powers."""
        return {
            "label": self.label,
            "objective": {
                "name": self.problem.objective,
                "value": self.objective.value,
                "unit": self.objective.unit,
            },
            "metrics": metrics_to_dict(self.metrics),
            "device": {
                "network": None if self.network is None else str(self.network),
                "rational": None if self.device is None else self.device.to_dict(),
            },
            "order": self.order,
            "parameters": dict(self.parameters),
            "feasible": self.feasible,
            "found": dict(self.found),
        }


def metrics_to_dict(metrics: Mapping[str, Metric]) -> dict[str, dict[str, Any]]:
    """``{name: {"value", "unit"}}``, with ``"at"`` where a figure says where it is attained."""
    return {
        name: {"value": metric.value, "unit": metric.unit} | ({"at": metric.at} if metric.at else {})
        for name, metric in metrics.items()
    }
