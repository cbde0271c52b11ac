"""``posreal problems`` and ``posreal layouts``: what there is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from posreal.cli.options import Ascii, AsJson, At, ProblemName, VehicleFile, posed
from posreal.cli.output import drawn, print_json
from posreal.errors import BadInput

if TYPE_CHECKING:
    from posreal.specification.layout import Layout


def problems(as_json: AsJson = False) -> None:
    """List the design problems."""
    from posreal.specification.named import problems as named
    from posreal.text_table import table

    entries = named()
    if as_json:
        print_json(
            {
                "problems": [
                    {
                        "name": p.name,
                        "summary": p.summary,
                        "objective": p.objective,
                        "keep": list(p.keep),
                        "free": {name: [r.lower, r.upper] for name, r in p.free.items()},
                        "vehicle": p.vehicle.name,
                    }
                    for p in entries
                ]
            }
        )
        return
    rows = [[p.name, p.objective, ", ".join(p.keep) or "–", ", ".join(p.free) or "–", p.summary] for p in entries]
    print(table(["problem", "minimises", "keeps", "frees", ""], rows, "lllll"))


def vehicle(
    name: Annotated[str, typer.Argument(help="A vehicle, a problem for its vehicle, or a TOML file.")],
    file: VehicleFile = None,
    as_json: AsJson = False,
) -> None:
    """Parameters of a vehicle with unit, default and source, its places and its metrics."""
    from posreal.specification.named import vehicle as named
    from posreal.text_table import table
    from posreal.vehicle import described, parameters

    model, default = named(name, file), named(name)
    rows = list(described(model)) if parameters(model) else []
    defaults = parameters(default)
    if as_json:
        print_json(
            {
                "vehicle": model.name,
                "parameters": {
                    n: {"value": value, "unit": unit, "default": defaults[n], "meaning": meaning, "source": source}
                    for n, value, unit, meaning, source in rows
                },
                "places": list(model.places),
                "elements": {n: p.elements.to_dict() for n, p in model.places.items() if p.elements is not None},
                "usual": {n: place.usual.to_dict() for n, place in model.places.items() if place.usual is not None},
                "metrics": {n: metric.unit for n, metric in model.metrics.items()},
            }
        )
        return
    changed = file is not None
    header = ["parameter", "value", *(["default"] if changed else []), "unit", "", "source"]
    body = [
        [n, f"{value:.10g}", *([f"{defaults[n]:.10g}"] if changed else []), _unit(unit), meaning, f"[{source}]"]
        for n, value, unit, meaning, source in rows
    ]
    print(f"{model.name}\n")
    print(table(header, body, "lrrlll" if changed else "lrlll"))
    print(f"\n  places: {', '.join(model.places)}")
    for n, place in model.places.items():
        if place.usual is not None:
            print(f"  usual at {n}: {place.usual}")
        if place.elements is not None:
            print(f"  real elements at {n}: {place.elements}")
    print(f"  metrics: {', '.join(f'{n} [{metric.unit}]' for n, metric in model.metrics.items())}")


def _unit(text: str) -> str:
    return "" if text == "1" else text.replace("*", " ")


def layouts(
    name: Annotated[str | None, typer.Argument(help="A layout's name, or a TOML file.")] = None,
    as_json: AsJson = False,
    ascii: Ascii = False,
) -> None:
    """List the fixed layouts, or draw one."""
    from posreal.specification.layout import layout
    from posreal.specification.layout import layouts as shipped
    from posreal.specification.named import problem
    from posreal.text_table import table

    if name is None:
        entries = shipped()
        if as_json:
            print_json({"layouts": [_layout_dict(entry) for entry in entries]})
        else:
            print(table(["layout", "network", ""], [[e.name, str(e.network), e.description] for e in entries], "lll"))
        return
    entry = layout(name)
    if as_json:
        print_json(_layout_dict(entry))
        return
    lines = [f"{entry.name}: {entry.description}\n{entry.network}    [{entry.source}]\n", drawn(entry.network, ascii)]
    for row in entry.published:
        valued = entry.network.with_values(row.values)
        figures = ", ".join(f"{metric} = {value:g}" for metric, value in row.figures.items())
        tuned = "".join(f", {parameter} = {value:g}" for parameter, value in row.vehicle.items())
        note = f" ({row.note})" if row.note else ""
        lines.append(f"\nTable {row.table}, {problem(row.problem).name}: {figures} at {valued}{tuned}{note}")
    print("\n".join(lines))


def ranges(problem: ProblemName, vehicle: VehicleFile = None, at: At = None, as_json: AsJson = False) -> None:
    """Print what can usually be bought for a problem's place, as the TOML file that --ranges takes."""
    posed_problem = posed(problem, vehicle, at=at)
    usual = posed_problem.usual
    if usual is None:
        raise BadInput(f"{posed_problem.name} has no usual ranges; --ranges FILE gives it some")
    print_json({"problem": posed_problem.name, "ranges": usual.to_dict()}) if as_json else print(usual.to_toml())


def _layout_dict(entry: Layout) -> dict[str, Any]:
    return {
        "name": entry.name,
        "network": str(entry.network),
        "description": entry.description,
        "source": entry.source,
        "published": [
            {"table": r.table, "problem": r.problem, "values": r.values, "vehicle": r.vehicle, "figures": r.figures}
            for r in entry.published
        ],
    }
