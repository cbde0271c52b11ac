"""Several figures as one: a weighted sum Σ wᵢ Jᵢ, their norm √Σ (wᵢ Jᵢ)², or the worst of them, max wᵢ Jᵢ."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from posreal.errors import BadInput, shown
from posreal.metric import Measured

_LEAST, _MOST = 1e-30, 1e30  # of a weight
_TERM = re.compile(r"(?:([0-9.eE+-]*[0-9.])\s*\*?\s*)?([A-Za-z]\w*)")


@dataclass(frozen=True)
class Goal:
    """A figure made of others.

    Attributes
    ----------
    kind : "sum", "norm" or "worst"
    parts : tuple of (metric name, weight)
    """

    kind: str
    parts: tuple[tuple[str, float], ...]

    @property
    def name(self) -> str:
        """What the figure is called among the metrics: ``J1 + 0.001*J3``, ``norm of J1, J3``, ``worst of J1, J3``."""
        terms = [name if weight == 1 else f"{weight:g}*{name}" for name, weight in self.parts]
        return " + ".join(terms) if self.kind == "sum" else f"{self.kind} of " + ", ".join(terms)

    def of(self, metrics: Mapping[str, Measured]) -> Measured:
        """The figure from the metrics that it is made of."""
        values = [weight * metrics[name].value for name, weight in self.parts]
        units = {metrics[name].unit for name, _ in self.parts}
        unit = units.pop() if len(units) == 1 else "1"
        if self.kind == "sum":
            return Measured(sum(values), unit)
        if self.kind == "norm":
            return Measured(math.hypot(*values), unit)
        worst = max(range(len(values)), key=values.__getitem__)
        return Measured(values[worst], unit, f"by {self.parts[worst][0]}")


def weighted_sum(text: str) -> Goal:
    """``J1 + 0.001*J3`` as a goal.

    Raises
    ------
    BadInput
        If the text is not a sum of metrics with weights above 0.
    """
    parts = []
    for term in re.split(r"\s\+\s|\+(?=\s*[A-Za-z])", text):
        match = _TERM.fullmatch(term.strip())
        try:
            weight = 1.0 if match is None or match[1] is None else float(match[1])
        except ValueError:
            match, weight = None, 1.0
        if match is None or not _LEAST <= weight <= _MOST:
            raise BadInput(
                f"{shown(text)} is not a sum of metrics with weights above 0, from {_LEAST:g} to {_MOST:g}, such as "
                "J1 + 0.001*J3"
            )
        parts.append((match[2], weight))
    return Goal("sum", tuple(parts))
