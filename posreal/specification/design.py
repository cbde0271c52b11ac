"""A design: a problem, a device for it, and its figures, all of which it can compute again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from typing import Any

import numpy as np

from posreal.admittance import Rational
from posreal.admittance.positive_real import require
from posreal.errors import Infeasible
from posreal.metric import Measured
from posreal.network import Network, nodal_admittance
from posreal.network.usual import Outside, outside, sentence
from posreal.specification.as_made import Ideal
from posreal.specification.conditions import cautions, conditions
from posreal.specification.problem import Problem
from posreal.specification.usual import out_of_stroke, own_springs
from posreal.text_table import frame, html, percent


@dataclass(frozen=True, repr=False)
class Design:
    """A device for a problem.

    Attributes
    ----------
    label : str
        Name for tables: a layout, ``order 2``.
    problem : Problem
        With the vehicle as designed (chosen vehicle parameters in place).
    device : Rational or None
        The admittance beside the static spring or behind the bush, or, if `whole`, that of the whole strut with its
        own spring or bush (a layout); None for no device.
    metrics : mapping of metric name to Measured
    network : Network or None
        `device` as a network where it is one; then the metrics are the network's. Its values are rounded, so its
        admittance may differ from the device's by up to 1e-9.
    whole : bool
        Whether the device is the whole strut.
    parameters : mapping of str to float
        Element values by name and chosen vehicle parameters, SI units.
    found : mapping
        How it was found: method, starts, how many agreed, seed, seconds, notes.
    ideal : Ideal or None
        The same of ideal elements, where the problem has real ones: `network` then holds what comes with each element.
    """

    label: str
    problem: Problem
    device: Rational | None
    metrics: Mapping[str, Measured]
    network: Network | None = None
    whole: bool = False
    parameters: Mapping[str, float] = field(default_factory=dict)
    found: Mapping[str, Any] = field(default_factory=dict)
    ideal: Ideal | None = None

    def __str__(self) -> str:
        """What was designed for what, each figure, what breaks, and the device, a line each."""
        device = "none" if self.device is None else str(self.device)
        return "\n".join(
            [
                f"{self.problem.name}: {self.label}",
                *(f"  {name} = {metric}" for name, metric in self.metrics.items()),
                *(f"  {sentence}" for sentence in self.problem.violated(self.metrics)),
                *(f"  {note}" for note in self.found.get("notes", ())),
                *(f"  {said}" for said in [self.usual_sentence] if said),
                f"  Y(s) = {device}" if self.network is None else f"  {self.network}",
            ]
        )

    def __repr__(self) -> str:
        device = "no device" if self.device is None else f"order {self.order}"
        shown = device if self.network is None else str(self.network)
        return f"<Design {self.label} for {self.problem.name}: {self.problem.objective} = {self.objective}, {shown}>"

    def _records(self) -> list[dict[str, Any]]:
        better = {name: self.improvement(name) for name in self.metrics}
        return [
            {"metric": name, "value": one.value, "unit": one.unit, "better_percent": better[name], "at": one.at}
            for name, one in self.metrics.items()
        ]

    def to_frame(self) -> Any:
        """Every metric as a ``pandas.DataFrame``: value, unit, per cent better than the default, and where."""
        return frame(self._records(), "metric")

    def _repr_html_(self) -> str:
        rows = [
            [r["metric"], f"{r['value']:#.6g}", r["unit"], percent(r["better_percent"]), r["at"]]
            for r in self._records()
        ]
        drawn = "" if self.network is None else self.network._repr_html_()
        notes = [*self.problem.violated(self.metrics), *self.found.get("notes", ())]
        said = "".join(f"<p>{escape(note)}</p>" for note in notes)
        heading = f"{self.problem.name}: {self.label}"
        return f"<div>{html(['metric', 'value', 'unit', 'better', ''], rows, heading)}{said}{drawn}</div>"

    @cached_property
    def port(self) -> Rational:
        """Admittance of the whole secondary port, the network's where there is one."""
        inner = self.device if self.network is None else self.network.admittance()
        return self.problem.port(inner, whole=self.whole)

    @property
    def bought(self) -> Network | None:
        """The network by the values that are bought, without what comes with the elements."""
        return self.network if self.ideal is None else self.ideal.network

    @property
    def objective(self) -> Measured:
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

    @cached_property
    def outside(self) -> tuple[Outside, ...]:
        """What cannot usually be bought: elements of the network, springs of the vehicle's own left out."""
        own = own_springs(self.problem) if self.whole else None
        return () if self.bought is None else tuple(outside(self.bought, self.problem.usual, own=own))

    @property
    def usual_sentence(self) -> str:
        """What lies outside what can usually be bought; empty if nothing does."""
        return sentence([*self.outside, *self.out_of_stroke], self.problem.usual)

    @property
    def out_of_stroke(self) -> tuple[Outside, ...]:
        """Travels of the suspension that are longer than a device of its place can usually be bought for."""
        return tuple(out_of_stroke(self.problem, self.metrics))

    def improvement(self, metric: str | None = None) -> float | None:
        """Per cent by which a metric (the objective) is better than with the default suspension."""
        return self.problem.improvement(self.metrics, metric)

    def check(self, *, tolerance: float = 1e-6) -> Mapping[str, Measured]:
        """Compute everything again from the device alone and compare.

        Parameters
        ----------
        tolerance : float
            Relative; the metrics are deterministic, so this only allows for another machine's rounding.

        Returns
        -------
        mapping of metric name to Measured, the figures computed anew

        Raises
        ------
        NotPositiveReal
            If the device is not positive real, decided in exact arithmetic.
        Infeasible
            If a figure differs from the one recorded, or a constraint does not hold.
        """
        if self.device is not None:
            require(self.device)
        inner = self.device
        if self.network is not None and self.device is not None:
            inner = nodal_admittance(self.network)  # from its graph, not from the tree that the port was made with
            s = 1j * np.geomspace(1e-3, 1e4, 200)
            off = float(np.max(np.abs(inner(s) / self.device(s) - 1)))
            if off > 1e-9:
                raise Infeasible(
                    f"{self.label}: the network's admittance differs from the device's by {off:.1e} relative"
                )
        anew = self.problem.metrics(self.problem.port(inner, whole=self.whole))
        for name, metric in anew.items():
            recorded = self.metrics[name].value
            if abs(metric.value - recorded) > tolerance * abs(recorded):
                raise Infeasible(
                    f"{self.label}: {name} is {metric.value:.8g}, recorded as {recorded:.8g} {metric.unit}"
                )
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
            "elements": None if self.problem.elements is None else self.problem.elements.to_dict(),
            "ideal": None
            if self.ideal is None
            else {"network": str(self.ideal.network), "metrics": metrics_to_dict(self.ideal.metrics)},
            "parameters": dict(self.parameters),
            "outside_usual": [one.to_dict() for one in (*self.outside, *self.out_of_stroke)],
            "feasible": self.feasible,
            "constraints": [
                {
                    "metric": c.metric,
                    "sense": c.sense,
                    "limit": c.value,
                    "value": self.metrics[c.metric].value,
                    "verdict": c.verdict(self.metrics).lower(),
                }
                for c in self.problem.constraints
            ],
            "found": dict(self.found),
            "conditions": conditions(self.problem),
            "cautions": cautions(self.problem),
        }


def metrics_to_dict(metrics: Mapping[str, Measured]) -> dict[str, dict[str, Any]]:
    """``{name: {"value", "unit"}}``, with ``"at"`` where a figure says where it is attained."""
    return {
        name: {"value": metric.value, "unit": metric.unit} | ({"at": metric.at} if metric.at else {})
        for name, metric in metrics.items()
    }
