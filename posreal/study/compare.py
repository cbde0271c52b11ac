"""Side by side on one problem: the default suspension, every layout at its optimum, and synthesised devices."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from posreal.design import Bound, Design, Problem, evaluate, layouts, optimise, synthesise
from posreal.design.bound import bound as prove
from posreal.errors import BadInput
from posreal.network import Network
from posreal.network.diagram import diagram
from posreal.study.strut import degree, realised, strut
from posreal.study.text import percent, table

_HEADLINES = {
    "side-view": ("J1z_L", "J1z_M", "J1z_T"),
    "plan-view": ("Macc", "Ldmp", "max_yv"),
    "quarter-car": ("J1", "J3"),
}


@dataclass(frozen=True)
class Comparison:
    """Designs for one problem, in the order in which they are shown."""

    problem: Problem
    rows: tuple[Design, ...]
    bound: Bound | None = None

    @property
    def best(self) -> Design:
        """The feasible design with the least objective."""
        return min((row for row in self.rows if row.feasible), key=lambda row: row.objective.value)

    @cached_property
    def reference(self) -> Design:
        """What improvements are relative to: the default suspension, or the first row where there is none."""
        return self.rows[0]

    def improvement(self, row: Design, metric: str) -> float:
        """Per cent by which a row's metric is better (lower) than the reference's."""
        return 100 * (1 - row.metrics[metric].value / self.reference.metrics[metric].value)

    def gap(self, row: Design) -> float | None:
        """Per cent by which the proven bound is below a row, both in the bound's own (whole-band) figure."""
        return None if self.bound is None else self.bound.beside(row).gap_percent

    def __str__(self) -> str:
        return self.text()

    def text(self, *, ascii: bool = False) -> str:
        """The table, what to know about it, and the best network drawn."""
        problem = self.problem
        metrics = _HEADLINES[problem.vehicle.name]
        units = {name: self.rows[0].metrics[name].unit for name in metrics}
        goal = problem.objective
        header = [
            "design",
            "degree",
            *(f"{name} [{units[name]}]" for name in metrics),
            *(
                [f"better at {name.removeprefix('J1z_')}" for name in metrics]
                if problem.vehicle.name == "side-view"
                else [f"{goal} better"]
            ),
            *([] if self.bound is None else ["gap"]),
            "elements",
            "k+c+b",
        ]
        body = []
        for row in self.rows:
            network = strut(row)
            shown = metrics if problem.vehicle.name == "side-view" else (goal,)
            body.append(
                [
                    row.label,
                    "–" if row.device is None else str(degree(row)),
                    *(f"{row.metrics[name].value:#.5g}" for name in metrics),
                    *("–" if row is self.reference else percent(self.improvement(row, name)) for name in shown),
                    *([] if self.bound is None else [percent(self.gap(row), 1)]),
                    "–" if network is None else str(len(network)),
                    "–" if network is None else "+".join(str(n) for n in network.counts[:3]),
                ]
            )
        lines = [f"{problem.name}: {problem.summary}", "", table(header, body), ""]
        lines += [f"  {note}" for note in self._notes()]
        best = strut(self.best)
        if best is not None:
            lines += [
                "",
                f"  Best network, {self.best.label} ({self.best.objective}):",
                "",
                _drawn(best, problem, ascii),
            ]
        return "\n".join(lines)

    def _notes(self) -> list[str]:
        notes = [
            "Every figure is measured anew from the network in the row; "
            "optima and synthesised devices are the best found."
        ]
        kinds = {"side-view": "bush", "plan-view": "static spring", "quarter-car": "static spring"}
        notes.append(
            f"Degree and elements include the {kinds[self.problem.vehicle.name]}; k+c+b: springs, dampers, inerters."
        )
        if self.bound is not None:
            notes += [
                f"Proven: {self.bound.metric} ≥ {self.bound.value:.5g} {self.bound.unit} over the whole band for "
                f"{self.bound.devices}.",
                "Gap: how far that is below the row, whose own figure over the whole band is taken for it.",
            ]
        return notes + [f"Subject to {constraint}." for constraint in self.problem.constraints]

    def to_dict(self) -> dict[str, Any]:
        """JSON-able rows, each with its gap to the bound; `bound` is null where no bound is known."""
        rows = [row.to_dict() | {"gap_percent": self.gap(row)} for row in self.rows]
        bound = None if self.bound is None else self.bound.to_dict()
        kept = None if bound is None else {key: bound[key] for key in ("bound", "best", "gap_percent")}
        return {"problem": self.problem.name, "rows": rows, "bound": kept}


def _drawn(network: Network, problem: Problem, ascii: bool) -> str:
    ends = {"side-view": ("body", "bogie"), "plan-view": ("body", "bogie"), "quarter-car": ("body", "wheel")}
    return diagram(network, ends[problem.vehicle.name], ascii=ascii)


def compare(
    problem: Problem,
    *,
    orders: Sequence[int] = (1, 2),
    seed: int = 0,
    jobs: int = 1,
    progress: Callable[[str], None] | None = None,
) -> Comparison:
    """Compare the default suspension, all layouts that fit, and synthesised devices of some orders.

    Parameters
    ----------
    problem : Problem
    orders : sequence of int
        Orders of the synthesised devices; each starts from the one before.
    seed, jobs : int
    progress : function of str, optional

    Returns
    -------
    Comparison
        Synthesised rows hold their networks, with the networks' own figures.
    """

    def say(text: str) -> None:
        if progress is not None:
            progress(text)

    rows: list[Design] = []
    if problem.default_port is not None:
        label = "airspring only" if problem.vehicle.name == "side-view" else "default (k | c)"
        rows.append(evaluate(problem, None, label=label))
    for entry in layouts():
        if entry.fits(problem):
            say(f"optimising {entry.name}")
            rows.append(optimise(problem, entry, seed=seed, jobs=jobs))
    warm: list[Any] = []
    for order in orders:
        say(f"synthesising order {order}")
        design = synthesise(problem, order, seed=seed, warm=warm, jobs=jobs, progress=progress)
        warm.append(design.device)
        say(f"realising order {order}")
        rows.append(realised(design)[0])
    say("proving a bound")
    try:
        bound = prove(problem, effort=0, progress=progress)
    except BadInput as reason:  # no bound is known for this problem, and the reason says why
        say(str(reason))
        return Comparison(problem, tuple(rows))
    best = min((row for row in rows if row.feasible), key=lambda row: bound.figure.measure(row.port))
    for row in rows:
        bound.require_not_below(row)
    return Comparison(problem, tuple(rows), bound.beside(best))
