"""What a search found: the best networks for each number of elements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from posreal.errors import Infeasible
from posreal.network import Network
from posreal.specification.conditions import cautions, conditions
from posreal.specification.design import Design, metrics_to_dict
from posreal.specification.problem import Problem
from posreal.text_table import counted, frame, html, table


def short(network: Network) -> str:
    """A network with values that a person can read."""
    return str(network.with_values({name: float(f"{value:.4g}") for name, value in network.values().items()}))


@dataclass(frozen=True)
class RunnerUp:
    """Another network of the same number of elements, and its figure on the search's own grid."""

    network: Network
    objective: float


@dataclass(frozen=True, repr=False)
class FrontPoint:
    """The best network of so many elements.

    Attributes
    ----------
    design : Design
        With the network in the device's place, measured by the problem's own metrics.
    equivalent : tuple of Network
        Other topologies of as many elements with the values that give them the very same admittance.
    others : tuple of RunnerUp
        The next best networks of as many elements that are no smaller ones in disguise.
    """

    design: Design
    equivalent: tuple[Network, ...] = ()
    others: tuple[RunnerUp, ...] = ()

    def __repr__(self) -> str:
        return f"<FrontPoint of {counted(self.elements, 'element')}: {self.design.objective}, {short(self.network)}>"

    @property
    def network(self) -> Network:
        """The network in the device's place, by the values that are bought."""
        assert self.design.bought is not None
        return self.design.bought

    @property
    def elements(self) -> int:
        """How many elements it has, bush and static spring not counted."""
        return len(self.network)

    def to_dict(self) -> dict[str, Any]:
        """JSON-able."""
        return {
            "elements": self.elements,
            "objective": self.design.objective.value,
            "unit": self.design.objective.unit,
            "notation": str(self.network),
            "topology": str(self.network.topology()),
            "degree": self.design.order,
            "ideal": None if self.design.ideal is None else metrics_to_dict(self.design.ideal.metrics),
            "parameters": dict(self.design.parameters),
            "metrics": metrics_to_dict(self.design.metrics),
            "equivalent": [str(network) for network in self.equivalent],
            "outside_usual": [one.to_dict() for one in (*self.design.outside, *self.design.out_of_stroke)],
            "others": [{"notation": str(o.network), "objective": o.objective} for o in self.others],
            "found": dict(self.design.found),
        }


@dataclass(frozen=True)
class Tally:
    """What became of the topologies of one size.

    Attributes
    ----------
    elements : int
    topologies : int
        All of them, within what was asked for.
    redundant : int
        Left out, because another one does all they can do.
    reduced : int
        Whose best values make them a network of fewer elements.
    impossible : int
        For which no values meet the constraints.
    """

    elements: int
    topologies: int
    redundant: int
    reduced: int
    impossible: int


@dataclass(frozen=True, repr=False)
class Search:
    """The outcome of a search.

    Attributes
    ----------
    problem : Problem
    elements : int
        The largest number of elements that was searched.
    front : tuple of FrontPoint
        By number of elements; a size that brings nothing over the smaller ones is left out. With a second metric there
        may be several of one size, in order of the objective.
    tallies : tuple of Tally
        One for each size.
    metric : str or None
        The second metric, against which the objective is traded.
    found : mapping
        Seed, starts, seconds, topologies taken from a checkpoint.
    bounds : mapping of "k", "c", "b" to (lower, upper)
        Within which values were looked for, N/m, N s/m and kg; a kind that is missing was free.
    """

    problem: Problem
    elements: int
    front: tuple[FrontPoint, ...]
    tallies: tuple[Tally, ...]
    metric: str | None
    found: Mapping[str, Any]
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def __repr__(self) -> str:
        reached = f", {self.best.objective}" if self.front else ""
        return f"<Search of {self.problem.name}, up to {counted(self.elements, 'element')}{reached}>"

    def __str__(self) -> str:
        """The front as a table."""
        return f"{self._heading}\n\n{table(*self._table(), 'll')}"

    @property
    def _heading(self) -> str:
        return f"{self.problem.name}: best networks of up to {counted(self.elements, 'element')} in the device's place"

    def _table(self) -> tuple[list[str], list[list[str]]]:
        names = [self.problem.objective, *([self.metric] if self.metric else [])]
        header = [
            "elements",
            "network",
            *(f"{n} [{self.front[0].design.metrics[n].unit}]" for n in names if self.front),
        ]
        rows = [
            [str(point.elements), short(point.network), *(f"{point.design.metrics[name].value:#.5g}" for name in names)]
            for point in self.front
        ]
        return header, rows

    def _repr_html_(self) -> str:
        drawn = self.best.network._repr_html_() if self.front and self.best.network is not None else ""
        return f"<div>{html(*self._table(), self._heading)}{drawn}</div>"

    def to_frame(self) -> Any:
        """The front as a ``pandas.DataFrame``: a row a network, with its figures and its values, SI units."""
        return frame(
            [
                {
                    "elements": point.elements,
                    "network": str(point.network.topology()),
                    **{name: one.value for name, one in point.design.metrics.items()},
                    "better_percent": point.design.improvement(),
                    **point.design.parameters,
                }
                for point in self.front
            ],
            "elements",
        )

    @cached_property
    def best(self) -> Design:
        """The design of least objective.

        Raises
        ------
        Infeasible
            If no network meets the constraints.
        """
        self.require_any()
        return min((point.design for point in self.front), key=lambda design: design.objective.value)

    def require_any(self) -> None:
        """Raise Infeasible if no network meets the constraints."""
        if not self.front:
            raise Infeasible(
                f"no network of {self.elements} elements or fewer was found that meets the constraints of "
                f"{self.problem.name}; allow more elements"
            )

    def of(self, elements: int) -> Design | None:
        """The best design of no more than so many elements; None if there is none."""
        designs = [point.design for point in self.front if point.elements <= elements]
        return min(designs, key=lambda design: design.objective.value, default=None)

    def check(self) -> None:
        """Compute every figure of the front again from the networks' graphs; see :meth:`Design.check`."""
        for point in self.front:
            point.design.check()

    def to_dict(self) -> dict[str, Any]:
        """JSON-able."""
        return {
            "problem": self.problem.name,
            "elements": self.elements,
            "objective": self.problem.objective,
            "metric": self.metric,
            "real_elements": None if self.problem.elements is None else self.problem.elements.to_dict(),
            "conditions": conditions(self.problem),
            "cautions": cautions(self.problem),
            "bounds": {kind: list(pair) for kind, pair in self.bounds.items()},
            "front": [point.to_dict() for point in self.front],
            "tallies": [vars(tally) for tally in self.tallies],
            "found": dict(self.found),
        }
