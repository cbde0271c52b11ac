"""A tolerance study as text: the spread of each figure, the yield of each constraint, what they hang on."""

from __future__ import annotations

from typing import TYPE_CHECKING

from posreal.text_table import table
from posreal.units import engineering

if TYPE_CHECKING:
    from posreal.study.tolerance_result import Share, Tolerance

_UNSTABLE = "unstable"


def text(of: Tolerance) -> str:
    """What varies, the spreads, the yields, and each part's share of the variance."""
    problem, parts = of.design.problem, of.variation.parts
    limited = list(dict.fromkeys([problem.objective, *(c.metric for c in problem.constraints if not c.nominal)]))
    lines = [
        f"{of.draws} draws (seed {of.seed}), every value even within its tolerance; {_corners(of)}.",
        "",
        table(["metric", "nominal", "p5", "p50", "p95", "worst", "unit"], _spreads(of), "lrrrrrl"),
        "",
    ]
    for name in limited:
        spread = of.spreads[name]
        at = ", ".join(f"{part.name} = {engineering(spread.worst_at[part.name], part.unit)}" for part in parts)
        lines.append(f"  {name} is worst with {at}")
        lines += [
            f"  {key} of {name}: {low:#.5g} … {high:#.5g} with 95 % confidence"
            for key, (low, high) in spread.intervals.items()
        ]
    lines += ["", *_yields(of)]
    shown = [name for name in limited if name in of.shares]
    if shown:
        lines += ["", "Share of the variance, and what the greatest value changes:", _shares(of, shown)]
    if of.apart > 5e-7:
        lines += ["", f"Draws are computed one way; confirmed ones differ by up to {of.apart:.1e} of the figure."]
    return "\n".join(lines)


def _corners(of: Tolerance) -> str:
    if of.corners == of.of_corners:
        return f"worst of them and of all {of.corners} corners"
    return f"worst of them and of {of.corners} corners of {of.of_corners}, by ascent from one to the next"


def _spreads(of: Tolerance) -> list[list[str]]:
    rows = []
    for name, one in of.spreads.items():
        numbers = (one.nominal, one.p5, one.p50, one.p95, one.worst)
        rows.append([name, *(_UNSTABLE if value is None else f"{value:#.5g}" for value in numbers), one.unit])
    return rows


def _yields(of: Tolerance) -> list[str]:
    lines = [f"  {name}: kept by {_share(one)}" for name, one in of.yields.items()]
    if of.kept is not None and len(of.yields) > 1:
        lines.append(f"  all constraints: kept by {_share(of.kept)}")
    if of.stable.count < of.draws:
        lines.append(f"  stable: {_share(of.stable)}")
    if of.better is not None:
        lines.append(f"  better than the default suspension as drawn: {_share(of.better)}")
    return lines


def _share(one: Share) -> str:
    low, high = one.interval
    return f"{100 * one.fraction:.1f} % of the vehicles ({100 * low:.1f} … {100 * high:.1f} % with 95 % confidence)"


def _shares(of: Tolerance, metrics: list[str]) -> str:
    header = ["part", "nominal", "tolerance"]
    for name in metrics:
        header += [name, f"[{of.spreads[name].unit}]"]
    rows = []
    for part in of.variation.parts:
        row = [part.name, engineering(part.nominal, part.unit, 4), f"±{100 * part.tolerance:g} %"]
        for name in metrics:
            row += [f"{100 * of.shares[name][part.name]:.1f} %", f"{of.effects[name][part.name]:+.3g}"]
        rows.append(row)
    rest = ["several together", "", ""]
    for name in metrics:
        rest += [f"{100 * max(0.0, 1 - sum(of.shares[name].values())):.1f} %", ""]
    return table(header, [*rows, rest], "lrr" + "rr" * len(metrics))
