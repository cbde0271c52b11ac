"""A recommendation as text: what was compared, what was found, and the network to build."""

from __future__ import annotations

from typing import TYPE_CHECKING

from posreal.network.diagram import diagram
from posreal.network.table import rows as parts
from posreal.specification.conditions import cautions, in_words, stand_in
from posreal.study.metric_table import metric_table
from posreal.study.strut import terminals
from posreal.text_table import counted, percent, table
from posreal.topology.result import short
from posreal.vehicle import parameters

if TYPE_CHECKING:
    from posreal.study.recommendation import Recommendation

_FEW = 0.95  # of the vehicles that are built


def text(of: Recommendation, *, ascii: bool = False) -> str:
    """Everything, the network to build last."""
    problem = of.problem
    words = in_words(problem)
    lines = [f"{problem.name}: {problem.summary}", *([f"  {words}"] if words else [])]
    lines += [f"  {note}" for note in asked_for(of)]
    lines += [f"  Caution: {one}." for one in cautions(problem)]
    lines += ["", table(*of.comparison.table()), "", *(f"  {note}" for note in compared(of))]
    lines += ["", f"Networks of up to {counted(of.search.elements, 'element')} {values_of(of)}:", ""]
    lines += [table(*front_table(of), "ll"), ""]
    lines += [headline(of), ""]
    lines += [diagram(of.strut, terminals(problem), ascii=ascii), ""]
    lines += [table(*parts_table(of), "lll"), ""]
    lines += [f"  {sentence}" for sentence in verdict(of)]
    lines += ["", table(*metric_table(of.recommended))]
    lines += [f"  {c}: {c.verdict(of.recommended.metrics)}" for c in problem.constraints]
    lines += ["", "Within tolerances:", str(of.tolerance)]
    return "\n".join(lines)


def asked_for(of: Recommendation) -> list[str]:
    """What was asked and what was designed for, where the two differ."""
    if of.problem.objective == of.asked.objective:
        return []
    return [
        f"{of.asked.base_objective} ends at 20 Hz, but what is built rings above it too: everything here is designed "
        f"for {of.problem.base_objective}, over all frequencies (--band-only designs to 20 Hz)."
    ]


def compared(of: Recommendation) -> list[str]:
    """What to know about the designs that were compared."""
    ideal = [] if of.problem.elements is None else ["The rows are of ideal elements: what is possible at best."]
    return [*ideal, *of.comparison.remarks()]


def values_of(of: Recommendation) -> str:
    """Of which values the networks are."""
    usual = of.problem.usual
    said = "of any values" if usual is None else f"of values that can usually be bought ({usual})"
    return said if of.problem.elements is None else f"{said}, and real elements ({of.problem.elements})"


def front_table(of: Recommendation) -> tuple[list[str], list[list[str]]]:
    """What each number of elements reaches."""
    unit = of.recommended.objective.unit
    header = ["elements", "network", f"{of.problem.objective} [{unit}]", "better", "k+c+b"]
    return header, [
        [
            str(point.elements),
            short(point.network),
            f"{point.design.objective.value:#.5g}",
            percent(point.design.improvement()),
            "+".join(str(count) for count in point.network.counts[:3]),
        ]
        for point in of.search.front
    ]


def headline(of: Recommendation) -> str:
    """One sentence: build this."""
    gain = of.recommended.improvement()
    better = "" if gain is None else f", {gain:.2f} % better than {of.problem.place.default_label}"
    count, ideal = counted(len(of.network), "element"), of.recommended.ideal
    name = of.problem.objective
    known = "" if ideal is None else f" (of ideal elements {ideal.metrics[name]})"
    return f"Build this: {count}, {name} {of.recommended.objective}{better}{known}."


def parts_table(of: Recommendation) -> tuple[list[str], list[list[str]]]:
    """What to order, and what the vehicle has already."""
    own = set(of.strut.names) - set(of.network.names)
    header = ["part", "kind", "value", "exactly", "unit", ""]
    return header, [
        [row.name, row.kind, row.value, row.exact, row.unit, "the vehicle has it" if row.name in own else "order"]
        for row in parts(of.strut, 4)
    ]


def verdict(of: Recommendation) -> list[str]:
    """What it reaches of what is possible, and what more parts would buy."""
    said = [
        f"The smallest network within {100 * of.within:g} % of the best found with up to "
        f"{counted(of.search.elements, 'element')}: {percent(of.above_best_percent)} above it, values rounded."
    ]
    bound, gap = of.comparison.bound, of.gap_percent
    if bound is not None and gap is not None:
        reached = of.above_reached_percent
        over = (
            "" if reached is None else f", and it is {reached:.1f} % above what a passive device of high order reaches"
        )
        near = f", on the filter near {of.problem.vehicle.irregularity}" if stand_in(of.problem) is not None else ""
        said.append(f"No passive device of any order is better by more than {gap:.1f} % (proven{near}){over}.")
    for name, share in of.tolerance.yields.items():
        if share.fraction < _FEW:
            said.append(
                f"Only {100 * share.fraction:.0f} % of the vehicles built within tolerances keep {name}: "
                f"posreal search {of.asked.name} --robust looks for values with which all do."
            )
    for point, gain in of.larger:
        said.append(f"{counted(point.elements, 'element')} would buy {gain:.2f} % more: {short(point.network)}.")
    if not of.larger:
        said.append("No larger network was found that is better.")
    tuned = {name: getattr(of.recommended.problem.vehicle, name) for name in of.problem.free}
    if tuned:
        units = parameters(of.problem.vehicle)
        said.append(
            "With " + ", ".join(f"{name} = {value:.5g}" for name, value in tuned.items() if name in units) + "."
        )
    if of.recommended.usual_sentence:
        said.append(of.recommended.usual_sentence)
    said += list(of.recommended.found.get("notes", ()))
    return said
