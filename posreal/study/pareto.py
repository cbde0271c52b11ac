"""Parts against performance: what every further element buys, beside the fixed layouts and the synthesised devices.

Elements are counted as a designer buys them: without the bush or the static spring, which the vehicle has anyway. A
synthesised device of order n is the best of *any* network of degree n, so it tells how much a network leaves on the
table for being small; a bound tells how much anything does.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from posreal.errors import BadInput, Infeasible
from posreal.network.diagram import diagram
from posreal.optimisation.layout_values import optimise
from posreal.ranges import written
from posreal.specification.conditions import cautions, in_words
from posreal.specification.design import Design
from posreal.specification.layout import layout, layouts
from posreal.study.drawing import save, sheet
from posreal.study.strut import mounted, terminals
from posreal.synthesis.synthesise import synthesise
from posreal.text_table import percent, table
from posreal.topology.result import FrontPoint, Search, short
from posreal.vehicle import whole_band_twin

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class Pareto:
    """A search and what it is held against.

    Attributes
    ----------
    search : Search
    layouts : tuple of Design
        Layouts at their optima.
    syntheses : tuple of Design
        Synthesised devices, by order.
    bound : float or None
        A lower bound over all devices, in the objective's unit.
    notes : tuple of str
        Why a layout is missing.
    """

    search: Search
    layouts: tuple[Design, ...] = ()
    syntheses: tuple[Design, ...] = ()
    bound: float | None = None
    notes: tuple[str, ...] = ()

    def above_synthesis(self, point: FrontPoint) -> float | None:
        """Per cent by which a network is worse than the best synthesised device of its degree or less."""
        reached = [d.objective.value for d in self.syntheses if d.order <= point.design.order]
        if not reached or max(d.order for d in self.syntheses) < point.design.order:
            return None
        return 100 * (point.design.objective.value / min(reached) - 1)

    def __repr__(self) -> str:
        return f"<Pareto front of {self.search!r}>"

    def __str__(self) -> str:
        return self.text()

    def _repr_html_(self) -> str:
        return self.search._repr_html_()

    def to_frame(self) -> Any:
        """The front as a ``pandas.DataFrame``; see :meth:`Search.to_frame`."""
        return self.search.to_frame()

    def text(self, *, ascii: bool = False) -> str:
        """The front as a table, with the best network drawn, its equivalents and the runners-up."""
        search, problem = self.search, self.search.problem
        unit, twin = search.best.objective.unit, whole_band_twin(problem.vehicle, problem.base_objective)
        has_synthesis = bool(self.syntheses)
        header = ["elements", "network", f"{problem.objective} [{unit}]", "better", "degree", "k+c+b"]
        header += [] if twin is None else [f"over all frequencies [{unit}]"]
        header += [f"{search.metric} [{search.best.metrics[search.metric].unit}]"] if search.metric else []
        real = problem.elements is not None
        header += [f"ideal [{unit}]"] if real else []
        header += ["above synthesis"] if has_synthesis else []
        rows = []
        for point in search.front:
            gap = self.above_synthesis(point)
            row = [
                str(point.elements),
                str(point.network.topology()),
                f"{point.design.objective.value:#.5g}",
                percent(point.design.improvement()),
                str(point.design.order),
                "+".join(str(count) for count in point.network.counts[:3]),
            ]
            row += [] if twin is None else [f"{point.design.metrics[twin].value:#.5g}"]
            row += [f"{point.design.metrics[search.metric].value:#.5g}"] if search.metric else []
            row += [_of_ideal(point)] if real else []
            row += [percent(gap)] if has_synthesis else []
            rows.append(row)
        words = in_words(problem)
        lines = [f"{problem.name}: networks of up to {search.elements} elements in the device's place"]
        lines += [*([f"  {words}"] if words else []), "", table(header, rows, "ll"), ""]
        lines += [f"  Caution: {one}." for one in cautions(problem)]
        lines += [f"  {note}" for note in self._notes()]
        best = min(search.front, key=lambda point: point.design.objective.value)
        lines += ["", f"  Best network ({best.design.objective}):", "", _drawn(best, ascii)]
        lines += [f"  {name} = {best.design.parameters[name]:.6g}" for name in problem.free]
        if best.equivalent:
            lines += ["", "  The same admittance, built otherwise:"]
            lines += [f"    {short(network)}" for network in best.equivalent]
        if best.others:
            lines += ["", f"  Next best of {_count(best.elements)}:"]
            lines += [f"    {other.objective:#.5g}  {short(other.network)}" for other in best.others]
        return "\n".join(lines)

    def _notes(self) -> list[str]:
        search, problem = self.search, self.search.problem
        notes = [f"Subject to {constraint}." for constraint in problem.constraints]
        if problem.elements is not None:
            notes += [
                f"Real elements: {problem.elements}.",
                "Ideal: the same values without what comes with them; degree is that of the real network.",
            ]
        notes += [
            f"{_count(point.elements)}: {note}." for point in search.front for note in point.design.found["notes"]
        ]
        found = {point.elements for point in search.front}
        nothing = [str(n) for n in range(1, search.elements + 1) if n not in found]
        if nothing:
            notes.append(f"Nothing better than fewer elements was found with {', '.join(nothing)}.")
        total = sum(tally.topologies for tally in search.tallies)
        redundant = sum(tally.redundant for tally in search.tallies)
        reduced = sum(tally.reduced for tally in search.tallies)
        notes.append(
            f"{total} topologies: {redundant} left out because another does all they can do, "
            f"{reduced} whose best values make them a smaller one."
        )
        notes += [
            f"{design.label} ({_count(_bought(design))}): {design.objective.value:#.5g}." for design in self.layouts
        ]
        notes += self.notes
        if (self.layouts or self.syntheses) and problem.without_limits is not search.problem:
            notes.append("Layouts and synthesised devices are the best without the limits given.")
        if search.bounds:
            usual = problem.usual is not None and search.bounds == problem.usual.by_kind
            said = ", what can usually be bought; --any-values lifts that" if usual else ""
            notes.append(f"Values from {written(search.bounds)}{said}.")
        if self.bound is not None:
            notes.append(f"No passive device is better than {self.bound:#.5g}.")
        return notes

    def to_dict(self) -> dict[str, Any]:
        """JSON-able: the search, and beside it what it is held against."""
        document = self.search.to_dict()
        for point, entry in zip(self.search.front, document["front"], strict=True):
            entry["above_synthesis_percent"] = self.above_synthesis(point)
            entry["diagram"] = _drawn(point, False)
        document["layouts"] = [{"elements": _bought(d), **d.to_dict()} for d in self.layouts]
        document["syntheses"] = [d.to_dict() for d in self.syntheses]
        document["bound"] = self.bound
        return document

    def draw(self, path: str | Path) -> Path:
        """Draw the front into a file, whose ending decides the format.

        Raises
        ------
        BadInput
            If the file cannot be written in the format of its ending.
        Infeasible
            If there is no network to draw.
        """
        return save(self.figure(), path)

    def figure(self) -> Figure:
        """The picture on a sheet of its own.

        Raises
        ------
        Infeasible
            If there is no network to draw.
        """
        self.search.require_any()
        figure, (axis,) = sheet(8.4, 5.2)
        if self.search.metric is None:
            self._over_elements(axis)
        else:
            self._over_metric(axis)
        problem = self.search.problem
        axis.set_ylabel(f"{problem.objective} [{self.search.best.objective.unit}]")
        axis.set_title(f"{problem.name}: {problem.summary}", fontsize=10)
        return figure

    def _over_elements(self, axis: Any) -> None:
        front = self.search.front
        last = self.search.elements
        xs = [point.elements for point in front]
        ys = [point.design.objective.value for point in front]
        axis.plot([*xs, last + 0.95], [*ys, ys[-1]], drawstyle="steps-post", color="C0", linewidth=1.2)
        axis.plot(xs, ys, "o", color="C0", label="best network found")
        twin = whole_band_twin(self.search.problem.vehicle, self.search.problem.base_objective)
        beside = [] if twin is None else [point.design.metrics[twin].value for point in front]
        if beside:
            axis.plot(xs, beside, "o", color="C0", markerfacecolor="white", label="the same over all frequencies")
        for point, x, y in zip(front, xs, ys, strict=True):
            axis.annotate(
                f"{y:#.5g}\n{_topology(point)}",
                (x, y),
                xytext=(6, 5),
                textcoords="offset points",
                fontsize=7,
                color="C0",
                bbox={"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.85},
            )
        low, high = min([*ys, *([] if self.bound is None else [self.bound])]), max([*ys, *beside])
        for design in self.layouts:
            x, y = _bought(design), design.objective.value
            high = max(high, y)
            axis.plot(x, y, "D", markerfacecolor="white", color="C3", markersize=5, zorder=3)
            axis.annotate(
                design.label, (x, y), xytext=(-5, 4), textcoords="offset points", fontsize=8, color="C3", ha="right"
            )
        for design in self.syntheses:
            y = design.objective.value
            low, high = min(low, y), max(high, y)
            axis.axhline(y, color="0.45", linewidth=0.8, linestyle="--", zorder=1)
            axis.annotate(
                f"best found of order {design.order}",
                (0.55, y),
                xytext=(4, 2),
                textcoords="offset points",
                fontsize=7,
                color="0.35",
            )
        if self.bound is not None:
            axis.axhline(self.bound, color="C2", linewidth=1.4)
            axis.axhspan(self.bound - (high - low), self.bound, color="C2", alpha=0.12, linewidth=0)
            axis.annotate(
                "no passive device below", (1.0, self.bound), xytext=(0, 3), textcoords="offset points", fontsize=7,
                color="C2",
            )  # fmt: skip
        margin = 0.08 * (high - low) or 0.05 * high
        axis.set(xlim=(0.55, last + 0.95), ylim=(low - margin, high + 2 * margin), xticks=range(1, last + 1))
        axis.set_xlabel("elements in the device's place")
        if self.layouts:
            axis.plot([], [], "D", markerfacecolor="white", color="C3", markersize=5, label="layouts at their optima")
        axis.legend(fontsize=8, loc="upper right")

    def _over_metric(self, axis: Any) -> None:
        search = self.search
        assert search.metric is not None
        for i, elements in enumerate(sorted({point.elements for point in search.front})):
            points = [point.design for point in search.front if point.elements == elements]
            pairs = sorted((d.metrics[search.metric].value, d.objective.value) for d in points)
            axis.plot(
                *zip(*pairs, strict=True),
                "o-",
                color=f"C{i}",
                label=_count(elements),
                markersize=4,
            )
        for design in self.layouts:
            point = design.metrics[search.metric].value, design.objective.value
            axis.plot(*point, "D", markerfacecolor="white", color="C3", markersize=5, zorder=3)
            axis.annotate(design.label, point, xytext=(5, 3), textcoords="offset points", fontsize=8, color="C3")
        axis.set_xlabel(f"{search.metric} [{search.best.metrics[search.metric].unit}]")
        axis.legend(fontsize=8)


def pareto(
    search: Search,
    *,
    orders: Sequence[int] = (),
    bound: float | None = None,
    seed: int = 0,
    jobs: int = 1,
    progress: Callable[[str], None] | None = None,
) -> Pareto:
    """Put a search beside the layouts that fit its problem, synthesised devices and a bound.

    Parameters
    ----------
    search : Search
    orders : sequence of int
        Orders of synthesised devices; each starts from the one before.
    bound : float, optional
    seed, jobs : int
    progress : function of str, optional

    Raises
    ------
    Infeasible
        If the search found nothing.
    """
    search.require_any()
    problem = search.problem.without_limits
    fitting = [entry for entry in layouts() if entry.fits(problem)]
    any_values = problem.usual is None or not set(problem.usual.by_kind) <= set(search.bounds)
    optima, notes = list[Design](), list[str]()
    for entry in fitting:
        if progress is not None:
            progress(f"optimising {entry.name}")
        try:
            optima.append(optimise(problem, entry, seed=seed, jobs=jobs, any_values=any_values))
        except (Infeasible, BadInput) as reason:
            notes.append(f"{entry.name}: {reason}.")
    made: list[Design] = []
    for order in orders:
        if progress is not None:
            progress(f"synthesising order {order}")
        warm = [design.device for design in made]
        made.append(synthesise(problem, order, seed=seed, warm=warm, progress=progress))
    return Pareto(search, tuple(optima), tuple(made), bound, tuple(notes))


def _bought(design: Design) -> int:
    """Elements of a layout besides the one that stands for a part of the vehicle."""
    assert design.bought is not None
    rules = layout(design.label).rules
    return len(design.bought) - sum(rule.role is not None for rule in rules.values())


def _count(elements: int) -> str:
    return "1 element" if elements == 1 else f"{elements} elements"


def _of_ideal(point: FrontPoint) -> str:
    """The objective of the same values in ideal elements."""
    ideal, name = point.design.ideal, point.design.problem.objective
    return "–" if ideal is None or name not in ideal.metrics else f"{ideal.metrics[name].value:#.5g}"


def _topology(point: FrontPoint) -> str:
    """A line for the picture, which has no room for a bridge's branches."""
    text = str(point.network.topology())
    return text if "{" not in text else f"bridge of {point.elements}"


def _drawn(point: FrontPoint, ascii: bool) -> str:
    problem = point.design.problem
    return diagram(mounted(problem, point.network), terminals(problem), ascii=ascii)
