"""A recommendation as one page of HTML that an engineer can hand on: tables, plots and drawing in a single file.

The page loads nothing: style and pictures are in it. It is set for the screen and for paper (A4).
"""

from __future__ import annotations

import math
from base64 import b64encode
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from posreal.files import require_writable, write_whole
from posreal.metric import ClosedVehicle
from posreal.network.picture import picture
from posreal.specification.conditions import cautions, in_words
from posreal.study import recommendation_text as words
from posreal.study.comparison_figure import figure_of
from posreal.study.drawing import sheet, svg
from posreal.study.metric_table import metric_table
from posreal.study.pareto import Pareto
from posreal.study.strut import terminals
from posreal.text_table import counted, html
from posreal.units import engineering

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from posreal.study.recommendation import Recommendation
    from posreal.study.tolerance_result import Share

SUFFIXES = (".html", ".htm")
_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #1d2433; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: 0.2rem; }
h2 { font-size: 1.2rem; margin-top: 2.2rem; border-bottom: 1px solid #ccd; }
.build { background: #eef4fb; border-left: 4px solid #2a6db0; padding: 0.8rem 1rem; font-size: 1.1rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: 0.8rem 0; font-variant-numeric: tabular-nums; font-size: 0.86rem; }
th, td { padding: 0.18rem 0.6rem; text-align: right; white-space: nowrap; } th { border-bottom: 1px solid #889; }
td:first-child, th:first-child { text-align: left; } tr:nth-child(even) td { background: #f6f7fa; }
caption { text-align: left; color: #556; padding-bottom: 0.3rem; }
img { max-width: 100%; height: auto; } figure { margin: 1rem 0; } figcaption, .note { color: #556; font-size: 0.88rem; }
@media print {
  body { margin: 0; max-width: none; font-size: 11px; }
  h2 { break-after: avoid; }
  figure, table { break-inside: avoid; }
}
"""


def page(of: Recommendation) -> str:
    """The whole document."""
    title = escape(f"{of.problem.name}: the network to build")
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{_STYLE}</style></head>\n<body>\n{body(of)}\n</body></html>\n"
    )


def save(of: Recommendation, path: str | Path) -> Path:
    """Write the page, whole or not at all.

    Raises
    ------
    BadInput
        If the file's ending is not .html, or it cannot be written.
    """
    return write_whole(require_writable(Path(path), SUFFIXES), page(of).encode())


def body(of: Recommendation) -> str:
    """What stands on the page."""
    problem = of.problem
    parts = [
        f"<h1>{escape(problem.name)}</h1>",
        _paragraph(f"{problem.summary[:1].upper()}{problem.summary[1:]}, {in_words(problem)}."),
        *(_paragraph(note, "note") for note in words.asked_for(of)),
        *(_paragraph(f"Caution: {one}.", "note") for one in cautions(problem)),
        _paragraph(words.headline(of), "build"),
        _image(picture(of.strut, terminals(problem)), "The strut, with what the vehicle has of it already"),
        _table(*words.parts_table(of)),
        _list(words.verdict(of)),
        "<h2>What it does</h2>",
        _table(*metric_table(of.recommended)[:2]),
        _list([f"{c}: {c.verdict(of.recommended.metrics)}" for c in problem.constraints]),
        *_densities(of),
        "<h2>What was compared</h2>",
        _table(*of.comparison.table()),
        _list(words.compared(of)),
        _plot(figure_of(of.comparison), "Designs, and what is proven"),
        "<h2>What each part buys</h2>",
        _paragraph(f"Networks of up to {counted(of.search.elements, 'element')} {words.values_of(of)}."),
        _table(*words.front_table(of)),
        _plot(Pareto(of.search).figure(), "The best network of each number of elements"),
        "<h2>Within tolerances</h2>",
        *_tolerances(of),
    ]
    return "\n".join(parts)


def _tolerances(of: Recommendation) -> list[str]:
    found = of.tolerance
    varied = ", ".join(f"{part.name} ±{100 * part.tolerance:g} %" for part in found.variation.parts)
    rows = [
        [name, *(_number(value) for value in (one.nominal, one.p5, one.p50, one.p95, one.worst)), one.unit]
        for name, one in found.spreads.items()
    ]
    said = [f"{name}: kept by {_share(one)}" for name, one in found.yields.items()]
    if found.better is not None:
        said.append(f"better than the default suspension as drawn: {_share(found.better)}")
    return [
        _paragraph(
            f"{found.draws} vehicles, drawn evenly within {varied} (seed {found.seed}); the worst of them and of "
            f"{found.corners} of {found.of_corners} corners."
        ),
        _table(["metric", "nominal", "p5", "p50", "p95", "worst", "unit"], rows),
        _list(said),
        *_variance(of),
    ]


def _variance(of: Recommendation) -> list[str]:
    shares = of.tolerance.shares.get(of.problem.objective, {})
    if not shares:
        return []
    rows = [
        [part.name, engineering(part.nominal, part.unit, 4), f"{100 * shares.get(part.name, 0.0):.1f} %"]
        for part in of.tolerance.variation.parts
    ]
    rows.append(["several together", "", f"{100 * max(0.0, 1 - sum(shares.values())):.1f} %"])
    return [_table(["part", "nominal", f"share of the variance of {of.problem.objective}"], rows)]


def _densities(of: Recommendation) -> list[str]:
    """The density of the objective's output, of the default suspension and of the network to build."""
    problem = of.problem
    metric = problem.vehicle.metrics.get(problem.base_objective)
    norm = None if metric is None else metric.norm()
    if norm is None or norm.kind != "H2":
        return []
    there = problem.vehicle if norm.speed is None else problem.vehicle.at(norm.speed)
    hertz = np.geomspace(0.1, 60.0, 800)
    figure, (axis,) = sheet(8.4, 3.4)
    shown: dict[str, Any] = {problem.place.default_label: problem.original.default_port}
    shown[f"{len(of.network)} elements"] = of.recommended.port
    factor = norm.factor(there)
    for label, port in shown.items():
        if port is not None:
            closed = ClosedVehicle(there, {"secondary": port}).on(norm.load)
            density = closed.density(norm.output, 2 * math.pi * hertz) * 2 * math.pi * factor**2
            axis.loglog(hertz, density, label=label)
            axis.set_ylim(bottom=max(axis.get_ylim()[0], 1e-7 * float(density.max())))
    axis.axvline(20.0, color="0.6", linewidth=0.8, linestyle=":")
    axis.set(xlabel="Hz", ylabel=f"({of.recommended.objective.unit})²/Hz")
    axis.legend(fontsize=8)
    return [_plot(figure, f"Density of what {problem.base_objective} sums over frequency; dotted, 20 Hz")]


def _number(value: float | None) -> str:
    return "unstable" if value is None else f"{value:#.5g}"


def _share(one: Share) -> str:
    low, high = one.interval
    return f"{100 * one.fraction:.1f} % of the vehicles ({100 * low:.1f} … {100 * high:.1f} % with 95 % confidence)"


def _paragraph(text: str, kind: str = "") -> str:
    return f"<p{f' class={kind!r}' if kind else ''}>{escape(text)}</p>"


def _list(sentences: list[str]) -> str:
    return "<ul>" + "".join(f"<li>{escape(one)}</li>" for one in sentences) + "</ul>" if sentences else ""


def _table(header: list[str], rows: list[list[str]]) -> str:
    return f'<div class="wide">{html(header, rows)}</div>'


def _plot(figure: Figure, caption: str) -> str:
    return _image(svg(figure), caption)


def _image(content: bytes, caption: str) -> str:
    data = b64encode(content).decode()
    text = escape(caption)
    return f'<figure><img alt="{text}" src="data:image/svg+xml;base64,{data}"><figcaption>{text}</figcaption></figure>'
