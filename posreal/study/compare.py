"""Side by side on one problem: the default suspension, every layout at its optimum, and synthesised devices."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from html import escape
from pathlib import Path
from typing import Any

from posreal.bounds.compute import bound as prove
from posreal.bounds.result import Bound
from posreal.errors import BadInput, Infeasible, listed
from posreal.network import Network
from posreal.network.diagram import diagram
from posreal.optimisation.caveats import caveats
from posreal.optimisation.evaluate import evaluate
from posreal.optimisation.layout_values import optimise
from posreal.specification.conditions import cautions, conditions, in_words, stand_in
from posreal.specification.design import Design
from posreal.specification.layout import layouts
from posreal.specification.named import as_problem
from posreal.specification.problem import Problem
from posreal.study.strut import degree, realised, strut, terminals
from posreal.synthesis.synthesise import synthesise
from posreal.text_table import frame, html, percent, table
from posreal.vehicle import whole_band_twin


@dataclass(frozen=True, repr=False)
class Comparison:
    """Designs for one problem, in the order in which they are shown.

    Attributes
    ----------
    problem : Problem
    rows : tuple of Design
    bound : Bound or None
    notes : tuple of str
        Why a row or the bound is missing.
    """

    problem: Problem
    rows: tuple[Design, ...]
    bound: Bound | None = None
    notes: tuple[str, ...] = ()

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

    @property
    def shares_figure(self) -> bool:
        """Whether the objective is the very figure that the bound is about: over all frequencies, at one point."""
        same = self.problem.whole_band and stand_in(self.problem) is None
        return same and self.bound is not None and self.bound.metric == self.problem.objective

    @property
    def objective_label(self) -> str:
        """The objective in a word or two: a metric's name, ``worst case``, ``worst``, ``norm`` or ``sum``."""
        problem = self.problem
        return "worst case" if problem.points else problem.objective if problem.goal is None else problem.goal.kind

    @property
    def twin(self) -> str | None:
        """The objective over all frequencies, where it ends at 20 Hz."""
        return whole_band_twin(self.problem.vehicle, self.problem.base_objective)

    @property
    def _metrics(self) -> tuple[str, ...]:
        """Metrics that have a column."""
        problem = self.problem
        shown = problem.columns
        return shown if problem.objective in shown else (*shown, problem.objective)

    def __repr__(self) -> str:
        return f"<Comparison of {len(self.rows)} designs for {self.problem.name}, best {self.best.objective}>"

    def __str__(self) -> str:
        return self.text()

    def _repr_html_(self) -> str:
        best = strut(self.best)
        notes = "".join(f"<p>{escape(note)}</p>" for note in self.remarks())
        drawn = "" if best is None else best._repr_html_()
        return f"<div>{html(*self.table(), f'{self.problem.name}: {self.problem.summary}')}{notes}{drawn}</div>"

    def to_frame(self) -> Any:
        """The designs as a ``pandas.DataFrame``: a row a design, with all its metrics in their units."""
        return frame(
            [
                {
                    "design": row.label,
                    **{name: one.value for name, one in row.metrics.items()},
                    "better_percent": self.improvement(row, self.problem.objective),
                    "gap_percent": self.gap(row),
                    "feasible": row.feasible,
                    "network": None if (network := strut(row)) is None else str(network),
                }
                for row in self.rows
            ],
            "design",
        )

    def text(self, *, ascii: bool = False) -> str:
        """The table, what to know about it, and the best network drawn."""
        problem = self.problem
        words = in_words(problem)
        lines = [
            f"{problem.name}: {problem.summary}",
            *([f"  {words}"] if words else []),
            "",
            table(*self.table()),
            "",
        ]
        lines += [f"  Caution: {one}." for one in cautions(problem)]
        lines += [f"  {note}" for note in self.remarks()]
        best = strut(self.best)
        if best is not None:
            lines += [
                "",
                f"  Best network, {self.best.label} ({self.best.objective}):",
                "",
                _drawn(best, problem, ascii),
            ]
        return "\n".join(lines)

    def table(self) -> tuple[list[str], list[list[str]]]:
        """Header, and a row a design."""
        problem, metrics, twin = self.problem, self._metrics, self.twin
        units = {name: self.rows[0].metrics[name].unit for name in metrics}
        called = {name: name for name in metrics} | {problem.objective: self.objective_label}
        several = problem.compared and (problem.goal is not None or problem.base_objective in problem.compared)
        improved = metrics if several else (problem.objective,)
        better = [f"{called[name].removeprefix('J1z_').removeprefix('aw_')} better" for name in improved]
        header = [
            "design",
            "degree",
            *(f"{called[name]} [{units[name]}]" for name in metrics),
            *([] if twin is None else [f"whole [{self.rows[0].metrics[twin].unit}]"]),
            *better,
            *([] if self.bound is None else ["gap"]),
            "elements",
            "k+c+b",
        ]
        body = []
        for row in self.rows:
            network = strut(row)
            body.append(
                [
                    row.label if row.feasible else f"{row.label} (breaks a constraint)",
                    "–" if row.device is None else str(degree(row)),
                    *(f"{row.metrics[name].value:#.5g}" for name in metrics),
                    *([] if twin is None else [f"{row.metrics[twin].value:#.5g}"]),
                    *("–" if row is self.reference else percent(self.improvement(row, name)) for name in improved),
                    *([] if self.bound is None else [percent(self.gap(row), 1)]),
                    "–" if network is None else str(len(network)),
                    "–" if network is None else "+".join(str(n) for n in network.counts[:3]),
                ]
            )
        return header, body

    def draw(self, path: str | Path) -> Path:
        """Draw the rows and the bound into a .png, .svg or .pdf; see :mod:`.comparison_figure`."""
        from posreal.study.comparison_figure import draw

        return draw(self, path)

    def remarks(self) -> list[str]:
        """What to know about the table."""
        notes = [
            "Every figure is measured anew from the network in the row; "
            "optima and synthesised devices are the best found."
        ]
        included = f" include the {listed(self.problem.roles)}" if self.problem.roles else " are those of the device"
        if self.twin is not None:
            notes.append(f"{self.problem.base_objective} does not see all frequencies; whole: {self.twin}, which does.")
        notes.append(f"Degree and elements{included}; k+c+b: springs, dampers, inerters.")
        if self.objective_label != self.problem.objective:
            where = "".join(f", {name}" for name in self.problem.at_points)
            at = f", the worst over the nominal vehicle{where}" if where else ""
            notes.append(f"{self.objective_label.capitalize()}: {self.problem.base_objective}{at}.")
        if self.bound is not None:
            nominal = " at the nominal vehicle" if self.problem.points else ""
            if stand_in(self.problem) is not None:
                nominal += f", on the filter near {self.problem.vehicle.irregularity},"
            whole = self.bound.metric == self.problem.base_objective
            notes += [] if whole else [f"The bound is on {self.bound.metric}, than which the worst is no smaller."]
            notes += [
                f"Proven: {self.bound.metric} ≥ {self.bound.value:.5g} {self.bound.unit} over the whole band{nominal} "
                f"for {self.bound.devices}.",
                "Gap: how far that is below the row"
                + ("." if self.shares_figure else ", whose own figure over the whole band is taken for it."),
            ]
            if self.bound.attained is not None:
                notes.append(
                    f"Reached: {self.bound.attained.value:.5g} {self.bound.unit} by a passive device of order "
                    f"{self.bound.attained.device.order}; what a row is above that is the price of its order."
                )
        return [*notes, *self.notes, *(f"Subject to {constraint}." for constraint in self.problem.constraints)]

    def to_dict(self) -> dict[str, Any]:
        """JSON-able rows, each with its gap to the bound; `bound` is null where no bound is known."""
        rows = [row.to_dict() | {"gap_percent": self.gap(row)} for row in self.rows]
        bound = None if self.bound is None else self.bound.to_dict()
        kept = None if bound is None else {key: bound[key] for key in ("bound", "best", "gap_percent", "reached")}
        about = {"conditions": conditions(self.problem), "cautions": cautions(self.problem)}
        return {"problem": self.problem.name, **about, "rows": rows, "bound": kept, "notes": list(self.notes)}


def _bound(problem: Problem, progress: Callable[[str], None] | None) -> Bound:
    """A bound on the objective; on the worst of several figures, the best of the bounds on each."""
    goal = problem.goal
    if goal is None or goal.kind != "worst":
        return prove(problem, effort=0, both_sides=True, progress=progress)
    parts = [replace(problem, objective=name, goal=None, points=()) for name, _ in goal.parts]
    return max(
        (prove(part, effort=0, both_sides=True, progress=progress) for part in parts), key=lambda bound: bound.value
    )


def _drawn(network: Network, problem: Problem, ascii: bool) -> str:
    return diagram(network, terminals(problem), ascii=ascii)


def compare(
    problem: Problem | str,
    *,
    orders: Sequence[int] = (1, 2),
    seed: int = 0,
    jobs: int = 1,
    progress: Callable[[str], None] | None = None,
) -> Comparison:
    """Compare the default suspension, all layouts that fit, and synthesised devices of some orders.

    Parameters
    ----------
    problem : Problem, or the name of one
    orders : sequence of int
        Orders of the synthesised devices; each starts from the one before.
    seed, jobs : int
    progress : function of str, optional

    Returns
    -------
    Comparison
        Synthesised rows hold their networks, with the networks' own figures.

    Raises
    ------
    Infeasible
        If nothing that was tried keeps the constraints.
    """

    def say(text: str) -> None:
        if progress is not None:
            progress(text)

    problem = as_problem(problem)
    rows: list[Design] = []
    notes: list[str] = []
    if problem.default_port is not None:
        rows.append(evaluate(problem, None, label=problem.place.default_label))
    for entry in layouts():
        if entry.fits(problem):
            say(f"optimising {entry.name}")
            try:
                rows.append(optimise(problem, entry, seed=seed, jobs=jobs, any_values=True))
            except (Infeasible, BadInput) as reason:
                notes.append(f"{entry.name}: {reason}.")
    warm: list[Any] = []
    for order in orders:
        say(f"synthesising order {order}")
        try:
            design = synthesise(problem, order, seed=seed, warm=warm, jobs=jobs, progress=progress)
        except Infeasible as reason:
            notes.append(f"Order {order}: {reason}.")
            continue
        warm.append(design.device)
        say(f"realising order {order}")
        rows.append(realised(design)[0])
    notes += [f"{row.label}: {caveat}." for row in rows for caveat in caveats(row)]
    beyond = {row.label: row.outside for row in rows if row.outside}
    if beyond:
        said = "; ".join(f"{label}: {', '.join(str(one) for one in outside)}" for label, outside in beyond.items())
        notes.append(f"Outside what can usually be bought: {said}.")
    if not any(row.feasible for row in rows):
        kept = listed(problem.constraints).replace(" or ", " and ")
        raise Infeasible(f"neither a layout nor a synthesised device was found that keeps {kept}")
    say("proving a bound")
    try:
        bound = _bound(problem, progress)
    except BadInput as reason:
        return Comparison(problem, tuple(rows), notes=(*notes, f"No bound: {reason}."))
    best = min((row for row in rows if row.feasible), key=lambda row: bound.figure.measure(row.port))
    for row in rows:
        bound.require_not_below(row)
    return Comparison(problem, tuple(rows), bound.beside(best), tuple(notes))
