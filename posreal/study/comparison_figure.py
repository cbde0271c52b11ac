"""A comparison as a picture: a row a design, its figure as a dot, the proven bound as a line, the gap in words.

A bound is over all frequencies. Where the objective is too, dots and line share one figure. Where it is not (ride to
20 Hz, the worst of several operating points), every design has a second dot, hollow: its own figure over all
frequencies at the nominal point, and the gap is measured from that one.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from posreal.study.drawing import save, sheet
from posreal.study.strut import strut

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from posreal.study.compare import Comparison

_OBJECTIVE, _BOUND = "C0", "C2"


def draw(comparison: Comparison, path: str | Path) -> Path:
    """Draw into a file, whose ending (.png, .svg or .pdf) decides the format.

    Raises
    ------
    BadInput
        If the file cannot be written.
    """
    return save(figure_of(comparison), path)


def figure_of(comparison: Comparison) -> Figure:
    """The picture on a sheet of its own."""
    rows = comparison.rows
    figure, (axis,) = sheet(8.4, 1.5 + 0.4 * len(rows), grid="x")
    axis.set_axisbelow(True)
    values = [row.objective.value for row in rows]
    places = list(range(len(rows)))[::-1]
    objective = comparison.objective_label
    timed = objective.startswith("max_")
    band = "" if comparison.problem.whole_band or timed else ", to 20 Hz"
    axis.plot(values, places, "o", color=_OBJECTIVE, label=f"{objective}{band}", zorder=3)
    low, high = min(values), max(values)
    if comparison.bound is not None:
        bound = comparison.bound
        beside = [bound.figure.measure(row.port) for row in rows]
        name = f"{bound.metric}, all frequencies" + (", nominal vehicle" if comparison.problem.points else "")
        if not comparison.shares_figure:
            axis.plot(beside, places, "o", color=_BOUND, markerfacecolor="white", label=name, zorder=2)
            axis.hlines(places, values, beside, color="0.8", linewidth=0.8, zorder=1)
        axis.axvline(
            bound.value, color=_BOUND, linewidth=1.6, label=f"proven: no passive device below {bound.value:#.5g}"
        )
        if bound.attained is not None:
            axis.axvline(
                bound.attained.value,
                color=_BOUND,
                linewidth=1.2,
                linestyle="--",
                label=f"reached by a device of order {bound.attained.device.order}: {bound.attained.value:#.5g}",
            )
        low, high = min(low, bound.value, *beside), max(high, *beside)
    margin = 0.06 * (high - low) or 0.05 * abs(high)
    room = 0.34 * (high - low) or 0.34 * abs(high)
    if comparison.bound is not None:
        axis.axvspan(low - margin, comparison.bound.value, color=_BOUND, alpha=0.1, linewidth=0)
    for row, place in zip(rows, places, strict=True):
        gap = comparison.gap(row)
        text = f"{row.objective.value:#.5g}" + ("" if gap is None else f"   gap {gap:.1f} %")
        text += "" if row.feasible else "   (breaks a constraint)"
        axis.annotate(text, (high, place), xytext=(12, 0), textcoords="offset points", va="center", fontsize=8)
    axis.set_yticks(places, [_named(row) for row in rows])
    axis.set(xlim=(low - margin, high + room), ylim=(-0.6, len(rows) - 0.4))
    axis.set_xlabel(f"{objective} [{rows[0].objective.unit}]")
    figure.suptitle(f"{comparison.problem.name}: {comparison.problem.summary}", fontsize=10)
    figure.legend(fontsize=8, loc="outside lower center", ncols=3, frameon=False)
    return figure


def _named(row: Any) -> str:
    network = strut(row)
    return row.label if network is None else f"{row.label} ({len(network)} elements)"
